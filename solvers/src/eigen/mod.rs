//! Eigenvalues and singular values: dense ones by faer, extreme ones of large pencils by Lanczos, kernels by block
//! inverse iteration.
//!
//! Everything dense runs on one thread except products and triangular solves, which are split at fixed columns: the
//! same bits for any number of threads.

pub mod dense;
pub mod kernel;
pub mod lanczos;

pub use kernel::{Kernel, kernel_of};
pub use lanczos::{Ends, Extreme, LanczosSettings, Map, extreme_eigenvalues};
