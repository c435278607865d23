//! How far an iterate is from the solution at its states.

use super::krylov::{eigenvalue_of_freed, small_eigenvalue};
use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::{ContactJacobian, ContactProblem, Event, Failure, LinearFailure};
use crate::contact::ContactState;
use fracas_operators::Fields;
use fracas_solvers::Observer;
use fracas_solvers::krylov::{System, least};
use fracas_solvers::saddle::{
    EnergyNorms, ErrorJudge, FOLLOWS, Judged, Measure, P, Series, T, TRUSTED,
};

/// Errors of every field at states that no longer change: `e = J⁻¹r ≈ M⁻¹r` of a Newton iterate, judged as in `solve`, against
/// the largest norms of the run so far.
///
/// # Cost
/// Per judgement an application of M, two products with the saddle point and a few vectors; where faces slip and the error is near the
/// tolerance, one more of each.
pub(super) struct Accuracy<'s> {
    attempt: &'s Attempt<'s>,
    norms: EnergyNorms<'s>,
    judge: ErrorJudge,
    /// Which M said the errors before.
    by: Option<usize>,
    /// It was another one than that of the errors before them.
    renewed: bool,
    /// Largest norm of every field so far.
    pub(super) size: Fields<f64>,
    /// They know of this attempt.
    seen: bool,
}

impl<'s> Accuracy<'s> {
    /// `None` where the scene asks for residuals alone.
    pub(super) fn new(attempt: &'s Attempt<'s>) -> Option<Self> {
        let problem = attempt.problem;
        let asked = problem.body().solver.measure == Measure::Error;
        asked.then(|| Self {
            attempt,
            norms: attempt.norms(),
            judge: ErrorJudge::new(problem.body().solver.tolerance),
            by: None,
            renewed: false,
            size: attempt.size,
            seen: false,
        })
    }

    /// Springs in place of multipliers: what they let move freely is no error.
    pub(super) fn of_springs(attempt: &'s Attempt<'s>) -> Option<Self> {
        Self::new(attempt).map(|accuracy| Self {
            norms: accuracy.norms.without_jumps(),
            ..accuracy
        })
    }

    /// Nothing is known of the solution from here on.
    pub(super) fn begin(&mut self) {
        self.judge = ErrorJudge::new(self.attempt.problem.body().solver.tolerance);
    }

    /// The first iterate, with every closed face in stick, shows what the loads could do, also where the solution bears nothing; but not
    /// beside a flow, whose pressures are of any size in fractures that have yet to open.
    pub(super) fn first(&mut self, x: &Iterate) {
        if !self.seen && self.attempt.flow.is_none() {
            let whole = self.balanced(x);
            self.widen(&whole);
        }
    }

    /// All fields, tractions and pressures in the balanced unit.
    fn balanced(&self, x: &Iterate) -> Vec<f64> {
        let layout = self.attempt.layout();
        let mut whole = x.u.clone();
        whole.reserve_exact(layout.len() - x.u.len());
        whole.extend(x.t.iter().map(|pascal| pascal / layout.unit(T)));
        if self.attempt.flow.is_some() {
            whole.extend(x.p.iter().map(|pascal| pascal / layout.unit(P)));
        }
        whole
    }

    /// Errors are relative to the largest of the iterates judged; beside a flow, of this one and of the steps before.
    fn widen(&mut self, x: &[f64]) {
        let own = self.norms.solution(x);
        let before = match self.attempt.flow {
            None => self.size,
            Some(_) => self.attempt.size,
        };
        // NaN of an iterate that is lost does not count
        self.size = before.map(|field, size| size.max(own.get(field).unwrap_or(0.0)));
        self.seen = true;
    }

