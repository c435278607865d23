//! Fracture faces as a table, so that other codes know what a traction means.

use crate::mesh::FractureMesh;
use fracas_operators::{Dense, Shape};

/// One row per face: fracture, centre x y z [m], area [m²], n x y z, t1 x y z, t2 x y z.
///
/// Row f belongs to the tractions 3f, 3f + 1, 3f + 2 along n, t1, t2. Fractures count from 0.
///
/// # Shape
/// faces × 14.
pub fn face_table(fractures: &FractureMesh) -> Dense<f64> {
    let faces = &fractures.faces;
    Dense::from_fn(Shape::new(faces.len(), 14), |f, j| {
        let face = &faces[f];
        match j {
            0 => f64::from(face.fracture),
            1..=3 => face.center[j - 1],
            4 => face.area,
            _ => face.frame[(j - 5) / 3][(j - 5) % 3],
        }
    })
}
