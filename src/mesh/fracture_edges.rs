//! Inner edges of fractures.

use std::collections::HashMap;

use super::{FractureEdge, FractureFace};

/// Edges shared by exactly two faces of one fracture, ordered by (K, L); an edge with more faces (a junction) or with
/// faces of different fractures is left out. `origin` makes the copies of a node one.
pub fn fracture_edges(faces: &[FractureFace], origin: &[u32]) -> Vec<FractureEdge> {
    let mut users: HashMap<[u32; 2], Vec<(u32, [u8; 2])>> = HashMap::with_capacity(2 * faces.len());
    for (f, face) in faces.iter().enumerate() {
        let nodes = face.minus.nodes.map(|n| origin[n as usize]);
        for a in 0..4u8 {
            let b = (a + 1) % 4;
            let (p, q) = (nodes[a as usize], nodes[b as usize]);
            let (ends, local) = match p < q {
                true => ([p, q], [a, b]),
                false => ([q, p], [b, a]),
            };
            users.entry(ends).or_default().push((f as u32, local));
        }
    }
    let mut edges: Vec<FractureEdge> = users
        .values()
        .filter_map(|list| match list.as_slice() {
            [k, l] if faces[k.0 as usize].fracture == faces[l.0 as usize].fracture => {
                Some(FractureEdge {
                    faces: [k.0, l.0],
                    nodes_k: k.1,
                    nodes_l: l.1,
                })
            }
            _ => None,
        })
        .collect();
    edges.sort_unstable_by_key(|e| (e.faces, e.nodes_k));
    edges
}
