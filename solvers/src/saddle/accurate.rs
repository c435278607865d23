//! An iteration that goes on until the error, not the residual, is small.

use super::probe::{Left, Probed};
use super::remainder::Remainder;
use super::{EnergyNorms, ErrorJudge, Judged, probe};
use crate::Observer;
use crate::krylov::{
    Breakdown, Candidate, Criteria, Judge, KrylovMethod, Outcome, Report, System, Verdict, Watch,
    least,
};
use fracas_operators::Fields;
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

/// Share by which a pass has to lower a residual in twice the digits, or the error: else M has no digits of the error left. Unit: 1.
const GAIN: f64 = 0.5;

/// True residual over that of a recurrence, above which rounding has parted them: from there on only a new start gains. Unit: 1.
const FOLLOWS: f64 = 2.0;

/// A solve, and how accurate it is.
#[derive(Clone, Debug)]
pub struct Accurate {
    /// How the last pass ended, with the iterations, products and solves of all passes.
    pub result: Result<Report, Breakdown>,
    /// `‖e_u‖/‖u‖`, `‖e_t‖/‖t‖`, … for `e = M⁻¹r`, in [`EnergyNorms`], larger where M is poor.
    pub error: Fields<f64>,
    /// What the last digits of the entries of 𝒜 leave open of a solution that was found, likewise relative to it: infinite where 𝒜 is singular in the
    /// digits of f64. `None` where 𝒜 is too large to be eliminated, or its entries are not known.
    pub left_open: Option<Fields<f64>>,
    /// Times the iteration was started.
    pub passes: usize,
    /// Those of them for a residual in twice the digits.
    pub refinements: usize,
}

/// Solves to `criteria.relative_tolerance` in the error ([`Measure::Residual`]: in the residual, and estimates the error).
///
/// `method` runs until ‖r‖ ≤ tolerance · ‖b‖. [`ErrorJudge`] says what the error is, and what residual it asks for; the method goes on to that
/// with the basis, or the directions, that it has. Where it hands back before, or rounding has parted its recurrence from the
/// true residual, another pass begins from the x at hand. A residual that rounding keeps from falling is no failure where the error is
/// small.
///
/// Where f64 has no more to say, or what it says may be rounding, and the norms know the entries of 𝒜, residuals are had in twice the digits from there on, and passes
/// solve `𝒜z = r`, x ← x + z, with x in twice the digits until it is returned: iterative refinement (Demmel et al., ACM TOMS 32, 2006).
///
/// Eigenvalues of M⁻¹𝒜 close to zero, of which b has little, are not seen by the iteration. Where M is of one level, or in f32
/// around entries that spread over its digits, or where H leaves a traction all but free, a [`probe`] looks for them; of a large system that is not
/// symmetric it sees how far 𝒜⁻¹ grows beyond M⁻¹.
///
/// # Cost
/// Beyond the iterations, per look at the errors two products with 𝒜 and one solve with M, one more of each where M is
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
    let mut search = Search {
        method,
        system,
        norms,
        criteria,
        is_probed: measure == Measure::Residual,
        hidden: None,
        errors: ErrorJudge::new(tolerance),
        left: Remainder::new(system, norms),
        totals: Totals::default(),
        judged: None,
    };
    let (mut passes, mut refinements) = (0, 0);
    loop {
        passes += 1;
        refinements += usize::from(search.left.is_sharp);
        let before = search.left.relative;
        search.judged = None;
        let result = match search.left.is_sharp {
            true => search.left.refine(method, &pass, x, observer),
            false if measure == Measure::Residual => method.solve(system, &pass, x, observer),
            false => {
                let watch = Watch {
                    observer: &mut *observer,
                    judge: Some(&mut search),
                };
                method.solve_watched(system, &pass, x, watch)
            }
        };
        let iterations = match &result {
            Ok(report) => report.iterations,
            Err(breakdown) => breakdown.iteration(),
        };
        let is_met = matches!(&result, Ok(report) if report.outcome == Outcome::Converged);
        let result = search.totals.added(result);
        let (mut judged, parted) = match search.judged {
            Some(last) if is_met && last.iteration == iterations => (last.errors, last.parted),
            _ => (search.look_at(x, observer), false),
        };
        let Search { left, totals, .. } = &mut search;
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
        // what stands, or may not go on, is not confirmed by another pass
        let is_final = is_last || rounding;
        let is_doubtful = match !ended && search.is_enough(&judged, is_final) {
            true => search.left.is_rounding,
            false => (rounding || stands || parted) && remaining > 0,
        };
        if is_doubtful && may_be_near && !ended && search.left.sharpen() {
            // errors before were those of other residuals
            search.errors = ErrorJudge::new(tolerance);
            judged = search.look_at(x, observer);
            is_last = remaining == 0;
        }
        let mut is_enough = !ended && search.is_enough(&judged, is_final);
        if is_enough || is_last {
            if let Some(lost) = search.left.rounded(x, tolerance) {
                judged.error = judged.error.map(|field, error| error + lost[field]);
                is_enough &= judged.worst() <= tolerance;
            }
            let Search { left, totals, .. } = &search;
            let is_met = is_met || rounding;
            let left_open = left.left_open.filter(|_| is_enough);
            let counted = |outcome, relative| totals.report(outcome, relative, left);
            let result = match result {
                _ if is_enough => Ok(counted(Outcome::Converged, left.relative)),
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
                Ok(report) => Ok(counted(report.outcome, report.relative_residual)),
                Err(breakdown) => Err(breakdown),
            };
            return Accurate {
                result,
                error: judged.error,
                left_open,
                passes,
                refinements,
            };
        }
        pass = Criteria {
            relative_tolerance: judged.step(tolerance) * search.left.scale(),
            max_iterations: remaining,
        };
    }
}

