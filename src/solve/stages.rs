//! An iteration that goes on around another preconditioner, or with other residuals.

use super::precision::iterations_of;
use fracas_solvers::Observer;
use fracas_solvers::krylov::{Breakdown, Criteria, KrylovMethod, System};
use fracas_solvers::saddle::{Accurate, EnergyNorms, Measure, solve_accurately};
use std::time::Instant;

/// An iteration in stages, each from the x of the one before.
pub(super) struct Stages<'a> {
    method: &'a dyn KrylovMethod<f64>,
    criteria: Criteria,
    measure: Measure,
    pub(super) last: Accurate,
    /// Iterations and products of the stages before; products are not known of one that broke down.
    pub(super) before: (usize, Option<u64>),
    pub(super) refinements: usize,
    pub(super) solve_s: f64,
}

impl<'a> Stages<'a> {
    /// The first stage, from x.
    pub(super) fn begin(
        method: &'a dyn KrylovMethod<f64>,
        criteria: Criteria,
        (measure, norms): (Measure, &EnergyNorms<'_>),
        system: &System<'_, f64>,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Self {
        let start = Instant::now();
        let last = solve_accurately(method, system, &criteria, (measure, norms), x, observer);
        Self {
            method,
            criteria,
            measure,
            before: (0, Some(0)),
            refinements: last.refinements,
            last,
            solve_s: start.elapsed().as_secs_f64(),
        }
    }

    /// One more, with what is left of the iterations.
    pub(super) fn go_on(
        &mut self,
        norms: &EnergyNorms<'_>,
        system: &System<'_, f64>,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) {
        let products = (self.last.result.as_ref().ok()).map(|report| report.products);
        self.before.0 += iterations_of(&self.last.result);
        self.before.1 = self.before.1.zip(products).map(|(a, b)| a + b);
        let criteria = Criteria {
            max_iterations: self.criteria.max_iterations.saturating_sub(self.before.0),
            ..self.criteria
        };
        let start = Instant::now();
        let measure = (self.measure, norms);
        self.last = solve_accurately(self.method, system, &criteria, measure, x, observer);
        self.refinements += self.last.refinements;
        self.solve_s += start.elapsed().as_secs_f64();
    }

    /// Whether errors remain that rounding of f64 hides.
    pub(super) fn is_rounding(&self) -> bool {
        self.measure == Measure::Error
            && matches!(
                self.last.result,
                Err(Breakdown::Stagnation { .. } | Breakdown::Inaccurate { .. })
            )
    }
}
