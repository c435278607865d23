//! Small-strain isotropic elasticity on Q1 hexahedra.

mod constraints;
mod material;

pub use constraints::Constraints;
pub use material::Elastic;
