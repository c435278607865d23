//! Every element has a material and a positive volume, or an error says which has not.

use super::ElasticityError;
use super::element::{GaussPoints, Geometry, Inverted};
use crate::mesh::HexMesh;
use rayon::prelude::*;

/// Elements that one task checks.
const ELEMENTS_PER_TASK: usize = 512;

/// Corners of element e [m].
pub(super) fn corners(mesh: &HexMesh, e: usize) -> [[f64; 3]; 8] {
    mesh.elements[e].map(|node| mesh.nodes[node as usize])
}

/// The error of element e.
fn inverted(mesh: &HexMesh, e: usize, source: Inverted) -> ElasticityError {
    let nodes = corners(mesh, e);
    ElasticityError::Inverted {
        element: e,
        center: [0, 1, 2].map(|i| nodes.iter().map(|x| x[i]).sum::<f64>() / 8.0),
        source,
    }
}

/// Geometry of element e.
pub(super) fn geometry(mesh: &HexMesh, e: usize) -> Result<Geometry, ElasticityError> {
    Geometry::new(&corners(mesh, e)).map_err(|source| inverted(mesh, e, source))
}

/// Gauss points of element e.
pub(super) fn gauss_points(mesh: &HexMesh, e: usize) -> Result<GaussPoints, ElasticityError> {
    GaussPoints::new(&corners(mesh, e)).map_err(|source| inverted(mesh, e, source))
}

/// Every region has one of `materials` values.
pub(super) fn regions(mesh: &HexMesh, materials: usize) -> Result<(), ElasticityError> {
    let missing = mesh
        .regions
        .iter()
        .position(|r| usize::from(*r) >= materials);
    missing.map_or(Ok(()), |element| {
        Err(ElasticityError::NoMaterial {
            element,
            region: usize::from(mesh.regions[element]),
            materials,
        })
    })
}

/// Every region has a material and no element is inverted; the first that fails is named.
pub(super) fn elements(mesh: &HexMesh, materials: usize) -> Result<(), ElasticityError> {
    regions(mesh, materials)?;
    (0..mesh.elements.len())
        .into_par_iter()
        .with_min_len(ELEMENTS_PER_TASK)
        .find_map_first(|e| geometry(mesh, e).err())
        .map_or(Ok(()), Err)
}
