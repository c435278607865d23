//! Splitting nodes along fracture faces.

use super::{FaceSide, Incidence, Places};
use rayon::prelude::*;

/// Local nodes of the six element faces (x−, x+, y−, y+, z−, z+), counter-clockwise seen from outside.
pub const FACES: [[usize; 4]; 6] = [
    [0, 4, 7, 3],
    [1, 2, 6, 5],
    [0, 1, 5, 4],
    [3, 7, 6, 2],
    [0, 3, 2, 1],
    [4, 5, 6, 7],
];

/// A face to cut, as (element, local face) on its two sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cut {
    /// Index of the fracture.
    pub fracture: u16,
    /// The side that the normal leaves.
    pub minus: (u32, u8),
    /// The side that the normal points to.
    pub plus: (u32, u8),
}

/// The four nodes of a face in increasing order: its identity.
pub(super) fn key(element: &[u32; 8], face: usize) -> [u32; 4] {
    let mut nodes = FACES[face].map(|a| element[a]);
    nodes.sort_unstable();
    nodes
}

/// Root of `i` in a union-find forest, halving paths.
pub(super) fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// Splits every node on a cut into one copy per connected component of the elements around it, where two elements are
/// connected if they share a face that is not cut; returns the two sides (minus, plus) of every cut.
///
/// The component with the lowest element keeps the node; copies are appended to `nodes` and `origin` in order of node
/// and lowest element. Tips have one component and stay single; T and X crossings have three and four.
///
/// # Cost
/// O(elements) to find those around cut nodes, then O(24) face look-ups per cut node.
pub fn split(
    nodes: &mut Vec<[f64; 3]>,
    elements: &mut [[u32; 8]],
    origin: &mut Vec<u32>,
    cuts: &[Cut],
) -> Vec<(FaceSide, FaceSide)> {
    // Everything below looks at the mesh as it was.
    let quads: Vec<[u32; 4]> = cuts
        .iter()
        .map(|c| FACES[c.minus.1 as usize].map(|a| elements[c.minus.0 as usize][a]))
        .collect();
    let on_cuts = &Places::new(nodes.len(), quads.iter().flatten().copied());
    let around = on_cuts.elements(elements);
    let cuts_at = Incidence::new(on_cuts.nodes().len(), || {
        quads.iter().enumerate().flat_map(|(c, quad)| {
            quad.iter()
                .filter_map(move |node| Some((on_cuts.of(*node)?, c as u32)))
        })
    });
    let of_node = |(k, node): (usize, &u32)| {
        let cut = cuts_at.row(k).iter().map(|c| quads[*c as usize]);
        components(*node, around.row(k), elements, cut)
    };
    let tasks: Vec<Vec<u16>> = on_cuts
        .nodes()
        .par_chunks(NODES_PER_TASK)
        .enumerate()
        .map(|(task, part)| {
            let numbered = (task * NODES_PER_TASK..).zip(part);
            numbered.flat_map(of_node).collect()
        })
        .collect();

    // What the elements around every node see in its place.
    let mut seen: Vec<u32> = Vec::with_capacity(around.len());
    let mut component = tasks.into_iter().flatten();
    for (k, node) in on_cuts.nodes().iter().enumerate() {
        let first_copy = nodes.len() as u32 - 1;
        for component in component.by_ref().take(around.range(k).len()) {
            let copy = match component {
                0 => *node,
                c => first_copy + u32::from(c),
            };
            if copy as usize == nodes.len() {
                nodes.push(nodes[*node as usize]);
                origin.push(origin[*node as usize]);
            }
            seen.push(copy);
        }
    }

    let copy = |node: u32, element: u32| {
        let Some(k) = on_cuts.of(node) else {
            return node;
        };
        let place = around.row(k).iter().position(|e| *e == element);
        place.map_or(node, |place| seen[around.range(k).start + place])
    };
    let sides = cuts
        .iter()
        .zip(&quads)
        .map(|(cut, quad)| {
            let side = |element: u32| FaceSide {
                element,
                nodes: quad.map(|node| copy(node, element)),
            };
            (side(cut.minus.0), side(cut.plus.0))
        })
        .collect();
    for (k, node) in on_cuts.nodes().iter().enumerate() {
        for (e, copy) in around.row(k).iter().zip(&seen[around.range(k)]) {
            for a in &mut elements[*e as usize] {
                if a == node {
                    *a = *copy;
                }
            }
        }
    }
    sides
}

/// Nodes of one task.
const NODES_PER_TASK: usize = 4096;

/// Component of every element around `node`, numbered in the order of their lowest elements; elements are connected if
/// they share a face at the node that is not among `cut`.
fn components(
    node: u32,
    around: &[u32],
    elements: &[[u32; 8]],
    cut: impl Iterator<Item = [u32; 4]>,
) -> Vec<u16> {
    let mut cut: Vec<[u32; 4]> = cut.collect();
    cut.iter_mut().for_each(|face| face.sort_unstable());
    let mut faces: Vec<([u32; 4], u16)> = Vec::with_capacity(3 * around.len());
    for (i, e) in around.iter().enumerate() {
        let keys = (0..6).map(|face| key(&elements[*e as usize], face));
        let here = keys.filter(|face| face.contains(&node) && !cut.contains(face));
        faces.extend(here.map(|face| (face, i as u16)));
    }
    faces.sort_unstable();
    let mut parent: Vec<usize> = (0..around.len()).collect();
    for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let [a, b] = [pair[0].1, pair[1].1].map(|i| root(&mut parent, i.into()));
        parent[a.max(b)] = a.min(b);
    }
    let mut roots = Vec::new();
    (0..around.len())
        .map(|i| {
            let r = root(&mut parent, i);
            let known = roots.iter().position(|known| *known == r);
            known.unwrap_or_else(|| {
                roots.push(r);
                roots.len() - 1
            }) as u16
        })
        .collect()
}
