//! What is left of the equations at an iterate, and what that says of its errors.

use super::determined::left_open;
use super::{EnergyNorms, ErrorJudge, Judged, Series, TRUSTED};
use crate::direct::{Factorization, Faer};
use crate::krylov::{Breakdown, Criteria, KrylovMethod, Report, System};
use crate::{Observer, SetupError, Step};
use fracas_operators::twofold::add_twofold;
use fracas_operators::{Fields, Preconditioner};

/// ‖r‖/‖b‖ and ‖M⁻¹r‖/‖M⁻¹b‖ above which nothing is solved: where 𝒜 is singular and b outside its range, x grows until any error is
/// small beside it. Either alone says little: a residual of stiff rock is large beside b for an error that is none. Unit: 1.
const NEAR: f64 = 1e-1;

/// ‖r‖ over the rounding that r may have, above which an error below the tolerance is believed. Unit: 1.
const FIRM: f64 = 100.0;

/// Ritz values of M⁻¹𝒜 below which M⁻¹r is corrected by itself once before it is taken for the error, and below which the larger of
/// both counts in full: in between its share grows, lest a count depend on which side of a limit a Ritz value lies. Unit: 1.
/// Of 53,000 random systems and methods with poor inner solvers 7 were called converged at 1.0 to 2.8 times what is allowed, 3 are with this.
const DOUBTED: [f64; 2] = [0.4, 0.2];

/// Around a block diagonal M, least error of a field beside those of all, in energy: what B couples is in error together, and such an M does
/// not see that. Unit: 1.
const COUPLED: f64 = 0.1;

/// Unknowns up to which 𝒜 is eliminated to know an error that is called small: b may have so little of what M is bad at that no Ritz value shows it (t
/// was wrong by 34 tolerances beside a Ritz value of 0.5, with 64 unknowns). That takes some ten milliseconds. Unit: 1.
const ELIMINATED: usize = 1_000;

/// The same where M is poor, or 𝒜 is not symmetric and no Ritz value is a bound (u was wrong by 2.1e-3 where 1.7e-5 was said, with 36 unknowns and
/// SSOR inside; by 17 tolerances with 1,026 and exact S_u). Unit: 1.
pub(super) const ELIMINATED_IN_DOUBT: usize = 5_000;

/// What is left of the equations at an iterate.
pub(super) struct Remainder<'a> {
    system: &'a System<'a, f64>,
    norms: &'a EnergyNorms<'a>,
    /// Digits of x that f64 has no room for, where residuals are sharp.
    low: Vec<f64>,
    /// b − 𝒜x.
    r: Vec<f64>,
    /// ‖r‖ / ‖b‖.
    pub(super) relative: f64,
    /// Residuals are had in twice the digits.
    pub(super) is_sharp: bool,
    /// ‖r‖ or M⁻¹r is small beside that of b.
    pub(super) is_near: bool,
    /// ‖M⁻¹b‖ in the energy norm of all fields, once it was asked for.
    of_b: Option<f64>,
    /// 𝒜⁻¹ of a small system, once it was asked for.
    elimination: Option<Result<Box<dyn Factorization>, SetupError>>,
    /// What the last digits of the entries of 𝒜 leave open of the x that was eliminated for, relative to x; infinite where 𝒜 is singular.
    pub(super) left_open: Option<Fields<f64>>,
    /// The residual may be mostly rounding.
    pub(super) is_rounding: bool,
    /// Products with 𝒜 that the residuals and their rounding took.
    pub(super) products: u64,
    /// Solves with M.
    pub(super) solves: u64,
}

impl<'a> Remainder<'a> {
    pub(super) fn new(system: &'a System<'a, f64>, norms: &'a EnergyNorms<'a>) -> Self {
        Self {
            system,
            norms,
            low: Vec::new(),
            r: Vec::new(),
            relative: f64::NAN,
            is_sharp: false,
            is_near: false,
            of_b: None,
            elimination: None,
            left_open: None,
            is_rounding: false,
            products: 0,
            solves: 0,
        }
    }

    /// False where residuals in twice the digits are had already, or never.
    pub(super) fn has_more_digits(&self) -> bool {
        !self.is_sharp && self.norms.entries().is_some()
    }

    /// From here on residuals in twice the digits; false where there are no more.
    pub(super) fn sharpen(&mut self) -> bool {
        let may = self.has_more_digits();
        if may {
            self.is_sharp = true;
            self.low.resize(self.system.rhs.len(), 0.0);
        }
        may
    }

    /// The residual that tolerances of a pass are relative to, itself relative to ‖b‖.
    pub(super) fn scale(&self) -> f64 {
        if self.is_sharp { 1.0 } else { self.relative }
    }

    /// Errors of x without the digits that f64 does not hold, which are dropped, relative to x; `None` where there are none. The residual is that of x
    /// from here on.
    pub(super) fn rounded(&mut self, x: &[f64], tolerance: f64) -> Option<Fields<f64>> {
        let blocks = self.norms.entries().filter(|_| self.is_sharp)?;
        let lost = self.norms.error(&self.low);
        self.low.fill(0.0);
        self.r.clear();
        self.r.extend_from_slice(self.system.rhs);
        blocks.residual(self.system.rhs, &[x], &mut self.r);
        let size = self.system.norm2(&self.r);
        self.relative = match size {
            0.0 => 0.0,
            size => size / self.system.norm2(self.system.rhs),
        };
        self.products += 1;
        Some(EnergyNorms::relative(
            lost,
            self.norms.solution(x),
            tolerance,
        ))
    }

