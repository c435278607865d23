//! Inner edges of fractures, and those where fractures go through each other.

use super::{Crossing, FractureEdge, FractureFace};
use rayon::prelude::*;

/// A face at an edge, with its local ends in the order of the ends.
type User = ([u32; 2], u32, [u8; 2]);

/// Edges shared by exactly two faces of one fracture and no others, and edges at which two faces of a fracture meet faces of others
/// (junctions); both ordered by (K, L). `origin` makes the copies of a node one.
pub fn fracture_edges(
    faces: &[FractureFace],
    origin: &[u32],
) -> (Vec<FractureEdge>, Vec<Crossing>) {
    let mut users: Vec<User> = Vec::with_capacity(4 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        let nodes = face.minus.nodes.map(|n| origin[n as usize]);
        for a in 0..4u8 {
            let b = (a + 1) % 4;
            let (p, q) = (nodes[a as usize], nodes[b as usize]);
            let (ends, local) = match p < q {
                true => ([p, q], [a, b]),
                false => ([q, p], [b, a]),
            };
            users.push((ends, f as u32, local));
        }
    }
    users.par_sort_unstable();
    let fracture = |user: &User| faces[user.1 as usize].fracture;
    let (mut edges, mut crossings) = (Vec::new(), Vec::new());
    for list in users.chunk_by(|a, b| a.0 == b.0) {
        // faces are grouped by fracture, and here in order
        for pair in list.chunk_by(|a, b| fracture(a) == fracture(b)) {
            let [(_, k, nodes_k), (_, l, nodes_l)] = *pair else {
                continue;
            };
            let edge = FractureEdge {
                faces: [k, l],
                nodes_k,
                nodes_l,
            };
            match list.len() {
                2 => edges.push(edge),
                _ => {
                    let others = list.iter().map(|user| user.1);
                    let others = others.filter(|f| *f != k && *f != l).collect();
                    crossings.push(Crossing { edge, others });
                }
            }
        }
    }
    edges.sort_unstable_by_key(|e: &FractureEdge| (e.faces, e.nodes_k));
    crossings.sort_unstable_by_key(|c: &Crossing| (c.edge.faces, c.edge.nodes_k));
    (edges, crossings)
}
