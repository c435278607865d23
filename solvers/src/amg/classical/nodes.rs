//! A symmetric matrix by nodes.

/// Rows of 3×3 blocks, row-major, every diagonal block present; columns ascend within a row.
#[derive(Clone, Debug)]
pub(in crate::amg) struct NodeBlocks {
    /// Where the rows begin (nodes + 1).
    pub(in crate::amg) offsets: Vec<usize>,
    /// Nodes, row after row.
    pub(in crate::amg) columns: Vec<u32>,
    /// A_ij.
    pub(in crate::amg) blocks: Vec<[f64; 9]>,
}

impl NodeBlocks {
    /// Nodes.
    pub(super) fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Neighbours of a node and its blocks.
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &[f64; 9])> {
        let range = self.offsets[i]..self.offsets[i + 1];
        let columns = self.columns[range.clone()].iter().map(|j| *j as usize);
        columns.zip(&self.blocks[range])
    }

    /// A_ii.
    pub(super) fn diagonal(&self, i: usize) -> &[f64; 9] {
        let columns = &self.columns[self.offsets[i]..self.offsets[i + 1]];
        let place = columns.partition_point(|j| (*j as usize) < i);
        assert!(
            columns.get(place) == Some(&(i as u32)),
            "no diagonal block in row {i}"
        );
        &self.blocks[self.offsets[i] + place]
    }
}
