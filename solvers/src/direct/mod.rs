//! Sparse direct solvers behind one seam: faer with METIS ordering always, CHOLMOD and UMFPACK with the feature
//! `suitesparse`, the system's MUMPS with the feature `petsc`.
//!
//! A backend is one file (or folder) here and one line in [`DirectChoice`].
//!
//! # Licence
//! CHOLMOD's supernodal module and UMFPACK are GPL-2.0-or-later: a binary built with the feature `suitesparse` is
//! under the GPL. Without it everything is MIT OR Apache-2.0.

mod choice;
#[cfg(feature = "suitesparse")]
mod cholmod;
pub mod condition;
mod equilibration;
mod faer_backend;
mod graph;
#[cfg(feature = "petsc")]
pub(crate) mod mumps;
pub mod nested_dissection;
mod partition;
mod pattern;
mod pivots;
mod refinement;
#[cfg(feature = "suitesparse")]
mod umfpack;

pub use choice::{DirectChoice, UnknownDirect};
#[cfg(feature = "suitesparse")]
pub use cholmod::Cholmod;
pub use condition::reciprocal_condition;
pub use faer_backend::Faer;
#[cfg(feature = "petsc")]
pub use mumps::Mumps;
pub use partition::partition;
#[cfg(feature = "suitesparse")]
pub use umfpack::Umfpack;

use crate::SetupError;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;
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
    /// Plain name: `faer`, `cholmod`, `umfpack`, `mumps`.
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
    /// `z ← A⁻ᵀ r`; `z` and `work` (of `work_len()` entries) arrive with arbitrary content.
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]);

    /// Solves for `columns` right-hand sides stored one after the other, in place, on all threads of the pool.
    fn solve_many(&self, columns: usize, b: &mut [f64]) {
        assert_eq!(b.len(), columns * self.size(), "{columns} right-hand sides");
        if self.size() == 0 {
            return;
        }
        b.par_chunks_exact_mut(self.size()).for_each_init(
            || (vec![0.0; self.size()], vec![0.0; self.work_len()]),
            |(r, work), z| {
                r.copy_from_slice(z);
                self.solve(r, z, work);
            },
        );
    }

    /// Entries of the factors; where a backend does not tell, the bound that its symbolic factorization gives.
    fn factor_entries(&self) -> usize;

    /// The same with factors in f32, which take half the memory and half the time of a solve, where A is far from singular and the
    /// backend has them.
    fn in_single(&self) -> Option<Box<dyn Preconditioner<f64>>> {
        None
    }

    /// log₂ |det A|, for checks and for judging scale; `None` where the backend does not tell.
    fn log2_abs_determinant(&self) -> Option<f64>;
}

/// Columns that one task of `solve_many` handles at once: wide enough for matrix-matrix kernels.
const COLUMNS_PER_TASK: usize = 8;

/// Runs `solve(columns, part)` over blocks of columns, in parallel; blocks depend on the number of columns alone, so
/// the result does not depend on the number of threads.
fn for_column_blocks(n: usize, b: &mut [f64], solve: impl Fn(usize, &mut [f64]) + Sync) {
    if n > 0 {
        b.par_chunks_mut(n * COLUMNS_PER_TASK)
            .for_each(|part| solve(part.len() / n, part));
    }
}