    /// The errors of x, which leaves this `residual` of the equations at its states; `solve` gives what M⁻¹ of a residual says.
    pub(super) fn of(
        &mut self,
        x: &Iterate,
        mut residual: Vec<f64>,
        solve: impl FnOnce(&[f64], (&EnergyNorms<'_>, &Doubt<'_>)) -> Result<Estimate, LinearFailure>,
    ) -> Result<Judged, Failure> {
        let whole = self.balanced(x);
        self.widen(&whole);
        self.norms.add_rounding(&whole, &mut residual);
        let in_doubt = |size: Fields<f64>| self.judge.is_in_doubt(size, self.size);
        let found = match residual.iter().all(|r| *r == 0.0) {
            // no load: nothing is prepared for it
            true => (vec![0.0; whole.len()], Some(1.0)).into(),
            false => solve(&residual, (&self.norms, &in_doubt))?,
        };
        // errors by one M say nothing of what a pass has gained by another
        let before = std::mem::replace(&mut self.by, found.by);
        self.renewed = before.is_some() && before != found.by;
        if self.renewed {
            self.begin();
        }
        let size = (found.size).unwrap_or_else(|| self.norms.error(&found.e));
        let mut judged = (self.judge).judge(&self.norms, (size, &whole), self.size, found.ritz);
        if let Some(followed) = found.followed {
            let tolerance = self.attempt.problem.body().solver.tolerance;
            let followed = EnergyNorms::relative(followed, self.size, tolerance);
            // NaN is kept
            judged.error = (judged.error).map(|field, error| match followed[field] <= error {
                true => error,
                false => followed[field],
            });
        }
        Ok(judged)
    }

    /// By how much the residual is still to be lowered for errors below the tolerance; `None` where they are, or where rounding
    /// leaves no more to gain. Around a poor M a step may leave errors along a hidden vector as they are: there the residual itself shows
    /// when it is rounding.
    pub(super) fn left(&self, judged: Judged) -> Option<f64> {
        let tolerance = self.attempt.problem.body().solver.tolerance;
        let is_rounding = judged.stands && judged.hidden >= 1.0;
        let enough = judged.worst() <= tolerance || is_rounding;
        (!enough && judged.estimate.is_finite()).then(|| judged.step(tolerance))
    }

    /// Whether the last errors are by another M than those before: what steps gain is then seen by the next ones.
    pub(super) fn is_renewed(&self) -> bool {
        self.renewed
    }

    /// Whether errors that rounding leaves are taken.
    pub(super) fn is_enough(&self, judged: Judged) -> bool {
        let settings = self.attempt.problem.body().solver;
        judged.worst() <= settings.tolerance.max(settings.state_tolerance)
    }

    /// Errors that rounding leaves are told; beyond what states are judged by they are a failure.
    pub(super) fn accepts(&self, judged: Judged, residual: f64) -> Result<Option<Event>, Failure> {
        let settings = self.attempt.problem.body().solver;
        let (part, error) = (judged.part(), judged.worst());
        match self.is_enough(judged) {
            true => Ok((error > settings.tolerance).then_some(Event::Rounding { part, error })),
            false => Err(Failure::Inaccurate {
                part,
                error,
                tolerance: settings.tolerance.max(settings.state_tolerance),
                residual,
            }),
        }
    }
}

/// Times that errors by M⁻¹r may be smaller than the tolerance where a look at freed jumps still says something: beyond, none of them has been
/// seen to hide as much. Unit: 1.
const HIDES: [f64; 4] = [1.0, FOLLOWS, FOLLOWS * FOLLOWS, FOLLOWS * FOLLOWS * FOLLOWS];

/// Whether errors of this size by M⁻¹r may be too large by what follows.
pub(super) type Doubt<'a> = dyn Fn(Fields<f64>) -> bool + 'a;

/// What M⁻¹r says of the error that leaves the residual r.
pub(super) struct Estimate {
    /// `e = M⁻¹r`.
    pub(super) e: Vec<f64>,
    /// The Ritz value of M⁻¹J nearest to zero.
    pub(super) ritz: Option<f64>,
    /// It has been looked for at freed jumps.
    looked: bool,
    /// Which M, where others may follow.
    by: Option<usize>,
    /// Norms of e, where M⁻¹r may be doubted.
    size: Option<Fields<f64>>,
    /// Norms of the error with what follows e, where J is not symmetric and those of e are in doubt.
    followed: Option<Fields<f64>>,
}

/// What is known of the eigenvalues of M⁻¹J.
pub(super) struct Seen<'a> {
    /// The Ritz value nearest to zero.
    pub(super) ritz: Option<f64>,
    /// Smaller ones have been looked for.
    pub(super) probed: bool,
    /// Faces of which M holds jumps that are free, where none have been looked for there.
    pub(super) freed: &'a [usize],
    /// M has just been made, and no iteration has seen it.
    pub(super) is_new: bool,
}

