//! Stiffness products without a matrix.

mod bricks;
mod colours;
mod line;
mod modes;

pub use bricks::Bricks;