/// A solve in progress.
struct Search<'a> {
    method: &'a dyn KrylovMethod<f64>,
    system: &'a System<'a, f64>,
    norms: &'a EnergyNorms<'a>,
    criteria: &'a Criteria,
    /// Small eigenvalues were looked for, or need not be.
    is_probed: bool,
    /// What stands for a Ritz value where M⁻¹𝒜 is far from normal.
    hidden: Option<f64>,
    errors: ErrorJudge,
    left: Remainder<'a>,
    totals: Totals,
    /// The x last judged in the running pass.
    judged: Option<Last>,
}

/// An x that was judged while a pass ran.
#[derive(Clone, Copy)]
struct Last {
    /// Iterations of the pass until then.
    iteration: usize,
    errors: Judged,
    /// Rounding has parted the recurrence from the true residual.
    parted: bool,
}

impl Search<'_> {
    /// The errors of x; small eigenvalues are looked for before the first ones.
    fn look_at(&mut self, x: &[f64], observer: &mut dyn Observer) -> Judged {
        if self.system.is_anywhere(!x.iter().all(|x| x.is_finite())) {
            return Judged::unknown(self.norms);
        }
        if !std::mem::replace(&mut self.is_probed, true) {
            let seen = self.totals.smallest_ritz;
            let probed = probe(
                self.method,
                self.system,
                self.norms,
                (seen, Left::Little),
                observer,
            );
            self.totals.add(probed);
            self.hidden = probed.hidden;
        }
        let ritz = least([self.totals.smallest_ritz, self.hidden]);
        (self.left).judged(x, &mut self.errors, ritz)
    }

    /// Whether these errors are small. Around a poor M of one level, whose Ritz values come late, a further look confirms it, where the
    /// iteration can do more: one that is not final.
    fn is_enough(&self, judged: &Judged, is_final: bool) -> bool {
        let m = self.system.preconditioner.properties();
        let is_small = judged.worst() <= self.criteria.relative_tolerance && self.left.is_near;
        is_small && (judged.confirmed || is_final || !(m.local || m.blind))
    }
}

impl Judge<f64> for Search<'_> {
    fn judge(&mut self, at: &Candidate<'_, f64>, observer: &mut dyn Observer) -> Verdict {
        let ritz = [self.totals.smallest_ritz, at.smallest_ritz];
        self.totals.smallest_ritz = least(ritz);
        let judged = self.look_at(at.x, observer);
        let relative_residual = self.left.relative;
        let follows = relative_residual <= FOLLOWS * at.estimated_residual;
        self.judged = Some(Last {
            iteration: at.iteration,
            errors: judged,
            parted: !follows && self.left.is_rounding,
        });
        let may_gain = follows && judged.estimate.is_finite() && !judged.stands;
        let goes_on = may_gain && !self.is_enough(&judged, false);
        let further = judged.step_onward(self.criteria.relative_tolerance) * relative_residual;
        Verdict {
            relative_residual,
            further: goes_on.then_some(further),
        }
    }
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
    /// The result of a pass, counted with those before.
    fn added(&mut self, result: Result<Report, Breakdown>) -> Result<Report, Breakdown> {
        match result {
            Ok(report) => {
                self.iterations += report.iterations;
                self.products += report.products;
                self.solves += report.preconditioner_solves;
                self.estimated = report.estimated_residual;
                self.smallest_ritz = least([self.smallest_ritz, report.smallest_ritz]);
                Ok(report)
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

    /// What a look for small eigenvalues did.
    fn add(&mut self, probed: Probed) {
        self.products += probed.products;
        self.solves += probed.solves;
        self.smallest_ritz = least([self.smallest_ritz, probed.ritz]);
    }

    fn report(&self, outcome: Outcome, relative_residual: f64, left: &Remainder<'_>) -> Report {
        Report {
            outcome,
            iterations: self.iterations,
            relative_residual,
            estimated_residual: self.estimated,
            products: self.products + left.products,
            preconditioner_solves: self.solves + left.solves,
            smallest_ritz: self.smallest_ritz,
        }
    }
}
