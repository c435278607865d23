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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::nonlinear::Start;
    use crate::scene::named;
    use fracas_operators::LinearOperator;
    use fracas_solvers::Silent;
    use fracas_solvers::saddle::SaddleOperator;

    #[test]
    fn its_products_are_those_of_the_operator_in_every_state() {
        let body = named("cycle")
            .unwrap()
            .small_scene()
            .unwrap()
            .build()
            .unwrap();
        let problem = ContactProblem::new(&body).unwrap();
        let layout = problem.saddle().layout();
        let (n_u, n_t) = (layout.length(U), layout.length(T));
        let number = |k: usize| (1.3 * k as f64).sin();
        let states: Vec<ContactState> = (0..n_t / 3)
            .map(|f| ContactState::from_code((f % 4) as u8).unwrap())
            .collect();
        let u: Vec<f64> = (0..n_u).map(|k| 1e-4 * number(k)).collect();
        let t: Vec<f64> = (0..n_t).map(|k| 1e5 * number(k + 7) - 2e5).collect();
        let load = problem.loads().at(0.0, 1.0);
        let start = Start {
            jump: vec![0.0; n_t],
            slip: vec![0.0; n_t / 3 * 2],
            path: Vec::new(),
            t: vec![0.0; n_t],
            torn: Vec::new(),
            limits_at: Vec::new(),
        };
        let h = problem.stabilization(&states);
        let at = problem.evaluate(&states, h.as_ref(), [&u, &t], &start, &load);
        let blocks = problem.assembled(&states, h.as_ref(), &at, false).unwrap();
        let jacobian = problem.jacobian(&states, h.as_ref(), &at, false);
        let unit = problem.saddle().unit();
        let x: Vec<f64> = (0..n_u + n_t).map(|k| number(3 * k + 1)).collect();
        let mut y = vec![0.0; n_u + n_t];
        jacobian.apply(&x, &mut y, &mut vec![0.0; jacobian.work_len()]);
        // tractions of x in the balanced unit
        let scaled: Vec<f64> = (0..n_u + n_t)
            .map(|i| if i < n_u { x[i] } else { unit * x[i] })
            .collect();
        let operator = SaddleOperator::new(&blocks);
        let mut z = vec![0.0; n_u + n_t];
        operator.apply(&scaled, &mut z, &mut vec![0.0; operator.work_len()]);
        let [z_t] = layout.split_mut([T], &mut z);
        z_t.iter_mut().for_each(|z| *z *= unit);
        let rhs: Vec<f64> = blocks
            .rhs_u
            .iter()
            .copied()
            .chain(blocks.rhs_t.iter().map(|r| unit * r))
            .collect();
        for (name, a, b) in [("J x", &y, &z), ("-r", &at.residual, &rhs)] {
            for part in [layout.range(U), layout.range(T)] {
                let size = part.clone().fold(0.0f64, |m, i| m.max(a[i].abs()));
                assert!(size > 0.0, "{name}: nothing to compare");
                for i in part {
                    assert!(
                        (a[i] - b[i]).abs() <= 1e-12 * size,
                        "{name} {i}: {} {}",
                        a[i],
                        b[i]
                    );
                }
            }
        }
    }

    #[test]
    fn a_run_gives_the_systems_that_it_solves() {
        let body = named("cycle")
            .unwrap()
            .small_scene()
            .unwrap()
            .build()
            .unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        let done = loop {
            let done = simulation.advance(&state, &mut Silent).unwrap();
            let slips = |l: &&LinearRecord| l.faces[1] + l.faces[2] > 0;
            if done.linear.iter().any(|l| slips(&l)) {
                break done;
            }
            state = done.state;
        };
        for (k, record) in done.linear.iter().enumerate() {
            let system = simulation.newton_system(&state, k, &mut Silent).unwrap();
            assert_eq!(
                (system.attempt, system.round, system.newton),
                (record.attempt, record.active, record.newton)
            );
            assert_eq!(super::super::record::count(&system.states), record.faces);
        }
        let last = simulation.newton_system(&state, done.linear.len(), &mut Silent);
        assert!(
            matches!(last, Err(NewtonSystemError::NoSuch { .. })),
            "{last:?}"
        );
        // it has left no trace
        let again = simulation.advance(&state, &mut Silent).unwrap();
        assert_eq!(again.linear.len(), done.linear.len());
    }
}