    /// The errors of x by M⁻¹ of its residual, with what rounding may add to that.
    pub(super) fn judged(
        &mut self,
        x: &[f64],
        judge: &mut ErrorJudge,
        ritz: Option<f64>,
    ) -> Judged {
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
        if size == 0.0 && b == 0.0 {
            (self.is_near, self.is_rounding) = (true, false);
            self.products += 1;
            return Judged::exact(self.norms);
        }
        self.is_rounding = !self.is_sharp && {
            let rounding = self.norms.add_rounding(x, &mut self.r);
            size < FIRM * rounding
        };
        let mut e = vec![0.0; self.r.len()];
        preconditioner.solve(&self.r, &mut e, &mut work);
        self.products += 2;
        self.solves += 1;
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
            // an M⁻¹ that sees neither r nor b says nothing
            energy(&e) < NEAR * of_b
        };
        let doubts = self.doubts(ritz);
        let of = self.norms.solution(x);
        let (size, ritz) = self.followed(&e, (doubts, ritz), of, judge, &mut work);
        let judged = judge.judge(self.norms, (size, x), of, ritz);
        let is_doubted = self.norms.is_unsymmetric() || doubts.iter().any(|(_, doubt)| doubt > 0.0);
        let most = if is_doubted {
            ELIMINATED_IN_DOUBT
        } else {
            ELIMINATED
        };
        match self.r.len() <= most && judge.accepts(&judged) {
            true => judged.at_least(self.eliminated((x, of), judge)),
            false => judged,
        }
    }

    /// What of M⁻¹r is doubted field by field, from none to all, with this Ritz value of M⁻¹𝒜. Unit: 1.
    fn doubts(&self, ritz: Option<f64>) -> Fields<f64> {
        let is_blind = self.system.preconditioner.properties().blind;
        let doubt = match ritz {
            Some(ritz) if !is_blind => {
                let [least, most] = DOUBTED;
                let ritz = ritz.max(f64::MIN_POSITIVE);
                ((least / ritz).ln() / (least / most).ln()).clamp(0.0, 1.0)
            }
            _ => 1.0,
        };
        (self.norms.by_chance()).map(|_, by_chance| if by_chance { 1.0 } else { doubt })
    }

    /// Norms of `e = M⁻¹r`, with what follows it where that is doubted; the Ritz value stays where that bears it out.
    fn followed(
        &mut self,
        e: &[f64],
        (doubts, ritz): (Fields<f64>, Option<f64>),
        of: Fields<f64>,
        judge: &ErrorJudge,
        work: &mut [f64],
    ) -> (Fields<f64>, Option<f64>) {
        let size = self.norms.error(e);
        let is_followed = self.norms.is_unsymmetric() && judge.is_in_doubt(size, of);
        if !is_followed && doubts.iter().all(|(_, doubt)| doubt <= 0.0) {
            return (size, ritz);
        }
        let system = System {
            rhs: &self.r,
            ..*self.system
        };
        let series = Series::new((e, size), &system, self.norms, work);
        self.products += 1;
        self.solves += 1;
        let more = series.both();
        let all = more.iter().fold(0.0f64, |all, (_, more)| all.hypot(more));
        let is_blind = self.system.preconditioner.properties().blind;
        let least = if is_blind { COUPLED * all } else { 0.0 };
        let sum = if is_followed { series.sum() } else { size };
        // what Ritz values of some iterations did not show: a further pass has to
        let says = |ritz: &f64| *ritz < TRUSTED || !is_followed || judge.falls(&series, of);
        let size = size.map(|field, size| {
            let more = more[field].max(least).max(size);
            let mixed = size.powf(1.0 - doubts[field]) * more.powf(doubts[field]);
            mixed.max(sum[field])
        });
        (size, ritz.filter(says))
    }

    /// The errors of x by `𝒜⁻¹r` itself, where f64 has digits of that.
    fn eliminated(
        &mut self,
        (x, of): (&[f64], Fields<f64>),
        judge: &ErrorJudge,
    ) -> Option<Fields<f64>> {
        let norms = self.norms;
        let blocks = norms.entries()?;
        let matrix = blocks.assembled();
        let inverse = (self.elimination).get_or_insert_with(|| Faer.of_any_condition(&matrix));
        let inverse = match inverse {
            Ok(inverse) => inverse,
            Err(SetupError::Singular { .. }) => {
                self.left_open = Some(norms.layout().values(f64::INFINITY));
                return None;
            }
            Err(_) => return None,
        };
        let open = left_open(&matrix, &**inverse, norms, x);
        let open = judge.relative(open, of);
        self.left_open = Some(open);
        if open.iter().any(|(_, open)| open >= 1.0) {
            return None;
        }
        let mut e = vec![0.0; self.r.len()];
        inverse.solve(&self.r, &mut e, &mut vec![0.0; inverse.work_len()]);
        Some(judge.relative(norms.error(&e), of))
    }

    /// A pass for `𝒜z = r`, x ← x + z; the result is told relative to ‖b‖.
    pub(super) fn refine(
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
