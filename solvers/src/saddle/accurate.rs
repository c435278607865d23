//! An iteration that goes on until the error, not the residual, is small.

use super::{EnergyNorms, ErrorJudge, Judged, probe};
use crate::krylov::{Breakdown, Criteria, KrylovMethod, Outcome, Report, System, least};
use crate::{Observer, Step};
use fracas_operators::Fields;
use fracas_operators::twofold::add_twofold;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What decides that an iteration has converged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The errors of every field, each relative to the solution's.
    #[default]
    Error,
    /// ‖b − 𝒜x‖₂ relative to ‖b‖₂, as in published counts.
    Residual,
}

/// ‖r‖/‖b‖ and ‖M⁻¹r‖/‖M⁻¹b‖ above which nothing is solved: where 𝒜 is singular and b outside its range, x grows until any error is
/// small beside it. Either alone says little: a residual of stiff rock is large beside b for an error that is none. Unit: 1.
const NEAR: f64 = 1e-1;

/// Share by which a pass has to lower a residual in twice the digits, or the error: else M has no digits of the error left. Unit: 1.
const GAIN: f64 = 0.5;

/// ‖r‖ over the rounding that r may have, above which an error below the tolerance is believed. Unit: 1.
const FIRM: f64 = 100.0;

/// Ritz values of M⁻¹𝒜 below which M⁻¹r is corrected by itself once before it is taken for the error, and below which the larger of
/// both counts in full: in between its share grows, lest a count depend on which side of a limit a Ritz value lies. Unit: 1.
/// Of 53,000 random systems and methods with poor inner solvers 7 were called converged at 1.0 to 2.8 times what is allowed, 3 are with this.
const DOUBTED: [f64; 2] = [0.4, 0.2];

/// Around a block diagonal M, least error of a field beside those of all, in energy: what B couples is in error together, and such an M does
/// not see that. Unit: 1.
const COUPLED: f64 = 0.1;

/// A solve, and how accurate it is.
#[derive(Clone, Debug)]
pub struct Accurate {
    /// How the last pass ended, with the iterations, products and solves of all passes.
    pub result: Result<Report, Breakdown>,
    /// `‖e_u‖/‖u‖`, `‖e_t‖/‖t‖`, … for `e = M⁻¹r`, in [`EnergyNorms`], larger where M is poor.
    pub error: Fields<f64>,
    /// Times the iteration was started.
    pub passes: usize,
    /// Those of them for a residual in twice the digits.
    pub refinements: usize,
}

