//! Linear systems by one factorization: those of rock, contact and flow where the exact choice is asked for, those of rock and contact where
//! an iteration does not solve them.

use super::jacobian::{ContactJacobian, FaceTangent};
use super::krylov::{Solved, USEFUL};
use super::linear::Linear;
use super::newton::{Attempt, Iterate};
use super::{ContactProblem, Evaluation, LinearFailure};
use crate::contact::ContactState;
use fracas_operators::LinearOperator;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::vector::{axpy, norm2};
use fracas_solvers::SetupError;
use fracas_solvers::direct::Kind;
use fracas_solvers::saddle::{InnerChoice, SaddleBlocks};

/// Share of the compliance of a face that its tractions are given as a pivot. Unit: 1.
const FIRM: f64 = 1e-9;

impl Linear {
    /// `δ ← J⁻¹ b` for `J = [A B1 Q1; B2 −H N; Q2 0 T]`, [`through_pressure`] N, by a sparse LU factorization of all fields.
    ///
    /// # Errors
    /// [`LinearFailure::Singular`] where the states hold too little; other states may hold more.
    pub(super) fn factorize_coupled(
        &mut self,
        attempt: &Attempt<'_>,
        (states, h, lagged): (&[ContactState], Option<&Csr<f64>>, bool),
        (x, at): (&Iterate, &Evaluation),
        rhs: &[f64],
        correction: &mut [f64],
    ) -> Result<Solved, LinearFailure> {
        let unit = attempt.problem.saddle().unit();
        let stick = self.all_stick(attempt.problem)?;
        let place = (h, x);
        let blocks = attempt.coupled((stick, unit), states, place, at, lagged);
        let jacobian = attempt.problem.jacobian(states, h, at, lagged);
        let through = through_pressure(&jacobian, &blocks);
        let exact = &blocks.assembled() + &through;
        let matrix = &exact + &pivots(states, &blocks, attempt.problem);
        self.factorize(
            (exact, matrix, "[A B1 Q1; B2 −H N; Q2 0 T]"),
            rhs,
            correction,
        )
    }

    /// The blocks with every face in stick, tractions in the balanced unit.
    fn all_stick(&mut self, problem: &ContactProblem<'_>) -> Result<SaddleBlocks, LinearFailure> {
        let unit = problem.saddle().unit();
        let stick = match self.stick_blocks.take() {
            Some(stick) => stick,
            None => problem.stick_blocks()?.into_traction_unit(unit),
        };
        Ok(self.stick_blocks.insert(stick).clone())
    }

    /// What is left of a system of rock and contact that an iteration around an exact S_u⁻¹ does not solve: `x ← J⁻¹ b` by a sparse LU
    /// factorization, where it leaves a residual that is of use. Next to a critical load J is nearly singular with weakening, and M knows
    /// nothing of that.
    ///
    /// # Errors
    /// `failure`, that of the iteration, where J cannot be factorized or is singular.
    pub(super) fn factorize_contact(
        &mut self,
        problem: &ContactProblem<'_>,
        (jacobian, states): (&ContactJacobian<'_>, &[ContactState]),
        rhs: &[f64],
        x: &mut [f64],
        failure: LinearFailure,
    ) -> Result<Solved, LinearFailure> {
        let LinearFailure::IterationLimit { iterations, .. } = failure else {
            return Err(failure);
        };
        if !matches!(self.settings().inner, InnerChoice::Exact { .. }) {
            return Err(failure);
        }
        self.slow = true;
        self.beyond += iterations as f64;
        let Ok(stick) = self.all_stick(problem) else {
            return Err(failure);
        };
        let blocks = jacobian.blocks(stick);
        let exact = blocks.assembled();
        let matrix = &exact + &pivots(states, &blocks, problem);
        match self.factorize((exact, matrix, "[A B1; B2 −H]"), rhs, x) {
            Ok(solved) if solved.relative_residual <= USEFUL => Ok(Solved {
                iterations: iterations + solved.iterations,
                ..solved
            }),
            _ => Err(failure),
        }
    }

    /// `x ← J⁻¹ b` by a factorization of `matrix`, which is J with pivots that it lacks, and a refinement on J itself.
    fn factorize(
        &mut self,
        (exact, matrix, block): (SparseMatrix<f64>, SparseMatrix<f64>, &'static str),
        rhs: &[f64],
        correction: &mut [f64],
    ) -> Result<Solved, LinearFailure> {
        let singular = |error: SetupError| match error {
            SetupError::Singular { .. } => LinearFailure::Singular(error.in_block(block)),
            error => LinearFailure::Setup(error),
        };
        let solver = self.settings().inner.backend().solver()?;
        let symbolic = solver.analyze(&matrix, Kind::General).map_err(singular)?;
        let factors = symbolic.factor(&matrix).map_err(singular)?;
        let mut work = vec![0.0; factors.work_len()];
        factors.solve(rhs, correction, &mut work);
        // refined on J itself
        let operator = Csr::new(exact);
        let mut products = vec![0.0; operator.work_len()];
        let mut left = rhs.to_vec();
        operator.apply_add(-1.0, correction, &mut left, &mut products);
        let mut more = vec![0.0; left.len()];
        factors.solve(&left, &mut more, &mut work);
        axpy(1.0, &more, correction);
        left.copy_from_slice(rhs);
        operator.apply_add(-1.0, correction, &mut left, &mut products);
        Ok(Solved {
            krylov: "direct",
            iterations: 1,
            relative_residual: norm2(&left) / norm2(rhs),
            smallest_ritz: None,
            stopped: false,
            setup: true,
        })
    }
}

/// `N = D H E`, E the place of a pressure in the normal row of its face, in a matrix of all fields: H does not act on what a pressure changes
/// of t_N.
pub(super) fn through_pressure(
    jacobian: &ContactJacobian<'_>,
    blocks: &SaddleBlocks,
) -> SparseMatrix<f64> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let n = blocks.layout().len();
    let mut through = Triplets::new((n, n));
    for (i, row) in jacobian
        .h
        .iter()
        .flat_map(|h| h.matrix().outer_iterator().enumerate())
    {
        let (face, m) = (i / 3, i % 3);
        let d = (jacobian.faces.as_ref()).map_or(FaceTangent::STICK.by_jump, |f| f[face].by_jump);
        for (j, value) in row.iter().filter(|(j, _)| j % 3 == 0) {
            for k in (0..3).filter(|k| d[*k][m] != 0.0) {
                through.add_triplet(n_u + 3 * face + k, n_u + n_t + j / 3, d[k][m] * value);
            }
        }
    }
    through.to_csr()
}

/// `−ε ω A_f` on the diagonal of the rows of t: tractions that no displacement sees (one cell between rollers) have a pivot, and the
/// correction leaves them where they are, on closed faces that of the rock, `t_N − p`. Refinement takes the rest of it out.
fn pivots(
    states: &[ContactState],
    blocks: &SaddleBlocks,
    problem: &ContactProblem<'_>,
) -> SparseMatrix<f64> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let n = blocks.layout().len();
    let mut pivots = Triplets::new((n, n));
    for (f, state) in states.iter().enumerate() {
        let pivot = FIRM * problem.law_entry(f);
        let rows = (3 * f..3 * f + 3).map(|i| n_u + i);
        rows.for_each(|i| pivots.add_triplet(i, i, -pivot));
        if *state != ContactState::Open && blocks.flow.is_some() {
            pivots.add_triplet(n_u + 3 * f, n_u + n_t + f, pivot);
        }
    }
    pivots.to_csr()
}
