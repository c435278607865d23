//! Which lengths the weights of H are made of.

use crate::elasticity::Elastic;
use crate::mesh::{FractureFace, HexMesh};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lengths of the elements beside an edge, of which the weights of H are made. Written as `"deep"` or `"box"`.
///
/// A jump that alternates from face to face dies out over the width h_f of the faces, through however many thin elements: its
/// compliance is ~h_f/μ per area, and that of one thin element says nothing of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lengths {
    /// The bounding box of the element, stretched along the normal of the fracture where it is thinner than the face is wide
    /// ([`Side::deep`]); elsewhere it is `box`.
    #[default]
    Deep,
    /// The bounding box of the element as it is: the published weights, to compare with published counts and codes. In cells that are
    /// 1:a thin across the fracture they let a times as much shear through as in cubes.
    Box,
}

/// Bounding box and volume of the element beside a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// Extent of the element along x, y, z [m].
    pub extent: [f64; 3],
    /// Volume [m³].
    pub volume: f64,
}

impl Side {
    /// Of an element as it is.
    pub fn new(mesh: &HexMesh, element: usize) -> Self {
        let corners = mesh.elements[element].map(|a| mesh.nodes[a as usize]);
        Self {
            extent: extent(corners),
            volume: mesh.element_volume(element),
        }
    }

    /// Of an element beside a face, stretched along its normal n to at least the width `h_f = A_f/(longest edge)` of the face:
    /// `x ← x + (f − 1) (n·x) n`, `f = max(1, h_f A_f/V)`.
    pub fn deep(mesh: &HexMesh, element: usize, face: &FractureFace) -> Self {
        let own = Self::new(mesh, element);
        let corners = face.minus.nodes.map(|a| mesh.nodes[a as usize]);
        let length = |k: usize| {
            let [p, q] = [corners[k], corners[(k + 1) % 4]];
            (0..3).map(|j| (q[j] - p[j]).powi(2)).sum::<f64>().sqrt()
        };
        let longest = (0..4).map(length).fold(0.0, f64::max);
        let factor = face.area * face.area / (longest * own.volume);
        if factor <= 1.0 + ROUNDING {
            return own;
        }
        let n = face.frame[0];
        let stretched = mesh.elements[element].map(|a| {
            let x = mesh.nodes[a as usize];
            let along: f64 = (0..3).map(|j| n[j] * x[j]).sum();
            std::array::from_fn(|j| x[j] + (factor - 1.0) * along * n[j])
        });
        Self {
            extent: extent(stretched),
            volume: factor * own.volume,
        }
    }
}

/// Share by which cubes may seem thinner than wide. Unit: 1.
const ROUNDING: f64 = 1e-9;

fn extent(corners: [[f64; 3]; 8]) -> [f64; 3] {
    std::array::from_fn(|j| {
        let of = corners.iter().map(|x| x[j]);
        let [low, high] = [
            of.clone().fold(f64::INFINITY, f64::min),
            of.fold(f64::NEG_INFINITY, f64::max),
        ];
        high - low
    })
}

/// `k_j = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) V/h_j²` [Pa·m]: the stiffness that a split corner node sees from one element.
pub fn side_stiffness(scale: f64, material: Elastic, side: Side) -> [f64; 3] {
    let Elastic { young, poisson } = material;
    let modulus = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    side.extent
        .map(|h| scale * modulus * (2.0 / 9.0) * (2.0 - 3.0 * poisson) * side.volume / (h * h))
}
