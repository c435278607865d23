//! An iteration that goes on until the error, not the residual, is small.

use super::{EnergyNorms, ErrorJudge, Judged, probe};
use crate::Observer;
use crate::krylov::{Breakdown, Criteria, KrylovMethod, Outcome, Report, System, least};
use fracas_operators::vector::norm2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What decides that an iteration has converged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The errors of u and t, each relative to the solution's.
    #[default]
    Error,
    /// ‖b − 𝒜x‖₂ relative to ‖b‖₂, as in published counts.
    Residual,
}

/// ‖r‖/‖b‖ above which nothing is solved: where 𝒜 is singular and b outside its range, x grows until any error is small beside it. Unit: 1.
const NEAR: f64 = 1e-1;

/// A solve, and how accurate it is.
#[derive(Clone, Debug)]
pub struct Accurate {
    /// How the last pass ended, with the iterations, products and solves of all passes.
    pub result: Result<Report, Breakdown>,
    /// `(‖e_u‖/‖u‖, ‖e_t‖/‖t‖)` for `e = M⁻¹r`, in [`EnergyNorms`], larger where M is poor.
    pub error: [f64; 2],
    /// Times the iteration was started.
    pub passes: usize,
}

/// Solves to `criteria.relative_tolerance` in the error ([`Measure::Residual`]: in the residual, and estimates the error).
///
/// Passes of `method`, each from the x at hand to a residual that the error of the one before asks for; the first one asks for
/// ‖r‖ ≤ tolerance · ‖b‖. [`ErrorJudge`] says what the error is. A residual that rounding keeps from falling is no failure
/// where the error is small.
///
/// Eigenvalues of M⁻¹𝒜 close to zero, of which b has little, are not seen by the iteration. Where M is of one level
/// a [`probe`] looks for them.
///
/// # Cost
/// Beyond the iterations, per pass two products with 𝒜 and one solve with M; of a probe 40 of each.
pub fn solve_accurately(
    method: &dyn KrylovMethod<f64>,
    system: &System<'_, f64>,
    criteria: &Criteria,
    (measure, norms): (Measure, &EnergyNorms<'_>),
    x: &mut [f64],
    observer: &mut dyn Observer,
) -> Accurate {
    let tolerance = criteria.relative_tolerance;
    let mut pass = *criteria;
    let mut totals = Totals::default();
    let mut judge = ErrorJudge::default();
    let mut passes = 0;
    loop {
        passes += 1;
        let result = method.solve(system, &pass, x, observer);
        let iterations = match &result {
            Ok(report) => report.iterations,
            Err(breakdown) => breakdown.iteration(),
        };
        let result = totals.added(result);
        let finite = x.iter().all(|x| x.is_finite());
        let (relative_residual, judged) = match finite {
            true => {
                if passes == 1 && measure == Measure::Error {
                    totals.probe(method, system, norms, observer);
                }
                let (relative, e) = estimate(system, norms, x);
                let size = norms.solution(x);
                (
                    relative,
                    judge.judge(norms, (&e, x), size, totals.smallest_ritz),
                )
            }
            false => (f64::NAN, Judged::UNKNOWN),
        };
        let left = criteria.max_iterations.saturating_sub(totals.iterations);
        // far from b it is no rounding that keeps the residual from falling
        let near = relative_residual <= NEAR;
        let rounding = near && matches!(result, Err(Breakdown::Stagnation { .. }));
        let ended = matches!(&result, Ok(report) if report.outcome == Outcome::Stopped)
            || (result.is_err() && !rounding)
            || !judged.estimate.is_finite()
            || measure == Measure::Residual;
        let error = judged.error;
        if judged.worst() <= tolerance && near && !ended {
            return Accurate {
                result: Ok(totals.report(Outcome::Converged, relative_residual)),
                error,
                passes,
            };
        }
        if ended || judged.stands || left == 0 || iterations == 0 {
            let result = match result {
                Ok(report) if report.outcome == Outcome::Converged && measure == Measure::Error => {
                    Err(Breakdown::Inaccurate {
                        method: method.name(),
                        iteration: report.iterations,
                        part: judged.part(),
                        error: judged.worst(),
                        relative_residual,
                    })
                }
                other => other,
            };
            return Accurate {
                result,
                error,
                passes,
            };
        }
        pass = Criteria {
            relative_tolerance: judged.step(tolerance) * relative_residual,
            max_iterations: left,
        };
    }
}

/// The residual of x relative to ‖b‖, and M⁻¹ of it with what rounding may add to it.
fn estimate(system: &System<'_, f64>, norms: &EnergyNorms<'_>, x: &[f64]) -> (f64, Vec<f64>) {
    let mut r = system.rhs.to_vec();
    let scratch = system
        .operator
        .work_len()
        .max(system.preconditioner.work_len());
    let mut work = vec![0.0; scratch];
    system.operator.apply_add(-1.0, x, &mut r, &mut work);
    let (size, b) = (norm2(&r), norm2(system.rhs));
    norms.add_rounding(x, &mut r);
    let mut e = vec![0.0; r.len()];
    system.preconditioner.solve(&r, &mut e, &mut work);
    let relative = if size == 0.0 { 0.0 } else { size / b };
    (relative, e)
}

/// What all passes did.
#[derive(Clone, Copy, Debug, Default)]
struct Totals {
    iterations: usize,
    products: u64,
    solves: u64,
    estimated: f64,
    smallest_ritz: Option<f64>,
}

impl Totals {
    /// The result with what the passes before did.
    fn added(&mut self, result: Result<Report, Breakdown>) -> Result<Report, Breakdown> {
        match result {
            Ok(report) => {
                self.iterations += report.iterations;
                // the residual and the error estimate of the pass
                self.products += report.products + 2;
                self.solves += report.preconditioner_solves + 1;
                self.estimated = report.estimated_residual;
                self.smallest_ritz = least([self.smallest_ritz, report.smallest_ritz]);
                Ok(self.report(report.outcome, report.relative_residual))
            }
            Err(breakdown) => {
                if let Breakdown::Stagnation { smallest_ritz, .. } = &breakdown {
                    self.smallest_ritz = least([self.smallest_ritz, *smallest_ritz]);
                }
                let done = breakdown.iteration();
                let breakdown = breakdown.after(self.iterations);
                self.iterations += done;
                Err(breakdown)
            }
        }
    }

    /// Looks for small eigenvalues where that is needed.
    fn probe(
        &mut self,
        method: &dyn KrylovMethod<f64>,
        system: &System<'_, f64>,
        norms: &EnergyNorms<'_>,
        observer: &mut dyn Observer,
    ) {
        let probed = probe(method, system, norms, observer);
        self.products += probed.products;
        self.solves += probed.solves;
        self.smallest_ritz = least([self.smallest_ritz, probed.ritz]);
    }

    fn report(&self, outcome: Outcome, relative_residual: f64) -> Report {
        Report {
            outcome,
            iterations: self.iterations,
            relative_residual,
            estimated_residual: self.estimated,
            products: self.products,
            preconditioner_solves: self.solves,
            smallest_ritz: self.smallest_ritz,
        }
    }
}
