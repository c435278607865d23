//! P by nodes.

use fracas_operators::small::Matrix3;
use rayon::prelude::*;

/// Rows that one task computes.
const ROWS_PER_TASK: usize = 256;

/// P in 3×3 blocks: rows are fine nodes, columns coarse nodes.
#[derive(Clone, Debug)]
pub(super) struct Interpolation {
    /// Where the rows begin (fine nodes + 1).
    pub(super) offsets: Vec<usize>,
    /// Coarse nodes, ascending within a row.
    pub(super) columns: Vec<u32>,
    /// P_ij.
    pub(super) blocks: Vec<Matrix3<f64>>,
}

/// Coarse node and block.
pub(super) type Entry = (u32, Matrix3<f64>);

/// The identity.
pub(super) const IDENTITY: Matrix3<f64> = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Interpolation {
    /// Rows in parallel: `row(scratch, i, out)` pushes the blocks of row i onto an empty list.
    pub(super) fn collect<S>(
        n: usize,
        scratch: impl Fn() -> S + Sync + Send,
        row: impl Fn(&mut S, usize, &mut Vec<Entry>) + Sync + Send,
    ) -> Self {
        let parts: Vec<(Vec<usize>, Vec<Entry>)> = (0..n.div_ceil(ROWS_PER_TASK))
            .into_par_iter()
            .map_init(
                || (scratch(), Vec::new()),
                |(scratch, out), task| {
                    let (mut lengths, mut entries) = (Vec::new(), Vec::new());
                    for i in task * ROWS_PER_TASK..n.min((task + 1) * ROWS_PER_TASK) {
                        out.clear();
                        row(scratch, i, out);
                        out.sort_unstable_by_key(|entry| entry.0);
                        lengths.push(out.len());
                        entries.extend_from_slice(out);
                    }
                    (lengths, entries)
                },
            )
            .collect();
        let mut p = Self {
            offsets: vec![0],
            columns: Vec::new(),
            blocks: Vec::new(),
        };
        for (lengths, entries) in parts {
            for len in lengths {
                p.offsets.push(p.offsets[p.offsets.len() - 1] + len);
            }
            p.columns.extend(entries.iter().map(|entry| entry.0));
            p.blocks.extend(entries.iter().map(|entry| entry.1));
        }
        p
    }

    /// Fine nodes.
    pub(super) fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Coarse nodes and blocks of a row.
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &Matrix3<f64>)> {
        let range = self.offsets[i]..self.offsets[i + 1];
        let columns = self.columns[range.clone()].iter().map(|j| *j as usize);
        columns.zip(&self.blocks[range])
    }
}
