//! Smoothers: cheap preconditioners from the entries of one matrix, and the inner parts of multigrid.

pub(crate) mod entries;
mod jacobi;
#[cfg(test)]
mod samples;
mod ssor;

pub use jacobi::{Jacobi, JacobiBlock, JacobiInverse};
pub use ssor::{Ssor, SsorInverse};
