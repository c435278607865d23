//! An iteration in counts that do not depend on the machine.

use super::Cost;
use crate::Observer;
use crate::krylov::{Breakdown, Criteria, KrylovChoice, Outcome, Report, System};
use std::time::Instant;

/// One preconditioned iteration to a residual, as published counts are made: no error is judged, and nothing takes the place of what fails.
#[derive(Clone, Debug)]
pub struct Iterated {
    /// The iteration that ran: GMRES may have become FGMRES.
    pub krylov: KrylovChoice,
    /// How it ended.
    pub result: Result<Report, Breakdown>,
    /// Flops of 𝒜 and of M⁻¹.
    pub cost: Cost,
    /// Wall time [s].
    pub solve_s: f64,
}

impl Iterated {
    /// Iterates from `x` with the true residual as the judge.
    pub fn new(
        system: &System<'_, f64>,
        krylov: KrylovChoice,
        criteria: &Criteria,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Self {
        let krylov = krylov.flexible_for(system.preconditioner);
        let start = Instant::now();
        let result = krylov.method().solve(system, criteria, x, observer);
        Self {
            krylov,
            result,
            solve_s: start.elapsed().as_secs_f64(),
            cost: Cost::new(system.operator, system.preconditioner),
        }
    }

    /// n_it, where the true residual met the tolerance.
    pub fn iterations(&self) -> Option<usize> {
        let report = self.result.as_ref().ok()?;
        (report.outcome == Outcome::Converged).then_some(report.iterations)
    }

    /// `C_s = n_it (1 + c_app)`, where there is an n_it.
    pub fn c_s(&self) -> Option<f64> {
        self.iterations().map(|n| self.cost.c_s(n, &self.krylov))
    }

    /// n_it.
    ///
    /// # Errors
    /// [`NotReached`] where the true residual did not meet the tolerance.
    pub fn reached(&self) -> Result<usize, NotReached> {
        let report = self.result?;
        self.iterations().ok_or(NotReached::Limit {
            residual: report.relative_residual,
            iterations: report.iterations,
        })
    }
}

/// A tolerance that an iteration did not meet.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotReached {
    /// It was stopped before.
    #[error("a residual of {residual:e} is left after {iterations} iterations")]
    Limit {
        /// `‖b − 𝒜x‖₂ / ‖b‖₂`.
        residual: f64,
        /// Made until then.
        iterations: usize,
    },
    /// Arithmetic gave up.
    #[error(transparent)]
    Breakdown(#[from] Breakdown),
}
