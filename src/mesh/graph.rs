//! The nodes of a mesh as a graph.

use super::{EDGES, FractureMesh, HexMesh};

/// Neighbours of node after node, among the `count` nodes that have a `number` below it: along edges of elements, and across fractures, so that both
/// sides of a face stay together where they can. Offsets of the lists, and the lists one after the other.
///
/// [`partition`](fracas_solvers::direct::partition) divides such a graph.
///
/// # Panics
/// Where a number is not below `count`.
pub fn node_graph(
    mesh: &HexMesh,
    fractures: &FractureMesh,
    count: usize,
    number: impl Fn(u32) -> Option<u32>,
) -> (Vec<usize>, Vec<u32>) {
    let along = mesh.elements.iter().flat_map(|e| {
        let edge = |[a, b]: [usize; 2]| (e[a], e[b]);
        EDGES.map(edge)
    });
    let across = fractures.faces.iter().flat_map(|f| {
        let pair = |a: usize| (f.minus.nodes[a], f.plus.nodes[a]);
        [0, 1, 2, 3].map(pair)
    });
    let numbered = |(a, b): (u32, u32)| Some((number(a)?, number(b)?));
    let pairs = || {
        let pairs = along.clone().chain(across.clone()).filter_map(numbered);
        pairs.filter(|(a, b)| a != b)
    };
    let mut first = vec![0usize; count + 1];
    for (a, b) in pairs() {
        first[a as usize + 1] += 1;
        first[b as usize + 1] += 1;
    }
    for node in 0..count {
        first[node + 1] += first[node];
    }
    let (mut next, mut met) = (first.clone(), vec![0u32; first[count]]);
    for (a, b) in pairs() {
        for (a, b) in [(a, b), (b, a)] {
            met[next[a as usize]] = b;
            next[a as usize] += 1;
        }
    }
    // an edge is met once by every element around it
    let (mut offsets, mut neighbours) = (vec![0], Vec::new());
    for node in first.windows(2) {
        let list = &mut met[node[0]..node[1]];
        list.sort_unstable();
        let begin = neighbours.len();
        for other in list.iter() {
            if neighbours[begin..].last() != Some(other) {
                neighbours.push(*other);
            }
        }
        offsets.push(neighbours.len());
    }
    (offsets, neighbours)
}
