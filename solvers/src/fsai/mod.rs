//! Factorized sparse approximate inverses `GᵀG ≈ A⁻¹`.

mod adaptive;
mod damping;
mod growing;
mod inverse;
mod pattern;
mod settings;
mod static_rows;
#[cfg(test)]
mod tests;

pub use inverse::FsaiInverse;
pub use settings::{Adaptive, Fsai, FsaiKind, Static};
