//! Inner edges of fractures.

use super::{FractureEdge, FractureFace};
use rayon::prelude::*;

/// Edges shared by exactly two faces of one fracture, ordered by (K, L); an edge with more faces (a junction) or with
/// faces of different fractures is left out. `origin` makes the copies of a node one.
pub fn fracture_edges(faces: &[FractureFace], origin: &[u32]) -> Vec<FractureEdge> {
    // (ends, face, local ends)
    let mut users: Vec<([u32; 2], u32, [u8; 2])> = Vec::with_capacity(4 * faces.len());
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
    let mut edges: Vec<FractureEdge> = users
        .chunk_by(|a, b| a.0 == b.0)
        .filter_map(|list| match list {
            [(_, k, nodes_k), (_, l, nodes_l)]
                if faces[*k as usize].fracture == faces[*l as usize].fracture =>
            {
                Some(FractureEdge {
                    faces: [*k, *l],
                    nodes_k: *nodes_k,
                    nodes_l: *nodes_l,
                })
            }
            _ => None,
        })
        .collect();
    edges.sort_unstable_by_key(|e| (e.faces, e.nodes_k));
    edges
}
