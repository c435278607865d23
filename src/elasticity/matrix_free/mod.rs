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

pub use bricks::Bricks;
pub use hexes::Hexes;
pub use restricted::{FreeStiffness, Restricted, strain_norm};

use super::{Elastic, ElasticityError};
use crate::mesh::HexMesh;
use fracas_operators::simd::Level;
use fracas_operators::{AdjointOperator, Make, Real};

/// The stiffness of a body in full numbering, without a matrix: [`Bricks`] on an axis-aligned grid, else [`Hexes`].
///
/// # Errors
/// [`ElasticityError`] for an inverted element, a region without a material, or a mesh that contradicts its grid.
pub fn matrix_free<R: Real>(
    mesh: &HexMesh,
    materials: &[Elastic],
) -> Result<Box<dyn AdjointOperator<R>>, ElasticityError> {
    matrix_free_with_level(mesh, materials, Level::best())
}

/// The same with a chosen instruction set.
///
/// # Errors
/// As [`matrix_free`].
pub fn matrix_free_with_level<R: Real>(
    mesh: &HexMesh,
    materials: &[Elastic],
    level: Level,
) -> Result<Box<dyn AdjointOperator<R>>, ElasticityError> {
    R::make(Stiffness {
        mesh,
        materials,
        level,
    })
}

struct Stiffness<'a> {
    mesh: &'a HexMesh,
    materials: &'a [Elastic],
    level: Level,
}

impl Make for Stiffness<'_> {
    type Made<R: Real> = Result<Box<dyn AdjointOperator<R>>, ElasticityError>;

    fn double(self) -> Self::Made<f64> {
        self.other()
    }

    fn single(self) -> Self::Made<f32> {
        self.other()
    }

    fn other<R: Real>(self) -> Self::Made<R> {
        let Self {
            mesh,
            materials,
            level,
        } = self;
        match &mesh.grid {
            Some(grid) if grid.axis_aligned => {
                Ok(Box::new(Bricks::with_level(mesh, materials, level)?))
            }
            _ => Ok(Box::new(Hexes::with_level(mesh, materials, level)?)),
        }
    }
}
