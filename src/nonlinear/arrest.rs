//! Where slip that runs away comes to rest: limits that follow it step by step.

use super::active_set::{Log, Settled};
use super::newton::{Attempt, Iterate};
use super::stability::Holding;
use super::{Failure, Start};
use crate::contact::ContactState;
use crate::scene::Unstable;
use fracas_operators::vector::dot;
use fracas_solvers::Observer;

/// Passes at most.
const PASSES: usize = 80;

/// Largest growth of what a pass adds to slip. Unit: 1.
const GROWTH: f64 = 3.0;

/// Passes, one of which goes farther: the others smooth what that amplifies. Unit: 1.
const SMOOTH: usize = 5;

/// Shares of what a pass adds that the next one starts with. Unit: 1.
const SHARES: [f64; 2] = [0.25, 10.0];

/// Where `reason` has kept states from settling and the scene asks for the arrested state: damped (pseudo-dynamic) continuation, without
/// inertia.
///
/// In a pass the limits are those of the slip of the pass before, so that no face weakens and states settle; then they follow the slip.
/// Slip rests where its limits do; where the patch loses more than the rock gives back it grows from pass to pass until nothing is left to
/// lose. With `s' − s = α r`, r what the last pass adds, `r' = (1 + α (ρ − 1)) r`: now and then α is `1/(1 − ρ)`, or lets r grow threefold.
/// A face that sticks again keeps the limit that it has lost.
///
/// # Errors
/// `reason` where nothing comes to rest, and what is no matter of states.
pub(super) fn arrest(
    attempt: &Attempt<'_>,
    (mut states, mut x): (Vec<ContactState>, Iterate),
    reason: Failure,
    holding: &mut impl Holding,
    (log, observer): (&mut Log, &mut dyn Observer),
) -> Result<Settled, Failure> {
    let problem = attempt.problem;
    let solver = problem.body().solver;
    let torn = matches!(reason, Failure::Torn { .. });
    if solver.unstable != Unstable::Arrest || torn || !reason.may_be_cut() {
        return Err(reason);
    }
    let faces = 0..states.len();
    let so_far = |f: usize| problem.so_far(f, attempt.start);
    let mut limits_at: Vec<f64> = faces.clone().map(|f| so_far(f).slip()).collect();
    let (mut last, mut share): (Vec<f64>, f64) = (Vec::new(), 1.0);
    for pass in 0..PASSES {
        let start = Start {
            limits_at: limits_at.clone(),
            ..attempt.start.clone()
        };
        let at_limits = Attempt {
            start: &start,
            ..attempt.clone()
        };
        let settled = match holding.settle(&at_limits, states, x, log, observer) {
            Ok(settled) => settled,
            Err(failure @ (Failure::Stopped | Failure::Torn { .. })) => return Err(failure),
            Err(_) => return Err(reason),
        };
        // what the limits have still to lose
        let mut left = 0.0f64;
        let adds = faces.clone().map(|f| {
            if settled.states[f].constrained() != 1 {
                return 0.0;
            }
            let moved = |k: usize| {
                let i = 3 * f + 1 + k;
                settled.effective[i] - attempt.start.jump[i]
            };
            let slip = so_far(f).after([moved(0), moved(1)]).slip;
            let friction = problem.friction_in(f, attempt.start);
            let limit = |slip| friction.limit(settled.x.t[3 * f], slip);
            left = left.max((limit(slip) - limit(limits_at[f])).abs());
            slip - limits_at[f]
        });
        let adds: Vec<f64> = adds.collect();
        if left <= solver.state_tolerance * settled.traction {
            return Ok(settled);
        }
        let before = dot(&last, &last);
        if last.len() == adds.len() && before > 0.0 {
            let ratio = 1.0 + (dot(&adds, &last) / before - 1.0) / share;
            let far = match ratio < 1.0 {
                true => 1.0 / (1.0 - ratio),
                false => (GROWTH - 1.0) / (ratio - 1.0),
            };
            share = match far < 1.0 || pass % SMOOTH == SMOOTH - 1 {
                true => far.clamp(SHARES[0], SHARES[1]),
                false => 1.0,
            };
        }
        for (at, add) in limits_at.iter_mut().zip(&adds) {
            *at = (*at + share * add).max(0.0);
        }
        last = adds;
        (states, x) = (settled.states, settled.x);
    }
    Err(reason)
}
