//! Nodes that lie at one place.

use std::collections::HashMap;

use super::GmshDefect;
use super::file::Cell;
use crate::mesh::EDGES;
use crate::mesh::face_geometry::{dot, minus};

/// Two nodes lie at one place if their distance is at most this share of the shortest edge at either of them.
const SAME: f64 = 1e-6;

/// No two nodes of the hexahedra lie at one place.
///
/// # Cost
/// O(nodes), by hashing the cells of a grid as wide as two nodes may be apart.
///
/// # Errors
/// [`GmshDefect::SameNodes`] for the first node that lies on an earlier one.
pub(super) fn require_distinct(
    cells: &[Cell<8>],
    nodes: &[[f64; 3]],
    tags: &[u64],
) -> Result<(), GmshDefect> {
    // infinite where no hexahedron is
    let mut reach = vec![f64::INFINITY; nodes.len()];
    for cell in cells {
        for ends in EDGES {
            let [a, b] = ends.map(|a| cell.nodes[a] as usize);
            let edge = minus(nodes[a], nodes[b]);
            let length = SAME * dot(edge, edge).sqrt();
            reach[a] = reach[a].min(length);
            reach[b] = reach[b].min(length);
        }
    }
    let used = reach.iter().copied().filter(|r| r.is_finite());
    let widest = used.fold(f64::MIN_POSITIVE, f64::max);
    let cell = |at: [f64; 3]| at.map(|x| (x / (2.0 * widest)).floor() as i64);
    // the last node of a cell, and for every node the one before it in its cell
    let mut last: HashMap<[i64; 3], u32> = HashMap::new();
    let mut before: Vec<Option<u32>> = vec![None; nodes.len()];
    for (a, at) in nodes.iter().enumerate() {
        if reach[a].is_infinite() {
            continue;
        }
        let [low, high] = [-1.0, 1.0].map(|sign| cell(at.map(|x| x + sign * widest)));
        for i in low[0]..=high[0] {
            for j in low[1]..=high[1] {
                for k in low[2]..=high[2] {
                    let mut next = last.get(&[i, j, k]).copied();
                    while let Some(b) = next {
                        let b = b as usize;
                        next = before[b];
                        let apart = minus(*at, nodes[b]);
                        if dot(apart, apart).sqrt() <= reach[a].min(reach[b]) {
                            return Err(GmshDefect::SameNodes {
                                first: tags[b],
                                second: tags[a],
                                at: *at,
                            });
                        }
                    }
                }
            }
        }
        before[a] = last.insert(cell(*at), a as u32);
    }
    Ok(())
}
