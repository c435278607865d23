//! Solutions of the natural map, found from stick or followed as friction grows.

use super::Failure;
use super::active_set::{Log, Settled};
use super::natural::Natural;
use super::newton::{Attempt, Iterate};
use super::rounds::Search;
use super::turns::Turns;
use crate::contact::ContactState;
use fracas_operators::sparse::Csr;
use fracas_solvers::{Observer, Step};

/// Share of the friction with which it begins to grow. Unit: 1.
const FIRST_SHARE: f64 = 0.25;

/// Least share by which it grows. Unit: 1.
const LEAST_SHARE: f64 = 1.0 / 64.0;

/// Where steps on the natural map led to.
enum Descent {
    /// To states that rounds leave as they are.
    Settled(Box<Settled>),
    /// To a solution of the map.
    Close,
    /// To none.
    Nowhere,
}

impl Search<'_, '_> {
    /// Newton on the natural map from x, the first step in the states `held`, with H of all faces; then rounds.
    ///
    /// With friction the map is no gradient, and its merit may have minima that are no solution. Without friction it is that of a convex
    /// energy. Where steps from stick lead nowhere, those without friction begin, and solutions are followed as it grows,
    /// ```text
    /// τ_L = s (c − t_N tan φ),   s = 0, ¼, … 1
    /// ```
    /// with a step in s that doubles and halves. Weakening has solutions beyond an instability, and a flow has pressures that follow
    /// apertures: there it is not done.
    pub(super) fn by_natural_map(
        &mut self,
        frozen: &Attempt<'_>,
        (held, from): (Vec<ContactState>, Iterate),
        last: usize,
        log: &mut Log,
    ) -> Result<Option<Settled>, Failure> {
        let problem = self.attempt.problem;
        let h = problem.stabilization(&vec![ContactState::Stick; held.len()]);
        let follows = self.attempt.flow.is_none() && !problem.weakens();
        let mut descend = |share: f64, held: Option<Vec<ContactState>>, x: &mut Iterate| {
            let natural = Natural::new(frozen, h.as_ref(), share, held);
            self.descend(natural, h.as_ref(), x, last, log)
        };
        match descend(1.0, Some(held.clone()), &mut from.clone())? {
            Descent::Settled(settled) => return Ok(Some(*settled)),
            Descent::Nowhere if follows => {}
            Descent::Nowhere | Descent::Close => return Ok(None),
        }
        let mut x = from;
        if !matches!(descend(0.0, Some(held), &mut x)?, Descent::Close) {
            return Ok(None);
        }
        let (mut share, mut step) = (0.0, FIRST_SHARE);
        while step >= LEAST_SHARE {
            let next = (share + step).min(1.0);
            let mut y = x.clone();
            match descend(next, None, &mut y)? {
                Descent::Settled(settled) => return Ok(Some(*settled)),
                Descent::Close => {
                    (share, x) = (next, y);
                    step *= 2.0;
                }
                Descent::Nowhere => step /= 2.0,
            }
        }
        Ok(None)
    }

    /// Steps on the natural map to a solution; with the whole friction on to rounds.
    fn descend(
        &mut self,
        mut natural: Natural<'_>,
        h: Option<&Csr<f64>>,
        x: &mut Iterate,
        last: usize,
        log: &mut Log,
    ) -> Result<Descent, Failure> {
        let problem = self.attempt.problem;
        let max_krylov = problem.body().solver.max_krylov;
        let mut turns = Turns::new(problem.faces().len());
        let mut before = Vec::new();
        let flows = self.attempt.flow.is_some();
        let is_over = |natural: &Natural<'_>| natural.is_over() || natural.creeps();
        while log.rounds < last && !log.is_spent(max_krylov) && !is_over(&natural) {
            let round = log.rounds;
            log.rounds += 1;
            let told = &mut *self.observer as &mut dyn Observer;
            let with = (&mut *self.linear, told);
            let found = match natural.iterate(h, round, x, &mut log.linear, with) {
                Err(failure) if failure.may_be_projected() => break,
                found => found?,
            };
            turns.see(found.iter().copied());
            let torn = turns.torn(self.attempt);
            if !torn.is_empty() {
                return Err(Failure::Torn { faces: torn });
            }
            let changed = count_changes(&found, &before);
            log.tries(self.attempt, &found);
            before = found;
            let step = Step::Round {
                round: round + 1,
                changed,
            };
            if self.observer.observe(&step).is_break() {
                return Err(Failure::Stopped);
            }
            if changed == 0 && (natural.is_close() || flows && natural.is_solved()) {
                if !natural.is_whole() {
                    return Ok(Descent::Close);
                }
                let joined = self.returning.joins();
                if let Some(settled) = self.finished(&before, x, h, log)? {
                    return Ok(Descent::Settled(Box::new(settled)));
                }
                // pressures stay, and so does what is found with them
                if flows && self.returning.joins() == joined {
                    return Ok(Descent::Close);
                }
            }
        }
        Ok(Descent::Nowhere)
    }
}

/// Faces whose states differ; all where there was none before.
fn count_changes(states: &[ContactState], before: &[ContactState]) -> usize {
    match before.len() == states.len() {
        true => states.iter().zip(before).filter(|(a, b)| a != b).count(),
        false => states.len(),
    }
}
