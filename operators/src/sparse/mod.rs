//! Sparse operators. Assembly and sparse products use `sprs`; every product in a hot loop uses the types here.

mod block3;
mod csr;
mod diagonal;
mod finite;
mod pattern;

pub use block3::Block3;
pub use csr::{Csr, CsrView};
pub use diagonal::Diagonal;
pub use finite::first_not_finite;
pub use pattern::{Pattern, SparseRows, Transposed};

/// A sparse matrix in compressed rows or columns: 32-bit indices, 64-bit offsets.
pub type SparseMatrix<R> = sprs::CsMatI<R, u32, usize>;

/// An editable list of (row, column, value) that sums duplicates when it becomes a [`SparseMatrix`].
pub type Triplets<R> = sprs::TriMatI<R, u32>;