/// Solves to `criteria.relative_tolerance` in the error ([`Measure::Residual`]: in the residual, and estimates the error).
///
/// Passes of `method`, each from the x at hand to a residual that the error of the one before asks for; the first one asks for
/// ‖r‖ ≤ tolerance · ‖b‖. [`ErrorJudge`] says what the error is. A residual that rounding keeps from falling is no failure
/// where the error is small.
///
/// Where f64 has no more to say, or what it says may be rounding, and the norms know the entries of 𝒜, residuals are had in twice the digits from there on, and passes
/// solve `𝒜z = r`, x ← x + z, with x in twice the digits until it is returned: iterative refinement (Demmel et al., ACM TOMS 32, 2006).
///
/// Eigenvalues of M⁻¹𝒜 close to zero, of which b has little, are not seen by the iteration. Where M is of one level, or in f32
/// around entries that spread over its digits, or where H leaves a traction all but free, a [`probe`] looks for them.
///
/// # Cost
/// Beyond the iterations, per pass two products with 𝒜 and one solve with M, one more of each where M is
/// [`blind`](fracas_operators::Properties) or poor or a field has few unknowns (a refinement: some five products more); of a [`probe`]
/// 40 to 600 of each.
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
    let mut judge = ErrorJudge::new(tolerance);
    let mut left = Remainder::new(system, norms);
    let (mut passes, mut refinements) = (0, 0);
    loop {
        passes += 1;
        refinements += usize::from(left.is_sharp);
        let result = match left.is_sharp {
            false => method.solve(system, &pass, x, observer),
            true => left.refine(method, &pass, x, observer),
        };
        let iterations = match &result {
            Ok(report) => report.iterations,
            Err(breakdown) => breakdown.iteration(),
        };
        let result = totals.added(result);
        let before = left.relative;
        let finite = !system.is_anywhere(!x.iter().all(|x| x.is_finite()));
        if finite && passes == 1 && measure == Measure::Error {
            totals.probe(method, system, norms, observer);
        }
        let mut judged = match finite {
            true => left.judged(x, &mut judge, totals.smallest_ritz),
            false => Judged::unknown(norms),
        };
        let remaining = criteria.max_iterations.saturating_sub(totals.iterations);
        // far from b only residuals in twice the digits show whether it is rounding that keeps it there
        let may_be_near = left.is_near || left.is_sharp || left.has_more_digits();
        let rounding = may_be_near && matches!(result, Err(Breakdown::Stagnation { .. }));
        let ended = matches!(&result, Ok(report) if report.outcome == Outcome::Stopped)
            || (result.is_err() && !rounding)
            || !judged.estimate.is_finite()
            || measure == Measure::Residual;
        // of a sharp residual it is M⁻¹ that rounds, less with every pass; the error falls before the residual of stiff rock does
        let stands =
            iterations == 0 || judged.stands && (!left.is_sharp || left.relative > GAIN * before);
        let mut is_last = ended || stands || remaining == 0;
        // around a poor M of one level, whose Ritz values come late, one more pass confirms it, where the iteration can do more
        let m = system.preconditioner.properties();
        let may_go_on = remaining > 0 && !rounding && !stands;
        let may_err = (m.local || m.blind) && may_go_on;
        let is_enough = |judged: &Judged, is_near: bool| {
            let is_small = judged.worst() <= tolerance && is_near && !ended;
            is_small && (judged.confirmed || !may_err)
        };
        let is_doubtful = match is_enough(&judged, left.is_near) {
            true => left.is_rounding,
            false => (rounding || stands) && remaining > 0,
        };
        if is_doubtful && may_be_near && !ended && left.sharpen() {
            // errors before were those of other residuals
            judge = ErrorJudge::new(tolerance);
            judged = left.judged(x, &mut judge, totals.smallest_ritz);
            is_last = remaining == 0;
        }
        totals.corrections = left.corrections;
        let is_enough = is_enough(&judged, left.is_near);
        if is_enough || is_last {
            let is_met =
                matches!(&result, Ok(report) if report.outcome == Outcome::Converged) || rounding;
            let result = match result {
                _ if is_enough => Ok(totals.report(Outcome::Converged, left.relative)),
                // b is not met even in twice the digits, or the error is small beside a large residual: A may be singular
                Err(Breakdown::Stagnation { .. })
                    if !left.is_near || judged.worst() <= tolerance =>
                {
                    Err(Breakdown::Stagnation {
                        method: method.name(),
                        iteration: totals.iterations,
                        relative_residual: left.relative,
                        smallest_ritz: totals.smallest_ritz,
                    })
                }
                _ if is_met && measure == Measure::Error && judged.estimate.is_finite() => {
                    Err(Breakdown::Inaccurate {
                        method: method.name(),
                        iteration: totals.iterations,
                        part: judged.part(),
                        error: judged.worst(),
                        relative_residual: left.relative,
                    })
                }
                Ok(report) => Ok(totals.report(report.outcome, report.relative_residual)),
                Err(breakdown) => Err(breakdown),
            };
            return Accurate {
                result,
                error: judged.error,
                passes,
                refinements,
            };
        }
        pass = Criteria {
            relative_tolerance: judged.step(tolerance) * left.scale(),
            max_iterations: remaining,
        };
    }
}

/// What is left of the equations at an iterate.
struct Remainder<'a> {
    system: &'a System<'a, f64>,
    norms: &'a EnergyNorms<'a>,
    /// Digits of x that f64 has no room for, where residuals are sharp.
    low: Vec<f64>,
    /// b − 𝒜x.
    r: Vec<f64>,
    /// ‖r‖ / ‖b‖.
    relative: f64,
    /// Residuals are had in twice the digits.
    is_sharp: bool,
    /// ‖r‖ or M⁻¹r is small beside that of b.
    is_near: bool,
    /// ‖M⁻¹b‖ in the energy norm of all fields, once it was asked for.
    of_b: Option<f64>,
    /// The residual may be mostly rounding.
    is_rounding: bool,
    /// Products, and solves, of error estimates beyond M⁻¹r.
    corrections: u64,
}

impl<'a> Remainder<'a> {
    fn new(system: &'a System<'a, f64>, norms: &'a EnergyNorms<'a>) -> Self {
        Self {
            system,
            norms,
            low: Vec::new(),
            r: Vec::new(),
            relative: f64::NAN,
            is_sharp: false,
            is_near: false,
            of_b: None,
            is_rounding: false,
            corrections: 0,
        }
    }

    /// False where residuals in twice the digits are had already, or never.
    fn has_more_digits(&self) -> bool {
        !self.is_sharp && self.norms.entries().is_some()
    }

    /// From here on residuals in twice the digits; false where there are no more.
    fn sharpen(&mut self) -> bool {
        let may = self.has_more_digits();
        if may {
            self.is_sharp = true;
            self.low.resize(self.system.rhs.len(), 0.0);
        }
        may
    }

    /// The residual that tolerances of a pass are relative to, itself relative to ‖b‖.
    fn scale(&self) -> f64 {
        if self.is_sharp { 1.0 } else { self.relative }
    }

