//! Nodes of displacements, and the graph that is divided.

use crate::amg::node_map::NodeMap;
use crate::direct::partition;
use crate::{DofCoordinate, SetupError};
use fracas_operators::sparse::SparseMatrix;

/// Which node and which of its three components every displacement is.
#[derive(Clone, Debug)]
pub struct Nodes {
    /// `3·node + component` of every displacement.
    pub slots: Vec<u32>,
    /// Where the nodes are [m]; empty where that is not known.
    pub positions: Vec<[f64; 3]>,
    /// How many there are.
    pub count: usize,
}

impl Nodes {
    /// Nodes of the displacements of A, by their coordinates; without them unknowns are taken as triples.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] where neither is possible.
    pub fn of_matrix(
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<Self, SetupError> {
        if coordinates.is_none() && !a.rows().is_multiple_of(3) {
            return Err(SetupError::NotApplicable {
                method: "a partition",
                reason: format!(
                    "{} displacements without coordinates are no nodes of three; give coords.mtx",
                    a.rows()
                ),
            });
        }
        let map = NodeMap::new(a, coordinates);
        Ok(Self {
            slots: map.slots().to_vec(),
            positions: map.positions().map_or_else(Vec::new, <[_]>::to_vec),
            count: map.nodes(),
        })
    }

    /// Part of every node for so many parts, by the graph that A makes of them.
    ///
    /// # Errors
    /// Those of [`partition`].
    pub fn divided(&self, a: &SparseMatrix<f64>, parts: usize) -> Result<Vec<u32>, SetupError> {
        let mut of_node = vec![Vec::new(); self.count];
        for (row, slot) in a.outer_iterator().zip(&self.slots) {
            let list: &mut Vec<u32> = &mut of_node[*slot as usize / 3];
            list.extend(row.indices().iter().map(|j| self.slots[*j as usize] / 3));
            list.sort_unstable();
            list.dedup();
        }
        let (mut offsets, mut neighbours) = (vec![0], Vec::new());
        for (node, list) in of_node.into_iter().enumerate() {
            neighbours.extend(list.into_iter().filter(|other| *other as usize != node));
            offsets.push(neighbours.len());
        }
        partition(&offsets, &neighbours, parts)
    }
}
