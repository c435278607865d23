//! Eigenvalues and singular values: dense ones by faer, extreme ones of large pencils by Lanczos, kernels by block
//! inverse iteration.
//!
//! Everything dense runs on one thread except products, triangular solves and the tridiagonal reduction, which are split at
//! fixed columns: the
//! same bits for any number of threads.

pub mod dense;
pub mod factors;
pub mod kernel;
pub mod lanczos;
mod tridiagonal;

pub use kernel::{Kernel, kernel_of};
pub use lanczos::{Ends, Extreme, Lanczos, LanczosSettings, Map, extreme_eigenvalues};