    /// The errors of x by M⁻¹ of its residual, with what rounding may add to that.
    fn judged(&mut self, x: &[f64], judge: &mut ErrorJudge, ritz: Option<f64>) -> Judged {
        let System {
            operator,
            preconditioner,
            rhs,
        } = *self.system;
        let mut work = vec![0.0; operator.work_len().max(preconditioner.work_len())];
        self.r.clear();
        self.r.extend_from_slice(rhs);
        match self.norms.entries().filter(|_| self.is_sharp) {
            Some(blocks) => blocks.residual(rhs, &[x, &self.low], &mut self.r),
            None => operator.apply_add(-1.0, x, &mut self.r, &mut work),
        }
        let (size, b) = (self.system.norm2(&self.r), self.system.norm2(rhs));
        self.relative = if size == 0.0 { 0.0 } else { size / b };
        self.is_rounding = !self.is_sharp && {
            let rounding = self.norms.add_rounding(x, &mut self.r);
            size < FIRM * rounding
        };
        let mut e = vec![0.0; self.r.len()];
        preconditioner.solve(&self.r, &mut e, &mut work);
        let energy = |e: &[f64]| {
            let fields = self.norms.error(e);
            fields.iter().fold(0.0f64, |sum, (_, e)| sum.hypot(e))
        };
        self.is_near = self.relative <= NEAR || {
            let of_b = *self.of_b.get_or_insert_with(|| {
                let mut x = vec![0.0; rhs.len()];
                preconditioner.solve(rhs, &mut x, &mut work);
                energy(&x)
            });
            energy(&e) <= NEAR * of_b
        };
        let mut size = self.norms.error(&e);
        let is_blind = preconditioner.properties().blind;
        let doubt = match ritz {
            Some(ritz) if !is_blind => {
                let [least, most] = DOUBTED;
                let ritz = ritz.max(f64::MIN_POSITIVE);
                ((least / ritz).ln() / (least / most).ln()).clamp(0.0, 1.0)
            }
            _ => 1.0,
        };
        let doubts =
            (self.norms.by_chance()).map(|_, by_chance| if by_chance { 1.0 } else { doubt });
        if doubts.iter().any(|(_, doubt)| doubt > 0.0) {
            let more = self.passed_on(&e, &mut work);
            self.corrections += 1;
            let all = more.iter().fold(0.0f64, |all, (_, more)| all.hypot(more));
            let least = if is_blind { COUPLED * all } else { 0.0 };
            size = size.map(|field, size| {
                let more = more[field].max(least).max(size);
                size.powf(1.0 - doubts[field]) * more.powf(doubts[field])
            });
        }
        judge.judge(self.norms, (size, x), self.norms.solution(x), ritz)
    }

    /// The norms of `e + M⁻¹(r − 𝒜e)`: with it a field sees what the errors of another do to it.
    fn passed_on(&self, e: &[f64], work: &mut [f64]) -> Fields<f64> {
        let System {
            operator,
            preconditioner,
            ..
        } = *self.system;
        let mut r = self.r.clone();
        operator.apply_add(-1.0, e, &mut r, work);
        let mut corrected = vec![0.0; e.len()];
        preconditioner.solve(&r, &mut corrected, work);
        corrected.iter_mut().zip(e).for_each(|(z, e)| *z += e);
        self.norms.error(&corrected)
    }

    /// A pass for `𝒜z = r`, x ← x + z; the result is told relative to ‖b‖.
    fn refine(
        &mut self,
        method: &dyn KrylovMethod<f64>,
        pass: &Criteria,
        x: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<Report, Breakdown> {
        let system = System {
            rhs: &self.r,
            ..*self.system
        };
        let mut of_b = |step: &Step| match *step {
            Step::Krylov {
                iteration,
                relative_residual,
            } => observer.observe(&Step::Krylov {
                iteration,
                relative_residual: relative_residual * self.relative,
            }),
            _ => observer.observe(step),
        };
        let mut z = vec![0.0; x.len()];
        let result = method.solve(&system, pass, &mut z, &mut of_b);
        if matches!(result, Ok(_) | Err(Breakdown::Stagnation { .. })) {
            add_twofold(&z, x, &mut self.low);
        }
        match result {
            Ok(report) => Ok(Report {
                relative_residual: report.relative_residual * self.relative,
                estimated_residual: report.estimated_residual * self.relative,
                ..report
            }),
            Err(breakdown) => Err(breakdown.relative_to(self.relative)),
        }
    }
}

/// What all passes did.
#[derive(Clone, Copy, Debug, Default)]
struct Totals {
    iterations: usize,
    products: u64,
    solves: u64,
    /// Products, and solves, of error estimates beyond M⁻¹r.
    corrections: u64,
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
        let probed = probe(method, system, norms, self.smallest_ritz, observer);
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
            products: self.products + self.corrections,
            preconditioner_solves: self.solves + self.corrections,
            smallest_ritz: self.smallest_ritz,
        }
    }
}
