//! The linear systems of rock, contact and flow.

use super::jacobian::ContactJacobian;
use super::krylov::{self, Asked, Ended, Solved};
use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::pressed::{CoupledJacobian, Pressed, PressureSolver};
use super::{Evaluation, LinearFailure};
use crate::contact::ContactState;
use crate::flow::surface;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::norm2;
use fracas_solvers::Observer;
use fracas_solvers::krylov::System;
use fracas_solvers::saddle::{FlowBlocks, PressureSchur, ThreeFieldsInverse};

impl Linear {
    /// `δ ← J⁻¹ (−r)` for `J = [A B1 Q1; B2 −H 0; Q2 0 T]` by the block LDU in the order t, u, p around RACP, or with
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
        if self.is_direct(attempt.problem) {
            return self.factorize_coupled(attempt, (states, h, lagged), (x, at), correction);
        }
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
        let ready = pressures.prepare(&system, &flow);
        let solved = ready.map_err(LinearFailure::from).and_then(|()| {
            let jacobian = problem.jacobian(states, h, at, lagged);
            let fields = (&flow, &pressures);
            let rhs = &at.residual;
            self.iterate_coupled(
                attempt,
                (&jacobian, states),
                fields,
                rhs,
                tolerance,
                correction,
                observer,
            )
        });
        self.pressures = pressures;
        solved
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
        let setup = self.prepare(problem, jacobian, states, observer)?;
        let mut work = std::mem::take(&mut self.resources.work);
        let inverse = self.inverse(problem, jacobian, states)?;
        let pressed = Pressed::new(pressures, flow);
        let q1 = Csr::new(flow.q1.clone());
        let operator = CoupledJacobian::new(jacobian, (&q1, &pressed), attempt.layout());
        let mut rhs = rhs.to_vec();
        pressed.scale(&attempt.layout(), &mut rhs);
        let form = self.settings().flow.form.for_coupling(flow.is_coupled());
        let preconditioner =
            ThreeFieldsInverse::new(inverse, &q1, pressed.q2(), pressed.unit(), form);
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
        };
        correction.fill(0.0);
        let ended = krylov::solve(&system, asked, correction, observer, &mut work);
        drop(preconditioner);
        self.resources.work = work;
        let Ended::Solved(solved) = ended? else {
            unreachable!("no patience is set")
        };
        self.judge_speed(problem, &solved);
        Ok(Solved { setup, ..solved })
    }
}
