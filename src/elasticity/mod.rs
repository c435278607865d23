//! Small-strain isotropic elasticity on Q1 hexahedra.

mod bricks;
mod constraints;
mod material;

pub use bricks::Bricks;
pub use constraints::Constraints;
pub use material::Elastic;
