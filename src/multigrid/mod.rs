//! Geometric multigrid of `S_u = A + B C⁻¹Bᵀ` on grids that fractures cut: `z ← S̃_u⁻¹ r` without an assembled A.

mod error;
mod inverse;
mod settings;

pub use error::GeometricError;
pub use inverse::GeometricInverse;
pub use settings::Geometric;
