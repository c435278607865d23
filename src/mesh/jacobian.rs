//! Validity of mapped elements.

use super::face_geometry::{cross, dot};
use super::{HexMesh, MeshError};
use rayon::prelude::*;

/// Reference coordinates of the eight nodes, VTK order.
pub(crate) const CORNERS: [[f64; 3]; 8] = [
    [-1.0, -1.0, -1.0],
    [1.0, -1.0, -1.0],
    [1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
];

/// 1/√3: coordinate of the two-point Gauss rule on [−1, 1]; both weights are 1.
pub(crate) const GAUSS: f64 = 0.577_350_269_189_625_8;

/// Edge lengths of an axis-aligned brick, or `None` for any other hexahedron; exact comparison of coordinates.
pub fn brick_size(nodes: &[[f64; 3]; 8]) -> Option<[f64; 3]> {
    let (low, high) = (nodes[0], nodes[6]);
    let is_brick = CORNERS
        .iter()
        .zip(nodes)
        .all(|(corner, x)| (0..3).all(|i| x[i] == if corner[i] < 0.0 { low[i] } else { high[i] }));
    let size = [high[0] - low[0], high[1] - low[1], high[2] - low[2]];
    (is_brick && size.iter().all(|h| *h > 0.0)).then_some(size)
}

/// det J = det ∂x/∂ξ at a reference point [m³].
fn jacobian(x: &[[f64; 3]; 8], at: [f64; 3]) -> f64 {
    let mut columns = [[0.0; 3]; 3];
    for a in 0..8 {
        let c = CORNERS[a];
        let factor = [0, 1, 2].map(|d: usize| 1.0 + c[d] * at[d]);
        let gradient = [
            0.125 * c[0] * factor[1] * factor[2],
            0.125 * c[1] * factor[0] * factor[2],
            0.125 * c[2] * factor[0] * factor[1],
        ];
        for j in 0..3 {
            for d in 0..3 {
                columns[j][d] += gradient[j] * x[a][d];
            }
        }
    }
    dot(columns[0], cross(columns[1], columns[2]))
}

/// Smallest det J over the eight corners and the eight Gauss points [m³].
pub fn min_jacobian(x: &[[f64; 3]; 8]) -> f64 {
    if let Some([x, y, z]) = brick_size(x) {
        return 0.125 * x * y * z;
    }
    CORNERS
        .iter()
        .flat_map(|c| [*c, c.map(|v| GAUSS * v)])
        .map(|at| jacobian(x, at))
        .fold(f64::INFINITY, |m: f64, v| {
            if m.is_nan() || v.is_nan() {
                f64::NAN
            } else {
                m.min(v)
            }
        })
}

/// Volume of an element, 2×2×2 Gauss: exact for trilinear maps [m³].
pub(super) fn volume(x: &[[f64; 3]; 8]) -> f64 {
    CORNERS
        .iter()
        .map(|c| jacobian(x, c.map(|v| GAUSS * v)))
        .sum()
}

/// Mean of the corners [m].
pub(super) fn center(x: &[[f64; 3]; 8]) -> [f64; 3] {
    [0, 1, 2].map(|d: usize| x.iter().map(|p| p[d]).sum::<f64>() / 8.0)
}

/// Corners of element `e` [m].
pub(super) fn corners(mesh: &HexMesh, e: usize) -> [[f64; 3]; 8] {
    mesh.elements[e].map(|n| mesh.nodes[n as usize])
}

/// Elements that one task looks at.
const PER_TASK: usize = 4096;

/// The smaller of two determinants with their elements; the first one where they are equal or it is not a number.
fn worse(first: (f64, usize), next: (f64, usize)) -> (f64, usize) {
    let stays = first.0.is_nan() || first.0 <= next.0;
    if stays { first } else { next }
}

/// Smallest det J of the mesh [m³].
///
/// # Errors
/// [`MeshError::Inverted`] for the element with the smallest determinant, if that is not positive; `advice` says what to
/// change.
pub fn check_jacobians(mesh: &HexMesh, advice: &'static str) -> Result<f64, MeshError> {
    let of_task = |(task, elements): (usize, &[[u32; 8]])| {
        let mut worst = (f64::INFINITY, 0);
        for (i, element) in elements.iter().enumerate() {
            let value = min_jacobian(&element.map(|n| mesh.nodes[n as usize]));
            worst = worse(worst, (value, task * PER_TASK + i));
        }
        worst
    };
    let tasks: Vec<(f64, usize)> = mesh
        .elements
        .par_chunks(PER_TASK)
        .enumerate()
        .map(of_task)
        .collect();
    let worst = tasks.into_iter().fold((f64::INFINITY, 0), worse);
    match worst.0 > 0.0 {
        true => Ok(worst.0),
        false => Err(MeshError::Inverted {
            element: worst.1,
            center: center(&corners(mesh, worst.1)),
            min_jacobian: worst.0,
            advice,
        }),
    }
}
