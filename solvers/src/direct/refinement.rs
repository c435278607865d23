//! One step of iterative refinement after every solve.

use super::Factorization;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::vector::axpy;
use fracas_operators::{AdjointOperator, LinearOperator, Preconditioner, Properties};

/// `z = F⁻¹ r`, then `z ← z + F⁻¹ (r − A z)` with approximate factors `F ≈ A`.
///
/// One step in working precision makes a factorization without or with weak pivoting backward stable, row by row.
///
/// # Cost
/// Two solves and one product.
///
/// # Source
/// R. D. Skeel, Math. Comp. 35 (1980) 817–832.
#[derive(Debug)]
pub(super) struct Refined<F> {
    matrix: Csr<f64>,
    factors: F,
}

impl<F: Factorization> Refined<F> {
    /// Factors with the matrix they came from.
    pub(super) fn new(matrix: &SparseMatrix<f64>, factors: F) -> Self {
        Self {
            matrix: Csr::new(matrix.clone()),
            factors,
        }
    }
}

impl<F: Factorization> Preconditioner<f64> for Refined<F> {
    fn size(&self) -> usize {
        self.factors.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (residual, work) = work.split_at_mut(self.size());
        let (correction, work) = work.split_at_mut(self.size());
        self.factors.solve(r, z, work);
        residual.copy_from_slice(r);
        self.matrix.apply_add(-1.0, z, residual, &mut []);
        self.factors.solve(residual, correction, work);
        axpy(1.0, correction, z);
    }

    fn work_len(&self) -> usize {
        2 * self.size() + self.factors.work_len()
    }

    fn flops(&self) -> u64 {
        2 * self.factors.flops() + self.matrix.flops() + 2 * self.size() as u64
    }

    fn properties(&self) -> Properties {
        self.factors.properties()
    }
}

impl<F: Factorization> Factorization for Refined<F> {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (residual, work) = work.split_at_mut(self.size());
        let (correction, work) = work.split_at_mut(self.size());
        self.factors.solve_adjoint(r, z, work);
        residual.copy_from_slice(r);
        self.matrix.apply_adjoint_add(-1.0, z, residual, &mut []);
        self.factors.solve_adjoint(residual, correction, work);
        axpy(1.0, correction, z);
    }

    fn solve_many(&self, columns: usize, b: &mut [f64]) {
        let n = self.size().max(1);
        let mut residual = b.to_vec();
        self.factors.solve_many(columns, b);
        for (z, r) in b.chunks_exact(n).zip(residual.chunks_exact_mut(n)) {
            self.matrix.apply_add(-1.0, z, r, &mut []);
        }
        self.factors.solve_many(columns, &mut residual);
        axpy(1.0, &residual, b);
    }

    fn factor_entries(&self) -> usize {
        self.factors.factor_entries()
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        self.factors.log2_abs_determinant()
    }
}
