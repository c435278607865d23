//! The linear systems of rock, contact and flow.

use super::jacobian::ContactJacobian;
use super::krylov::{self, Asked, Solved};
use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::pressed::{CoupledJacobian, Pressed, PressureSolver, of_contact};
use super::{Evaluation, LinearFailure};
use crate::contact::ContactState;
use crate::flow::surface;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::norm2;
use fracas_solvers::krylov::System;
use fracas_solvers::saddle::{FlowBlocks, PressureSchur, ThreeFieldsInverse};
use fracas_solvers::{Observer, SetupError};

impl Linear {
    /// `δ ← J⁻¹ (−r)` for `J = [A B1 Q1; B2 −H N; Q2 0 T]` by the block LDU in the order t, u, p around RACP, or with
    /// `inner = "exact"` by a sparse LU factorization of all fields.
    ///
    /// Its rows of p are multiplied by S_p⁻¹ ([`Pressed`]).
    ///
    /// # Errors
    /// [`LinearFailure`]; other states may hold more.
    pub(super) fn solve_coupled(
        &mut self,
        attempt: &Attempt<'_>,
        (states, h, lagged): (&[ContactState], Option<&Csr<f64>>, bool),
        (x, at): (&Iterate, &Evaluation),
        tolerance: f64,
        correction: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<Solved, LinearFailure> {
        let rhs = &at.residual;
        if self.is_direct(attempt.problem) {
            return self.factorize_coupled(attempt, (states, h, lagged), (x, at), rhs, correction);
        }
        let place = (states, h, lagged);
        self.linearized(attempt, place, (x, at), |linear, jacobian, fields| {
            let place = (jacobian, states);
            linear.iterate_coupled(attempt, place, fields, rhs, tolerance, correction, observer)
        })
    }

    /// `e ← M⁻¹ r` of all fields, an estimate of the error that leaves the residual r, or `J⁻¹ r` where all is factorized; and the Ritz value
    /// nearest to zero that was seen.
    ///
    /// # Errors
    /// [`LinearFailure`] of what is built for it.
    pub(super) fn error_of_coupled(
        &mut self,
        attempt: &Attempt<'_>,
        (states, h): (&[ContactState], Option<&Csr<f64>>),
        (x, at): (&Iterate, &Evaluation),
        residual: &[f64],
        observer: &mut dyn Observer,
    ) -> Result<(Vec<f64>, Option<f64>), LinearFailure> {
        let place = (states, h, false);
        let mut e = vec![0.0; residual.len()];
        if self.is_direct(attempt.problem) {
            self.factorize_coupled(attempt, place, (x, at), residual, &mut e)?;
            return Ok((e, Some(1.0)));
        }
        self.linearized(
            attempt,
            place,
            (x, at),
            |linear, jacobian, (flow, pressures)| {
                let problem = attempt.problem;
                linear.prepare(problem, jacobian, states, observer)?;
                let inverse = linear.inverse(problem, jacobian, states)?;
                let pressed = Pressed::new(pressures, flow);
                let (q1, layout) = (of_open(&flow.q1, states), attempt.layout());
                let mut r = residual.to_vec();
                pressed.scale(&layout, &mut r);
                let form = linear.settings().flow.form;
                let q2 = flow.is_coupled().then(|| pressed.q2());
                let preconditioner =
                    ThreeFieldsInverse::new(inverse, &q1, q2, pressed.unit(), form);
                preconditioner.solve(&r, &mut e, &mut vec![0.0; preconditioner.work_len()]);
                of_contact(&layout, states, &mut e);
                Ok(())
            },
        )?;
        Ok((e, self.smallest_ritz()))
    }

    /// What `act` makes of the Jacobian of rock and contact, of Q1, Q2 and T, and of S_p⁻¹ at a point.
    fn linearized<R>(
        &mut self,
        attempt: &Attempt<'_>,
        (states, h, lagged): (&[ContactState], Option<&Csr<f64>>, bool),
        (x, at): (&Iterate, &Evaluation),
        act: impl FnOnce(
            &mut Self,
            &ContactJacobian<'_>,
            (&FlowBlocks, &PressureSolver),
        ) -> Result<R, LinearFailure>,
    ) -> Result<R, LinearFailure> {
        let problem = attempt.problem;
        let unit = problem.saddle().unit();
        let b = self.normal_coupling.get_or_insert_with(|| {
            let b = problem.saddle().coupling();
            b.assemble()
        });
        let Some((flow, by_gap)) = attempt.flow_blocks((b, unit), states, at, x) else {
            unreachable!("called where something flows")
        };
        let by_rock = self.settings().flow.schur != PressureSchur::Transmissibility;
        let system = match by_rock && flow.is_coupled() {
            true => {
                let body = problem.body();
                let surface = surface(&body.mesh, problem.faces(), &body.materials, states, unit);
                surface.system(&flow.t, &by_gap)
            }
            false => flow.t.clone().into(),
        };
        let mut pressures = std::mem::take(&mut self.pressures);
        let ready = pressures
            .prepare(&system, &flow)
            .map_err(|error| match error {
                // T is regular then: the iterate is what is wrong
                SetupError::Singular { .. } if flow.is_coupled() => LinearFailure::Astray,
                error => error.into(),
            });
        let done = ready.and_then(|()| {
            let jacobian = problem.jacobian(states, h, at, lagged);
            act(self, &jacobian, (&flow, &pressures))
        });
        self.pressures = pressures;
        done
    }

    /// ‖r‖₂ of a residual of all fields, that of p as pressures by the S_p⁻¹ at hand.
    pub(super) fn size_of(&self, attempt: &Attempt<'_>, residual: &[f64]) -> f64 {
        let layout = attempt.layout();
        match attempt
            .flow
            .and_then(|_| self.pressures.scaled(&layout, residual))
        {
            Some(scaled) => norm2(&scaled),
            None => norm2(residual),
        }
    }

    /// The same around S_p⁻¹ at hand.
    #[allow(clippy::too_many_arguments)]
    fn iterate_coupled(
        &mut self,
        attempt: &Attempt<'_>,
        (jacobian, states): (&ContactJacobian<'_>, &[ContactState]),
        (flow, pressures): (&FlowBlocks, &PressureSolver),
        rhs: &[f64],
        tolerance: f64,
        correction: &mut [f64],
        observer: &mut dyn Observer,
    ) -> Result<Solved, LinearFailure> {
        let problem = attempt.problem;
        let pressed = Pressed::new(pressures, flow);
        let (q1, layout) = (of_open(&flow.q1, states), attempt.layout());
        let operator = CoupledJacobian::new(jacobian, (&q1, &pressed), states, layout);
        let mut rhs = rhs.to_vec();
        pressed.scale(&layout, &mut rhs);
        let form = self.settings().flow.form;
        let at = (jacobian, states);
        let solved = self.around(
            problem,
            at,
            observer,
            |inverse, gives_way, work, observer| {
                let q2 = flow.is_coupled().then(|| pressed.q2());
                let preconditioner =
                    ThreeFieldsInverse::new(inverse, &q1, q2, pressed.unit(), form);
                let system = System {
                    operator: &operator,
                    preconditioner: &preconditioner,
                    rhs: &rhs,
                };
                let asked = Asked {
                    short: None,
                    tolerance,
                    max_iterations: problem.body().solver.max_krylov,
                    patience: None,
                    gives_way,
                };
                correction.fill(0.0);
                krylov::solve(&system, asked, correction, observer, work)
            },
        )?;
        of_contact(&layout, states, correction);
        Ok(solved)
    }
}

/// Q1 without the columns of closed faces.
pub(super) fn of_open(q1: &SparseMatrix<f64>, states: &[ContactState]) -> Csr<f64> {
    let mut open = Triplets::new((q1.rows(), q1.cols()));
    for (value, (i, f)) in q1 {
        if states[f as usize] == ContactState::Open {
            open.add_triplet(i as usize, f as usize, *value);
        }
    }
    Csr::new(open.to_csr())
}
