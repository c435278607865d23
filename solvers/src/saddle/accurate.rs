//! An iteration that goes on until the error, not the residual, is small.

use super::EnergyNorms;
use crate::Observer;
use crate::krylov::{Breakdown, Criteria, KrylovMethod, Outcome, Report, System};
use fracas_operators::vector::norm2;
use serde::Serialize;

/// What decides that an iteration has converged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The errors of u and t, each relative to the solution's.
    #[default]
    Error,
    /// ‖b − 𝒜x‖₂ relative to ‖b‖₂, as in published counts.
    Residual,
}

/// Ritz value of M⁻¹𝒜 above which M⁻¹r is taken for the error. Unit: 1.
const TRUSTED: f64 = 0.1;

/// Share of the tolerance that the next pass aims at. Unit: 1.
const AIM: f64 = 0.5;

/// Bounds of what a pass lowers the residual by: less is not worth a start, of more nothing is known. Unit: 1.
const STEP: [f64; 2] = [1e-4, 0.1];

/// ‖r‖/‖b‖ above which nothing is solved: where 𝒜 is singular and b outside its range, x grows until any error is small beside it. Unit: 1.
const NEAR: f64 = 1e-1;

/// Share by which a pass has to lower the error: else rounding is all that is left. Unit: 1.
const GAIN: f64 = 0.5;

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

/// Solves to `criteria.relative_tolerance` in the error ([`Measure::Residual`]: in the residual, and estimates the error): passes of `method`, each to a residual that the error of the one
/// before asks for, from the x at hand. The first pass asks for ‖r‖ ≤ tolerance · ‖b‖.
///
/// The error is `e = 𝒜⁻¹r = (M⁻¹𝒜)⁻¹ M⁻¹r ≈ M⁻¹r`. Where M is poor, M⁻¹r may be too small by the eigenvalue of M⁻¹𝒜 nearest to zero;
/// the Ritz value of the iteration stands for that one, and a further pass shows by how much: what it changes is the error before. A residual that rounding keeps from falling is no failure where the
/// error is small.
///
/// # Cost
/// Beyond the iterations, per pass two products with 𝒜 and one solve with M.
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
    let mut last: Option<Pass> = None;
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
        let (relative_residual, estimate) = match finite {
            true => estimate(system, norms, x),
            false => (f64::NAN, [f64::NAN; 2]),
        };
        // M⁻¹r is too small by 1/|θ| at most, and the pass before shows by how much, of what it changed: between both, nearer to
        // what was seen (of 800 random systems no FSAI then claims more than it has)
        let is_poor = totals.smallest_ritz.is_none_or(|ritz| ritz < TRUSTED);
        let bound = totals
            .smallest_ritz
            .map_or(f64::INFINITY, |ritz| TRUSTED / ritz);
        let factor = match (&last, is_poor) {
            (_, false) => [1.0; 2],
            (None, true) => [bound; 2],
            (Some(before), true) => {
                let seen = before.effectivity(norms, x);
                seen.map(|seen| match bound.is_finite() {
                    true => (seen.clamp(1.0, bound).powi(2) * bound).cbrt(),
                    false => seen.max(1.0),
                })
            }
        };
        let error = [estimate[0] * factor[0], estimate[1] * factor[1]];
        let [worst, raw] = [error, estimate].map(|[u, t]| u.max(t));
        let left = criteria.max_iterations.saturating_sub(totals.iterations);
        // far from b it is no rounding that keeps the residual from falling
        let near = relative_residual <= NEAR;
        let rounding = near && matches!(result, Err(Breakdown::Stagnation { .. }));
        let ended = matches!(&result, Ok(report) if report.outcome == Outcome::Stopped)
            || (result.is_err() && !rounding)
            || !raw.is_finite()
            || measure == Measure::Residual;
        if worst <= tolerance && near && !ended {
            return Accurate {
                result: Ok(totals.report(Outcome::Converged, relative_residual)),
                error,
                passes,
            };
        }
        // rounding leaves of x what it leaves: a pass that does not halve the error has no more to give
        let stands = (last.as_ref()).is_some_and(|last| raw > GAIN * last.raw());
        if ended || stands || left == 0 || iterations == 0 {
            let result = match result {
                Ok(report) if report.outcome == Outcome::Converged && measure == Measure::Error => {
                    Err(Breakdown::Inaccurate {
                        method: method.name(),
                        iteration: report.iterations,
                        part: ["displacements", "tractions"][usize::from(error[1] > error[0])],
                        error: worst,
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
        let step = (AIM * tolerance / raw).clamp(STEP[0], STEP[1]);
        last = Some(Pass {
            estimate,
            x: if is_poor { x.to_vec() } else { Vec::new() },
        });
        pass = Criteria {
            relative_tolerance: step * relative_residual,
            max_iterations: left,
        };
    }
}

/// Where a pass ended.
struct Pass {
    estimate: [f64; 2],
    /// Kept where M is poor.
    x: Vec<f64>,
}

impl Pass {
    fn raw(&self) -> f64 {
        self.estimate[0].max(self.estimate[1])
    }

    /// Error over its estimate, part by part, the next iterate standing for the solution; infinite where that is not known.
    fn effectivity(&self, norms: &EnergyNorms<'_>, next: &[f64]) -> [f64; 2] {
        if self.x.is_empty() {
            return [f64::INFINITY; 2];
        }
        let change: Vec<f64> = next.iter().zip(&self.x).map(|(y, x)| y - x).collect();
        let change = norms.relative(&change, next);
        [0, 1].map(|part: usize| match change[part] {
            0.0 => 1.0,
            change => change / self.estimate[part],
        })
    }
}

/// `‖r‖/‖b‖` of x, and the relative norms of M⁻¹r, with what rounding may add to r.
fn estimate(system: &System<'_, f64>, norms: &EnergyNorms<'_>, x: &[f64]) -> (f64, [f64; 2]) {
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
    drop((r, work));
    let relative = if size == 0.0 { 0.0 } else { size / b };
    (relative, norms.relative(&e, x))
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
                self.smallest_ritz = smaller(self.smallest_ritz, report.smallest_ritz);
                Ok(self.report(report.outcome, report.relative_residual))
            }
            Err(breakdown) => {
                if let Breakdown::Stagnation { smallest_ritz, .. } = &breakdown {
                    self.smallest_ritz = smaller(self.smallest_ritz, *smallest_ritz);
                }
                let done = breakdown.iteration();
                let breakdown = breakdown.after(self.iterations);
                self.iterations += done;
                Err(breakdown)
            }
        }
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

fn smaller(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}
