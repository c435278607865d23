//! Splitting nodes along fracture faces.

use std::collections::{BTreeMap, HashMap};

use super::FaceSide;

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
fn key(element: &[u32; 8], face: usize) -> [u32; 4] {
    let mut nodes = FACES[face].map(|a| element[a]);
    nodes.sort_unstable();
    nodes
}

/// Root of `i` in a union-find forest, halving paths.
fn root(parent: &mut [usize], mut i: usize) -> usize {
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
    let mut cut_faces: Vec<[u32; 4]> = quads.clone();
    for face in &mut cut_faces {
        face.sort_unstable();
    }
    cut_faces.sort_unstable();

    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for node in quads.iter().flatten() {
        around.entry(*node).or_default();
    }
    let mut marked = vec![false; nodes.len()];
    for node in around.keys() {
        marked[*node as usize] = true;
    }
    for (e, element) in elements.iter().enumerate() {
        for node in element.iter().filter(|n| marked[**n as usize]) {
            if let Some(list) = around.get_mut(node) {
                list.push(e as u32);
            }
        }
    }

    // (node, element) → the copy that the element sees, where it is not the node itself.
    let mut copy_of: HashMap<(u32, u32), u32> = HashMap::new();
    for (node, list) in &around {
        let mut parent: Vec<usize> = (0..list.len()).collect();
        let mut first: HashMap<[u32; 4], usize> = HashMap::with_capacity(12);
        for (i, e) in list.iter().enumerate() {
            for face in 0..6 {
                let face = key(&elements[*e as usize], face);
                if !face.contains(node) || cut_faces.binary_search(&face).is_ok() {
                    continue;
                }
                if let Some(j) = first.insert(face, i) {
                    let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                    parent[a.max(b)] = a.min(b);
                }
            }
        }
        let mut copies: BTreeMap<usize, u32> = BTreeMap::new();
        for (i, e) in list.iter().enumerate() {
            let component = root(&mut parent, i);
            if component == 0 {
                continue;
            }
            let copy = *copies.entry(component).or_insert_with(|| {
                nodes.push(nodes[*node as usize]);
                origin.push(origin[*node as usize]);
                nodes.len() as u32 - 1
            });
            copy_of.insert((*node, *e), copy);
        }
    }

    let sides = cuts
        .iter()
        .zip(&quads)
        .map(|(cut, quad)| {
            let side = |element: u32| FaceSide {
                element,
                nodes: quad.map(|n| *copy_of.get(&(n, element)).unwrap_or(&n)),
            };
            (side(cut.minus.0), side(cut.plus.0))
        })
        .collect();
    for ((node, e), copy) in &copy_of {
        for a in &mut elements[*e as usize] {
            if a == node {
                *a = *copy;
            }
        }
    }
    sides
}
