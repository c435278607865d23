//! Small-strain isotropic elasticity on Q1 hexahedra.

mod assembled;
mod check;
mod constraints;
mod diagonal;
pub mod element;
mod error;
pub mod loads;
mod material;
mod matrix_free;
mod pores;
#[cfg(test)]
mod sample;
mod stress;

pub use assembled::{lift, reduced, stiffness, stiffness_of_rows};
pub use constraints::Constraints;
pub use diagonal::diagonal;
pub(crate) use diagonal::diagonals_at;
pub use error::ElasticityError;
pub use material::Elastic;
pub use matrix_free::{
    Bricks, FreeStiffness, Hexes, Restricted, matrix_free, matrix_free_with_level, strain_norm,
};
pub use pores::pore_forces;
pub use stress::element_stress;
