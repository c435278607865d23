//! Claims about multigrid, assembled or not.
#![allow(clippy::unwrap_used)]

mod algebraic;
mod geometric;
mod geometric_family;
mod graded_slabs;
mod matrix_free;
mod plates;
mod refresh;
