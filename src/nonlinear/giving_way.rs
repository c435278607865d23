//! A linear system around an inner solver that the program chose and with which the iteration gets nowhere: the next one solves it.

use super::jacobian::FaceTangent;
use super::kept::Kept;
use super::krylov::{Ended, Solved, Stalled};
use super::linear::Linear;
use super::state_c::{StickC, c_of};
use super::workspace::Workspace;
use super::{ContactJacobian, ContactProblem, LinearFailure};
use crate::contact::ContactState;
use crate::matrix_free::MatrixFreeError;
use fracas_solvers::Observer;
use fracas_solvers::saddle::{InnerChoice, Racp, RacpInverse};

/// Of an iteration around an exact S_u⁻¹.
const NEARLY_SINGULAR: &str = "S_u is factorized, so that the system is nearly singular, as it is next to a load at which slip runs away or a body comes loose; smaller steps may show which";

/// Where others could not be set up.
const NO_DIGITS: &str = "no inner solver serves, as bodies this slender, cells this flat or contrasts this large leave f64 no digits for a factorization; take less of them";

impl Stalled {
    /// Why another inner solver takes the place of this one.
    pub(super) fn reason(&self, inner: InnerChoice) -> String {
        let Self {
            krylov,
            iterations,
            relative_residual,
        } = self;
        format!(
            "{krylov} with {inner} leaves a relative residual of {relative_residual:.1e} in {iterations} iterations"
        )
    }
}

impl Linear {
    /// A system around RACP that `solve` solves, where it is told whether another inner solver goes on where that gets nowhere; the iterations
    /// of all inner solvers are counted. The next one begins anew, so that a restart finds the same numbers.
    pub(super) fn around(
        &mut self,
        problem: &ContactProblem<'_>,
        (jacobian, states): (&ContactJacobian<'_>, &[ContactState]),
        observer: &mut dyn Observer,
        mut solve: impl FnMut(
            RacpInverse<'_>,
            bool,
            &mut Workspace,
            &mut dyn Observer,
        ) -> Result<Ended, LinearFailure>,
    ) -> Result<Solved, LinearFailure> {
        let (mut setup, mut spent) = (false, 0);
        loop {
            setup |= self.prepare(problem, jacobian, states, observer)?;
            let mut work = std::mem::take(&mut self.resources.work);
            let fallbacks = &self.resources.fallbacks;
            let next = fallbacks.without_stagnation(problem, self.settings, work.available());
            let inverse = self.inverse(problem, jacobian, states)?;
            let ended = solve(inverse, next.is_some(), &mut work, observer);
            self.resources.work = work;
            match (ended.map_err(|failure| self.told_of(failure))?, next) {
                (Ended::Solved(solved), _) => {
                    self.judge_speed(problem, &solved);
                    return Ok(Solved {
                        setup,
                        iterations: spent + solved.iterations,
                        ..solved
                    });
                }
                (Ended::Stalled(stalled), Some(next)) => {
                    spent += stalled.iterations;
                    setup = true;
                    self.give_way(problem, (next, stalled), observer)?;
                }
                _ => unreachable!("neither patience nor another inner solver"),
            }
        }
    }

    /// The same failure; it advises no other inner solver where S_u is factorized, or others could not be set up.
    fn told_of(&self, mut failure: LinearFailure) -> LinearFailure {
        if let LinearFailure::IterationLimit { advice, .. } = &mut failure {
            if matches!(self.settings.inner, InnerChoice::Exact { .. }) {
                *advice = NEARLY_SINGULAR;
            } else if self.resources.fallbacks.lacks_digits() {
                *advice = NO_DIGITS;
            }
        }
        failure
    }

    /// The preconditioner of the all-stick body.
    pub(super) fn prepare_stick(
        &mut self,
        problem: &ContactProblem<'_>,
        observer: &mut dyn Observer,
    ) -> Result<(), LinearFailure> {
        let all_stick = vec![ContactState::Stick; problem.faces().len()];
        let c = |c: &StickC| c_of(&c.rules(|_| FaceTangent::STICK, None));
        self.stick = Some(self.build(problem, all_stick, c, observer)?);
        Ok(())
    }

    /// Sets up `next`, or what takes its place; where nothing can be, the one at hand goes on to its limit.
    fn give_way(
        &mut self,
        problem: &ContactProblem<'_>,
        (next, stalled): (Racp, Stalled),
        observer: &mut dyn Observer,
    ) -> Result<(), LinearFailure> {
        let before = std::mem::replace(&mut self.settings, next);
        let stick = self.stick.take();
        let present = std::mem::take::<Kept>(&mut self.present);
        let fallbacks = &mut self.resources.fallbacks;
        fallbacks.give_way(before, next, stalled.reason(before.inner));
        match self.prepare_stick(problem, observer) {
            Ok(()) => {
                (self.reference, self.slow) = (None, false);
                self.other_states();
                Ok(())
            }
            Err(stop @ LinearFailure::MatrixFree(MatrixFreeError::Stopped)) => Err(stop),
            Err(_) => {
                (self.settings, self.stick, self.present) = (before, stick, present);
                self.resources.fallbacks.take_back(before);
                Ok(())
            }
        }
    }
}
