//! Stiffness products without a matrix.

mod brick;
mod bricks;
mod gauss;
mod groups;
mod hexes;
mod line;
mod modes;
mod pipeline;
mod restricted;
mod sweep;
#[cfg(test)]
mod tests;

pub use bricks::Bricks;
pub use hexes::Hexes;
pub use restricted::{FreeStiffness, Restricted, strain_norm};

use super::{Elastic, ElasticityError};
use crate::mesh::HexMesh;
use fracas_operators::{AdjointOperator, Real};

/// The stiffness of a body in full numbering, without a matrix: [`Bricks`] on an axis-aligned grid, else [`Hexes`].
///
/// # Errors
/// [`ElasticityError`] for an inverted element, a region without a material, or a mesh that contradicts its grid.
pub fn matrix_free<R: Real>(
    mesh: &HexMesh,
    materials: &[Elastic],
) -> Result<Box<dyn AdjointOperator<R>>, ElasticityError> {
    match &mesh.grid {
        Some(grid) if grid.axis_aligned => Ok(Box::new(Bricks::new(mesh, materials)?)),
        _ => Ok(Box::new(Hexes::new(mesh, materials)?)),
    }
}
