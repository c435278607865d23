//! The near-null space of elasticity: modes that cost no energy away from supports.

use super::node_map::{NONE, NodeMap};
use rayon::prelude::*;

/// Six rigid-body modes per slot (three translations, three rotations `e_k × x` about the centroid, lengths in units of
/// the largest distance from it), zero in empty slots.
///
/// Aggregates make their own orthonormal basis of these values, so each piece of rock gets all six, wherever the centroid
/// of the whole is.
pub(super) fn rigid_body_modes(map: &NodeMap, positions: &[[f64; 3]]) -> Vec<[[f64; 6]; 3]> {
    let count = positions.len().max(1) as f64;
    let centre: [f64; 3] =
        std::array::from_fn(|d| positions.iter().map(|x| x[d]).sum::<f64>() / count);
    let distance = |x: &[f64; 3]| (0..3).fold(0.0, |m: f64, d| m.max((x[d] - centre[d]).abs()));
    let extent = positions.iter().map(distance).fold(0.0, f64::max);
    let scale = if extent > 0.0 { 1.0 / extent } else { 1.0 };
    let of_node = |(node, position): (usize, &[f64; 3])| {
        let [x, y, z]: [f64; 3] = std::array::from_fn(|d| scale * (position[d] - centre[d]));
        let mut modes = [
            [1.0, 0.0, 0.0, 0.0, z, -y],
            [0.0, 1.0, 0.0, -z, 0.0, x],
            [0.0, 0.0, 1.0, y, -x, 0.0],
        ];
        for (row, unknown) in modes.iter_mut().zip(map.of_node(node)) {
            if *unknown == NONE {
                *row = [0.0; 6];
            }
        }
        modes
    };
    positions.par_iter().enumerate().map(of_node).collect()
}

/// The three constants per slot: all that is known without coordinates.
pub(super) fn constants(map: &NodeMap) -> Vec<[[f64; 3]; 3]> {
    let entry = |node: usize, i: usize, k: usize| {
        let held = map.of_node(node)[i] == NONE;
        if i == k && !held { 1.0 } else { 0.0 }
    };
    (0..map.nodes())
        .map(|node| std::array::from_fn(|i| std::array::from_fn(|k| entry(node, i, k))))
        .collect()
}
