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
    /// The edges of the face, and a depth of V/A_f, at least as deep as the face is wide ([`Side::deep`]): H turns with the body. For bricks along the axes
    /// that are not thinner it is `box`.
    #[default]
    Deep,
    /// The bounding box of the element along x, y, z: the published weights, to compare with published counts and codes. They are others where the
    /// body is turned, and in cells that are 1:a thin across the fracture they let a times as much shear through as in cubes.
    Box,
}

/// A symmetric tensor.
pub(super) type Tensor = [[f64; 3]; 3];

/// Lengths and volume of the element beside a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// `G`, diag(1/h_j²) for a box of sides h along x, y, z [1/m²].
    pub metric: [[f64; 3]; 3],
    /// Volume [m³].
    pub volume: f64,
}

impl Side {
    /// Of the bounding box of an element, `G = diag(1/h_j²)`.
    pub fn boxed(mesh: &HexMesh, element: usize) -> Self {
        let corners = corners(mesh, element);
        Self {
            metric: of_lengths(extent(corners)),
            volume: mesh.element_volume(element),
        }
    }

    /// Of an element beside a face of normal n with the mean edges a, b, taken for a prism of depth `d = V/A_f`:
    /// `G = (a aᵀ + b bᵀ + d² n nᵀ)⁻¹`. Bricks are worth their boxes, however they are turned; where edges lean to the face, G does not couple normal and
    /// shear, as `J⁻ᵀJ⁻¹` of all edges would.
    pub fn beside(mesh: &HexMesh, element: usize, face: &FractureFace) -> Self {
        Self::prism(mesh, element, face, |depth, _| depth)
    }

    /// The same, at least as deep as the face is wide: `d = max(V/A_f, A_f/(longest edge))`.
    pub fn deep(mesh: &HexMesh, element: usize, face: &FractureFace) -> Self {
        Self::prism(mesh, element, face, f64::max)
    }

    /// With the depth that `of` makes of V/A_f and the width of the face.
    fn prism(
        mesh: &HexMesh,
        element: usize,
        face: &FractureFace,
        of: impl Fn(f64, f64) -> f64,
    ) -> Self {
        let x = face.minus.nodes.map(|a| mesh.nodes[a as usize]);
        let edges = [0, 1, 2, 3].map(|k: usize| -> [f64; 3] {
            let (p, q) = (x[k], x[(k + 1) % 4]);
            std::array::from_fn(|j| q[j] - p[j])
        });
        let length = |edge: &[f64; 3]| edge.iter().map(|v| v * v).sum::<f64>().sqrt();
        let longest = edges.iter().map(length).fold(0.0, f64::max);
        let depth = of(
            mesh.element_volume(element) / face.area,
            face.area / longest,
        );
        // opposite edges run against each other
        let mean = |k: usize| -> [f64; 3] {
            std::array::from_fn(|j| 0.5 * (edges[k][j] - edges[k + 2][j]))
        };
        let sides = [mean(0), mean(1), face.frame[0].map(|n| depth * n)];
        Self {
            metric: inverse(std::array::from_fn(|i| {
                std::array::from_fn(|j| sides.iter().map(|a| a[i] * a[j]).sum())
            })),
            volume: face.area * depth,
        }
    }
}

fn corners(mesh: &HexMesh, element: usize) -> [[f64; 3]; 8] {
    mesh.elements[element].map(|a| mesh.nodes[a as usize])
}

fn of_lengths(h: [f64; 3]) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 / (h[i] * h[i]) } else { 0.0 }))
}

/// Of a positive definite tensor, by its cofactors.
pub(super) fn inverse(m: Tensor) -> Tensor {
    // cofactor of (i, j), the indices behind i and j in turn
    let cofactor = |i: usize, j: usize| {
        let [(i1, i2), (j1, j2)] = [i, j].map(|k| ((k + 1) % 3, (k + 2) % 3));
        m[i1][j1] * m[i2][j2] - m[i1][j2] * m[i2][j1]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| cofactor(i.min(j), i.max(j)) / determinant))
}

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

/// `k = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) V G` [Pa·m]: the stiffness that a split corner node sees from one element.
pub fn side_stiffness(scale: f64, material: Elastic, side: Side) -> [[f64; 3]; 3] {
    let Elastic { young, poisson } = material;
    let modulus = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let factor = scale * modulus * (2.0 / 9.0) * (2.0 - 3.0 * poisson) * side.volume;
    side.metric.map(|row| row.map(|g| factor * g))
}
