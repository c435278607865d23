//! A symmetric matrix by nodes.

use crate::amg::sweeps::SweepMatrix;
use fracas_operators::Real;
use fracas_operators::small::{Matrix3, cast};

/// Rows of 3×3 blocks, every diagonal block present; columns ascend within a row.
#[derive(Clone, Debug)]
pub(super) struct NodeBlocks {
    /// Where the rows begin (nodes + 1).
    pub(super) offsets: Vec<usize>,
    /// Nodes, row after row.
    pub(super) columns: Vec<u32>,
    /// A_ij.
    pub(super) blocks: Vec<Matrix3<f64>>,
}

impl NodeBlocks {
    /// The matrix of a level, in f64.
    pub(super) fn of_level<R: Real>(a: &SweepMatrix<R>) -> Self {
        let mut nodes = Self {
            offsets: vec![0],
            columns: Vec::with_capacity(a.block_count()),
            blocks: Vec::with_capacity(a.block_count()),
        };
        let mut row: Vec<(usize, &Matrix3<R>)> = Vec::new();
        for i in 0..a.rows() {
            row.clear();
            row.extend(a.row(i));
            row.sort_unstable_by_key(|entry| entry.0);
            nodes.columns.extend(row.iter().map(|entry| entry.0 as u32));
            let blocks = row.iter().map(|entry| cast(entry.1));
            nodes.blocks.extend(blocks);
            nodes.offsets.push(nodes.columns.len());
        }
        nodes
    }

    /// Nodes.
    pub(super) fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Neighbours of a node and its blocks.
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &Matrix3<f64>)> {
        let range = self.offsets[i]..self.offsets[i + 1];
        let columns = self.columns[range.clone()].iter().map(|j| *j as usize);
        columns.zip(&self.blocks[range])
    }

    /// A_ii.
    pub(super) fn diagonal(&self, i: usize) -> &Matrix3<f64> {
        let columns = &self.columns[self.offsets[i]..self.offsets[i + 1]];
        let place = columns.partition_point(|j| (*j as usize) < i);
        assert!(
            columns.get(place) == Some(&(i as u32)),
            "no diagonal block in row {i}"
        );
        &self.blocks[self.offsets[i] + place]
    }
}
