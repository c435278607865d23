//! Geometric multigrid of `S_u = A + B C⁻¹Bᵀ` on grids that fractures cut: `z ← S̃_u⁻¹ r` without an assembled A.
//!
//! Coarse cells are unions of fine ones; a fracture splits them by connectivity, wherever it runs, so every side keeps
//! its own coarse unknowns down to the bottom. All coarse matrices are Galerkin, `PᵀS_u P`: where a coarse cell is whole
//! and of one material that is again the stiffness of a brick and is applied as one; the rest is assembled.
//!
//! | step | file |
//! |---|---|
//! | cells, lines, elements of a level | `grid` |
//! | which lines a coarse grid keeps | `coarse_lines` |
//! | coarse cells, their pieces, copies of their corners | `coarsening` |
//! | P and Pᵀ | `interpolation` |
//! | prescribed components, which coarse cells are bricks | `fixed` |
//! | element matrices | `elements` |
//! | `Σ P_eᵀ K_e P_e`, `Pᵀ R P` | `remainder`, `pattern` |
//! | `B C⁻¹Bᵀ` and `Pᵀ b_f C_f⁻¹ b_fᵀ P` | `faces` |
//! | S_u on a level | `operators` |
//! | degree of the polynomial that smooths | `smoothing` |
//! | all levels | `hierarchy`, `bottom` |

mod bottom;
mod coarse_lines;
mod coarsening;
mod elements;
mod error;
mod faces;
mod fixed;
mod grid;
mod hierarchy;
mod interpolation;
mod inverse;
mod operators;
mod pattern;
mod remainder;
mod smoothing;
#[cfg(test)]
mod tests;

pub use error::{GeometricError, Lost};
pub use fracas_solvers::multigrid::{Geometric, GridLines};
pub use inverse::GeometricInverse;
