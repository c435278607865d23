//! Sparse direct solvers behind one seam: faer with METIS ordering always, CHOLMOD and UMFPACK with the feature
//! `suitesparse`.

use crate::SetupError;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use std::fmt::Debug;

/// What may be assumed about the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Symmetric positive definite: LLᵀ.
    Spd,
    /// `[A Bᵀ; B −C]` with A and C positive definite: LDLᵀ without pivoting exists for every ordering.
    QuasiDefinite,
    /// Anything square: LU with pivoting.
    General,
}

/// A sparse direct method.
pub trait DirectSolver: Debug + Send + Sync {
    /// Plain name: `faer`, `cholmod`, `umfpack`.
    fn name(&self) -> &'static str;

    /// Ordering and symbolic factorization: depends on the pattern only and outlives a Newton loop.
    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError>;
}

/// An analysed pattern.
pub trait Symbolic: Debug + Send + Sync {
    /// Numeric factorization of a matrix with the analysed pattern.
    fn factor(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Factorization>, SetupError>;
}

/// A factorized matrix: `solve` is A⁻¹ r.
pub trait Factorization: Preconditioner<f64> {
    /// Solves for `columns` right-hand sides stored one after the other, in place, on all threads of the pool.
    fn solve_many(&self, columns: usize, b: &mut [f64]);

    /// Entries of the factors.
    fn factor_entries(&self) -> usize;

    /// log₂ |det A|, for checks and for judging scale; `None` where the backend does not tell.
    fn log2_abs_determinant(&self) -> Option<f64>;
}
