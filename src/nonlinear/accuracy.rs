//! How far an iterate is from the solution at its states.

use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::{Evaluation, Failure};
use crate::contact::ContactState;
use fracas_operators::sparse::Csr;
use fracas_solvers::Observer;
use fracas_solvers::saddle::{EnergyNorms, ErrorJudge, Judged, Measure};

/// Errors of u and t at states that no longer change: `e = J⁻¹r ≈ M⁻¹r` of a Newton iterate, judged as in `solve`, against
/// the largest norms of the run so far.
///
/// # Cost
/// Per judgement an application of M, two products with the saddle point and a few vectors.
pub(super) struct Accuracy<'s> {
    attempt: &'s Attempt<'s>,
    norms: EnergyNorms<'s>,
    judge: ErrorJudge,
    /// Largest norms of u and t so far.
    pub(super) size: [f64; 2],
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
            norms: problem.norms(attempt.held.as_ref()),
            judge: ErrorJudge::default(),
            size: attempt.size,
            seen: false,
        })
    }

    /// Rounds begin: nothing is known of their solution.
    pub(super) fn begin(&mut self, linear: &mut Linear) {
        self.judge = ErrorJudge::default();
        linear.other_states();
    }

    /// The states change after x. The first one, with every closed face in stick, shows what the loads could do, also where the
    /// solution bears nothing.
    pub(super) fn other_states(&mut self, x: &Iterate, linear: &mut Linear) {
        self.begin(linear);
        if !self.seen {
            let whole = self.balanced(x);
            self.widen(&whole);
        }
    }

    /// (u, t), tractions in the balanced unit.
    fn balanced(&self, x: &Iterate) -> Vec<f64> {
        let unit = self.attempt.problem.saddle().unit();
        let mut whole = x.u.clone();
        whole.extend(x.t.iter().map(|t| t / unit));
        whole
    }

    fn widen(&mut self, x: &[f64]) {
        let own = self.norms.solution(x);
        for (size, own) in self.size.iter_mut().zip(own) {
            // NaN of an iterate that is lost does not count
            *size = size.max(own);
        }
        self.seen = true;
    }

    /// The errors of x, `at` its equations at these states.
    pub(super) fn of(
        &mut self,
        (states, h): (&[ContactState], Option<&Csr<f64>>),
        (x, at): (&Iterate, &Evaluation),
        linear: &mut Linear,
        observer: &mut dyn Observer,
    ) -> Result<Judged, Failure> {
        let problem = self.attempt.problem;
        let whole = self.balanced(x);
        self.widen(&whole);
        let mut residual = at.residual.clone();
        self.norms.add_rounding(&whole, &mut residual);
        let (e, ritz) = match residual.iter().all(|r| *r == 0.0) {
            // no load: nothing is prepared for it
            true => (residual, Some(1.0)),
            false => {
                let jacobian = problem.jacobian(states, h, at, false);
                let parts = (&jacobian, states);
                linear.error_of(problem, parts, &residual, &self.norms, observer)?
            }
        };
        Ok((self.judge).judge(&self.norms, (&e, &whole), self.size, ritz))
    }
}
