//! Which hexahedra a face belongs to.

use super::GmshDefect;
use super::file::Cell;
use crate::mesh::FACES;
use crate::mesh::split::key;
use rayon::prelude::*;

/// A face of a hexahedron: its nodes in increasing order, the element, the local face.
pub(super) type Face = ([u32; 4], u32, u8);

/// The six faces of every hexahedron, sorted by their nodes.
#[derive(Clone, Debug)]
pub(super) struct Faces {
    all: Vec<Face>,
}

/// Nodes of a face, counter-clockwise seen from outside its element.
pub(super) fn corners(cells: &[Cell<8>], (_, element, face): &Face) -> [u32; 4] {
    FACES[usize::from(*face)].map(|a| cells[*element as usize].nodes[a])
}

/// Whether one cycle of four nodes is the other one backwards.
fn are_opposite(a: [u32; 4], b: [u32; 4]) -> bool {
    let start = b.iter().position(|n| *n == a[0]);
    start.is_some_and(|start| (0..4).all(|i| a[i] == b[(start + 4 - i) % 4]))
}

impl Faces {
    /// Of positively oriented hexahedra.
    ///
    /// # Errors
    /// [`GmshDefect::Overlap`] for two on one side of a face.
    pub(super) fn new(cells: &[Cell<8>], nodes: &[[f64; 3]]) -> Result<Self, GmshDefect> {
        let mut all: Vec<Face> = cells
            .par_iter()
            .enumerate()
            .flat_map_iter(|(e, cell)| {
                (0..6u8).map(move |f| (key(&cell.nodes, f.into()), e as u32, f))
            })
            .collect();
        all.par_sort_unstable();
        for users in all.chunk_by(|a, b| a.0 == b.0) {
            let pairs = users.windows(2);
            let meet =
                |pair: &[Face]| are_opposite(corners(cells, &pair[0]), corners(cells, &pair[1]));
            // of three, two lie on one side
            if let Some(pair) = pairs.clone().find(|pair| users.len() > 2 || !meet(pair)) {
                let at = pair[0].0.map(|n| nodes[n as usize]);
                return Err(GmshDefect::Overlap {
                    first: cells[pair[0].1 as usize].id,
                    second: cells[pair[1].1 as usize].id,
                    center: mean(&at),
                });
            }
        }
        Ok(Self { all })
    }

    /// The one or two sides of the face with these nodes; empty if there is none.
    pub(super) fn sides(&self, mut nodes: [u32; 4]) -> &[Face] {
        nodes.sort_unstable();
        let start = self.all.partition_point(|face| face.0 < nodes);
        let rest = &self.all[start..];
        let count = rest.iter().take_while(|face| face.0 == nodes).count();
        &rest[..count]
    }

    /// Faces with one side, in order of their elements.
    pub(super) fn boundary(&self) -> Vec<Face> {
        let single = self.all.chunk_by(|a, b| a.0 == b.0);
        let mut faces: Vec<Face> = single.filter(|s| s.len() == 1).map(|s| s[0]).collect();
        faces.sort_unstable_by_key(|face| (face.1, face.2));
        faces
    }
}

/// Mean of points [m].
pub(super) fn mean<const N: usize>(points: &[[f64; 3]; N]) -> [f64; 3] {
    [0, 1, 2].map(|d: usize| points.iter().map(|p| p[d]).sum::<f64>() / N as f64)
}
