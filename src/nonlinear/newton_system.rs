//! The linear system of one Newton step of a run, assembled.

use super::{ContactProblem, Evaluation, LinearRecord, Simulation, State, StepFailure};
use crate::contact::ContactState;
use crate::elasticity::ElasticityError;
use crate::jacobian::{turned, with_laws};
use fracas_operators::sparse::Csr;
use fracas_solvers::Observer;
use fracas_solvers::saddle::{SaddleBlocks, T, U};

/// `[A B1; B2 −H] (δu, δt) = −r` as Newton was about to solve it.
#[derive(Clone, Debug)]
pub struct NewtonSystem {
    /// Its blocks and right-hand side, tractions in Pa.
    pub blocks: SaddleBlocks,
    /// State per face.
    pub states: Vec<ContactState>,
    /// Attempt at its step, from 0.
    pub attempt: usize,
    /// Round of the active set, from 0.
    pub round: usize,
    /// Newton step of that round, from 0.
    pub newton: usize,
}

/// Why a run has no such system.
#[derive(Debug, thiserror::Error)]
pub enum NewtonSystemError {
    /// Springs have no tractions among their unknowns.
    #[error(
        "a run with method penalty or augmented_lagrangian has no saddle point; take method = \"lagrange\""
    )]
    Springs,
    /// Fewer systems than asked for.
    #[error(
        "step {step} solved {found} linear systems, so that there is no number {asked} (they count from 0)"
    )]
    NoSuch {
        /// Step.
        step: usize,
        /// Asked for.
        asked: usize,
        /// Systems of the step.
        found: usize,
    },
    /// The step failed before that system.
    #[error(transparent)]
    Step(#[from] Box<StepFailure>),
}

impl ContactProblem<'_> {
    /// The Jacobian and `−r` at a point evaluated with `h`, tractions in Pa; `lagged` leaves out the derivative of weakening.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn assembled(
        &self,
        states: &[ContactState],
        h: Option<&Csr<f64>>,
        at: &Evaluation,
        lagged: bool,
    ) -> Result<SaddleBlocks, ElasticityError> {
        Ok(self.linearized((self.stick_blocks()?, 1.0), states, h, at, lagged))
    }

    /// The same from the blocks with every face in stick, tractions counted in `unit`.
    pub(super) fn linearized(
        &self,
        (stick, unit): (SaddleBlocks, f64),
        states: &[ContactState],
        h: Option<&Csr<f64>>,
        at: &Evaluation,
        lagged: bool,
    ) -> SaddleBlocks {
        let rows = at.rows(lagged);
        let s = self.saddle().unit() / unit;
        // D H: H is symmetric
        let form = h.map(|h| turned(h.matrix(), rows).map(|v| v / (s * s)));
        let layout = self.saddle().layout();
        let [r_u, r_t] = layout.split([U, T], &at.residual[..layout.len()]);
        let all_stick = states.iter().all(|s| *s == ContactState::Stick);
        SaddleBlocks {
            b2: (!all_stick).then(|| turned(&stick.b1, rows)),
            h: with_laws(form, rows, |f| unit * unit * self.faces()[f].area),
            rhs_u: r_u.to_vec(),
            rhs_t: r_t.iter().map(|r| r / s).collect(),
            ..stick
        }
    }
}

impl Simulation<'_> {
    /// Linear system number `asked` of the step after `state`, counted from 0 over its attempts and rounds as in
    /// `solver.csv`; the step goes no further.
    ///
    /// # Errors
    /// [`NewtonSystemError`].
    pub fn newton_system(
        &mut self,
        state: &State,
        asked: usize,
        observer: &mut dyn Observer,
    ) -> Result<NewtonSystem, NewtonSystemError> {
        let Some(wanted) = self.wanted_system() else {
            return Err(NewtonSystemError::Springs);
        };
        *wanted = Some(asked);
        let outcome = self.advance(state, observer);
        if let Some(system) = self.take_system() {
            return Ok(system);
        }
        let solved = |linear: &[LinearRecord]| NewtonSystemError::NoSuch {
            step: state.step,
            asked,
            found: linear.len(),
        };
        match outcome {
            Ok(accepted) => Err(solved(&accepted.linear)),
            Err(failure) => Err(failure.into()),
        }
    }
}
