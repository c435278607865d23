//! Slip that runs away where no states settle: the states that were tried.

use super::Failure;
use super::active_set::Log;
use super::newton::{Attempt, Iterate};
use super::stability::{Holding, Instability, Slipping, instability};
use crate::contact::ContactState;
use fracas_solvers::Observer;
use std::collections::BTreeSet;

/// Share of its limit that the shear of a face has from which on it may be taken to begin to slip. Unit: 1.
const NEAR: f64 = 0.9;

/// Whether slip runs away at the states of the last round, or at those in which most faces that weaken slip: where it does Newton sends faces
/// back to stick, so that the last states may show nothing.
pub(super) fn tried(
    attempt: &Attempt<'_>,
    start: &Iterate,
    holding: &mut impl Holding,
    log: &Log,
    observer: &mut dyn Observer,
) -> Result<Option<Box<Instability>>, Failure> {
    let candidates = [&log.states, &log.most_slipping];
    let candidates = candidates.map(|states| near_limits(attempt, states, start, log));
    let differ = usize::from(candidates[0] != candidates[1]);
    for states in &candidates[..=differ] {
        match instability(
            attempt,
            (states, start),
            Slipping::FromRest,
            holding,
            observer,
        ) {
            Err(Failure::Stopped) => return Err(Failure::Stopped),
            Ok(Some(patch)) => return Ok(Some(patch)),
            // what fails here, too, says nothing
            Ok(None) | Err(_) => {}
        }
    }
    Ok(None)
}

/// The same states where only those faces slip that are near their limits in `x`, on fractures with a face that changes; faces that bear something
/// there do not open, so that what is found of slip that runs away is not of rounds that went astray.
fn near_limits(
    attempt: &Attempt<'_>,
    states: &[ContactState],
    x: &Iterate,
    log: &Log,
) -> Vec<ContactState> {
    let problem = attempt.problem;
    let fracture = |f: usize| problem.faces()[f].fracture;
    let changing: BTreeSet<u16> = log.changing.iter().map(|f| fracture(*f)).collect();
    let near = states.iter().enumerate().map(|(f, state)| {
        let [normal, shear] = [x.t[3 * f], x.t[3 * f + 1].hypot(x.t[3 * f + 2])];
        if normal == 0.0 && shear == 0.0 {
            return ContactState::Open;
        }
        let slip = problem.so_far(f, attempt.start).slip();
        let limit = problem.friction_in(f, attempt.start).limit(normal, slip);
        let is_near = shear >= NEAR * limit;
        let may = is_near && (changing.is_empty() || changing.contains(&fracture(f)));
        match state {
            ContactState::Stick => ContactState::Stick,
            _ if may => ContactState::Slip,
            _ => ContactState::Stick,
        }
    });
    near.collect()
}