/// Of e and its Ritz value alone.
impl From<(Vec<f64>, Option<f64>)> for Estimate {
    fn from((e, ritz): (Vec<f64>, Option<f64>)) -> Self {
        Self {
            e,
            ritz,
            looked: false,
            by: None,
            size: None,
            followed: None,
        }
    }
}

impl Estimate {
    /// Whether M is poor, and the error is small by M⁻¹r and the Ritz value, but not by far: up to [`FOLLOWS`] squared.
    pub(super) fn may_hide(&self, in_doubt: &Doubt<'_>) -> bool {
        let poor = self.ritz.filter(|ritz| *ritz < TRUSTED);
        let (Some(ritz), Some(size)) = (poor, self.size) else {
            return false;
        };
        let of = |factor: f64| size.map(|_, size| size * factor * TRUSTED / ritz.abs());
        in_doubt(of(1.0)) || in_doubt(of(FOLLOWS))
    }

    /// By a solve with M; the Ritz value is that of those `seen`, and of a [look](small_eigenvalue) where none was had and M is of one level, or
    /// at what is free since M was made ([`eigenvalue_of_freed`]).
    pub(super) fn new(
        system: &System<'_, f64>,
        (norms, in_doubt): (&EnergyNorms<'_>, &Doubt<'_>),
        (is_symmetric, seen): (bool, Seen<'_>),
        observer: &mut dyn Observer,
    ) -> Self {
        let inverse = system.preconditioner;
        let mut e = vec![0.0; system.rhs.len()];
        inverse.solve(system.rhs, &mut e, &mut vec![0.0; inverse.work_len()]);
        let size = norms.error(&e);
        let mut ritz = seen.ritz;
        if !seen.probed {
            ritz = least([ritz, small_eigenvalue(system, norms, observer)]);
        }
        let times = |factor: f64| in_doubt(size.map(|_, size| size * factor));
        let looks = !seen.freed.is_empty() && (seen.is_new || HIDES.into_iter().any(times));
        if looks {
            let of_freed = eigenvalue_of_freed(system, norms, seen.freed, observer);
            ritz = least([ritz, of_freed]);
        }
        let is_doubtful = !is_symmetric && in_doubt(size);
        let followed = is_doubtful.then(|| {
            let mut work = vec![0.0; system.operator.work_len().max(inverse.work_len())];
            Series::new((&e, size), system, norms, &mut work).sum()
        });
        Self {
            e,
            ritz,
            looked: looks,
            by: None,
            size: Some(size),
            followed,
        }
    }
}

impl Linear {
    /// What M⁻¹ of a residual says of the error that leaves it. Where M of other states is poor and the error would be taken, M is made for these
    /// first: where it holds jumps that are free now, small eigenvalues of M⁻¹J come late or never (plates of 1:50 between open faces: a Ritz
    /// value of 0.005 was seen beside an eigenvalue of 3e-4, and displacements were wrong by 4e-3 where 2e-5 was said).
    pub(super) fn error_of(
        &mut self,
        problem: &ContactProblem<'_>,
        (jacobian, states): (&ContactJacobian<'_>, &[ContactState]),
        residual: &[f64],
        judged: (&EnergyNorms<'_>, &Doubt<'_>),
        observer: &mut dyn Observer,
    ) -> Result<Estimate, LinearFailure> {
        self.untold |= self.prepare(problem, jacobian, states, observer)?;
        let freed = self.freed(states);
        let mut is_new = false;
        loop {
            let inverse = self.inverse(problem, jacobian, states)?;
            let system = System {
                operator: jacobian,
                preconditioner: &inverse,
                rhs: residual,
            };
            let seen = Seen {
                ritz: self.smallest_ritz,
                probed: self.probed,
                freed: if self.looked { &[] } else { &freed },
                is_new,
            };
            let mut found =
                Estimate::new(&system, judged, (jacobian.is_symmetric(), seen), observer);
            drop(inverse);
            found.by = Some(self.builds);
            (self.smallest_ritz, self.probed) = (found.ritz, true);
            self.looked |= found.looked;
            let is_doubtful = self.is_of_others(states) && found.may_hide(judged.1);
            if !is_doubtful || !self.build_own(problem, jacobian, states, observer)? {
                return Ok(found);
            }
            self.untold = true;
            self.other_states();
            is_new = true;
        }
    }
}
