//! What a plane cuts out of a body.

use super::lines::{Ends, Key};
use super::patches::Patches;
use super::plane::{Direction, Plane, in_plane};
use fracas::mesh::{EDGES, HexMesh};
use fracas::scene::Body;
use std::collections::HashMap;

/// A point of the plane on an edge of the mesh: `(1 − s) a + s b`.
type OnEdge = (u32, u32, f64);

/// A plane section of a body.
pub struct Section {
    /// What cuts it.
    pub plane: Plane,
    /// The axes of its figure.
    pub directions: [Direction; 2],
    /// Pieces of elements, `of` being the element.
    pub patches: Patches,
    /// Edges of the body and of its materials.
    pub edges: Vec<Vec<[f64; 2]>>,
    /// Where fractures cross the plane.
    pub traces: Vec<Vec<[f64; 2]>>,
}

impl Section {
    /// At most about `most` pieces.
    ///
    /// # Cost
    /// O(elements), and O(elements cut) for the lines.
    pub fn new(body: &Body, plane: Plane, most: usize) -> Self {
        let mesh = &body.mesh;
        let directions = in_plane(plane.normal, mesh.nodes.iter().copied());
        let flat = |x: [f64; 3]| [0, 1].map(|d: usize| directions[d].at(x));
        let sides: Vec<f64> = mesh.nodes.iter().map(|x| plane.at(*x)).collect();
        let mut patches = Patches::default();
        let mut polygons: Vec<(usize, Vec<[f64; 2]>)> = Vec::new();
        for (e, nodes) in mesh.elements.iter().enumerate() {
            let crossings = crossings(nodes, &sides);
            let corners = crossings.iter().map(|at| flat(place(mesh, *at)));
            let mut corners: Vec<[f64; 2]> = corners.collect();
            if corners.len() > 2 {
                around(&mut corners);
                patches.add(&corners, e);
                polygons.push((e, corners));
            }
        }
        let [[left, right], [low, high]] = patches.extent();
        let ends = Ends::new((right - left).max(high - low));
        let mut segments = Vec::new();
        for face in &body.fractures.faces {
            let nodes = face.minus.nodes;
            let crossed = (0..4).filter_map(|k| crossing(nodes[k], nodes[(k + 1) % 4], &sides));
            let crossed: Vec<[f64; 2]> = crossed.map(|at| flat(place(mesh, at))).collect();
            if let [a, b] = crossed[..] {
                segments.push([a, b]);
            }
        }
        Self {
            edges: ends.joined(&outlines(mesh, &polygons, &ends)),
            traces: ends.joined(&segments),
            patches: patches.thinned(most),
            plane,
            directions,
        }
    }

    /// Mean over the corners of the piece of an element of what is linear along edges, three per node.
    pub fn mean(&self, mesh: &HexMesh, e: usize, of_nodes: &[f64]) -> [f64; 3] {
        let nodes = &mesh.elements[e];
        let sides = nodes.map(|a| self.plane.at(mesh.nodes[a as usize]));
        let mut sum = [0.0; 3];
        let mut count = 0.0;
        for [i, j] in EDGES {
            let Some((a, b, s)) = between((nodes[i], sides[i]), (nodes[j], sides[j])) else {
                continue;
            };
            for (k, sum) in sum.iter_mut().enumerate() {
                let at = |a: u32| of_nodes[3 * a as usize + k];
                *sum += (1.0 - s) * at(a) + s * at(b);
            }
            count += 1.0;
        }
        sum.map(|x| x / count)
    }
}

fn place(mesh: &HexMesh, (a, b, s): OnEdge) -> [f64; 3] {
    let [a, b] = [a, b].map(|a| mesh.nodes[a as usize]);
    [0, 1, 2].map(|k| (1.0 - s) * a[k] + s * b[k])
}

/// Where the plane is between two nodes at these distances; a node on the plane lies on its far side.
fn between((a, at_a): (u32, f64), (b, at_b): (u32, f64)) -> Option<OnEdge> {
    ((at_a < 0.0) != (at_b < 0.0)).then(|| (a, b, at_a / (at_a - at_b)))
}

fn crossing(a: u32, b: u32, sides: &[f64]) -> Option<OnEdge> {
    between((a, sides[a as usize]), (b, sides[b as usize]))
}

fn crossings(nodes: &[u32; 8], sides: &[f64]) -> Vec<OnEdge> {
    let below = nodes.iter().filter(|a| sides[**a as usize] < 0.0).count();
    match below {
        0 | 8 => Vec::new(),
        _ => (EDGES.iter())
            .filter_map(|[i, j]| crossing(nodes[*i], nodes[*j], sides))
            .collect(),
    }
}

/// In order around their middle, points that coincide left out.
fn around(corners: &mut Vec<[f64; 2]>) {
    let count = corners.len() as f64;
    let middle = [0, 1].map(|d: usize| corners.iter().map(|p| p[d]).sum::<f64>() / count);
    corners.sort_by(|p, q| {
        let angle = |p: &[f64; 2]| (p[1] - middle[1]).atan2(p[0] - middle[0]);
        angle(p).total_cmp(&angle(q))
    });
    corners.dedup();
}

/// Edges of pieces beside nothing, or beside another material.
fn outlines(
    mesh: &HexMesh,
    polygons: &[(usize, Vec<[f64; 2]>)],
    ends: &Ends,
) -> Vec<[[f64; 2]; 2]> {
    /// Ends, the first material, and whether another piece has the edge.
    type Edge = ([[f64; 2]; 2], u16, Option<u16>);
    let mut edges: HashMap<[Key; 2], Edge> = HashMap::new();
    for (e, corners) in polygons {
        let region = mesh.regions[*e];
        for (k, a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let mut keys = [ends.key(*a), ends.key(b)];
            keys.sort_unstable();
            if keys[0] != keys[1] {
                (edges.entry(keys))
                    .and_modify(|edge| edge.2 = Some(region))
                    .or_insert(([*a, b], region, None));
            }
        }
    }
    let mut shown: Vec<_> = (edges.into_iter())
        .filter(|(_, (_, region, other))| *other != Some(*region))
        .collect();
    // in an order that does not depend on the map
    shown.sort_unstable_by_key(|(keys, _)| *keys);
    shown.into_iter().map(|(_, (ends, ..))| ends).collect()
}
