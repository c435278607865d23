//! Which lengths the weights of H are made of.

use super::Side;
use crate::elasticity::Elastic;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lengths of the elements beside an edge, of which the weights of H are made. Written as `"box"` or `"patch"`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Lengths {
    /// The bounding box: `k_j = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) V/h_j²`, the published weights. In cells that are 1:a thin across the
    /// fracture they let a times as much shear through as in cubes.
    #[default]
    Box,
    /// The depth to which a jump between the two faces reaches: [`patch_stiffness`].
    Patch,
}

/// `k_j = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) V/h_j²` [Pa·m]: the stiffness that a split corner node sees from one element.
pub fn side_stiffness(scale: f64, material: Elastic, side: Side) -> [f64; 3] {
    let Elastic { young, poisson } = material;
    let modulus = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    side.extent
        .map(|h| scale * modulus * (2.0 / 9.0) * (2.0 - 3.0 * poisson) * side.volume / (h * h))
}

/// A face beside one of its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// A_f [m²].
    pub area: f64,
    /// |e| [m].
    pub edge: f64,
    /// V/A_f: thickness of the element [m].
    pub depth: f64,
}

/// The stiffness [Pa·m] that a corner node on an edge sees from one element, along (n, d, m): the normal, across the edge, along it.
/// ```text
/// k_j = s (2/9) A_f h_n Σ_l M_jl/h_l²        M_jj = λ + 2μ, M_jl = μ
/// h_d = A_f/|e|        h_m = max(|e|, h_d)        h_n = max(V/A_f, h_d)
/// ```
/// With the lengths of the element itself this is `2 A_jj` of a brick, so that H would be the patch of `B diag(A)⁻¹Bᵀ` on any
/// brick. A jump that alternates from face to face dies out over the depth h_d, through however many thin elements:
/// its compliance is ~h_d/μ per area, and that of one thin element says nothing of it. So no length counts as less than
/// h_d. In cubes it is [`side_stiffness`].
pub fn patch_stiffness(scale: f64, material: Elastic, patch: Patch) -> [f64; 3] {
    let Elastic { young, poisson } = material;
    let modulus = young / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let [along, across] = [1.0 - poisson, 0.5 - poisson].map(|v| modulus * v);
    let d = patch.area / patch.edge;
    let lengths = [patch.depth.max(d), d, patch.edge.max(d)];
    let squares = lengths.map(|h| 1.0 / (h * h));
    let all: f64 = squares.iter().sum();
    let factor = scale * (2.0 / 9.0) * patch.area * lengths[0];
    squares.map(|own| factor * (across * all + (along - across) * own))
}
