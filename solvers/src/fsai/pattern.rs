//! Static patterns: strict lower triangles of powers of the filtered matrix.

use super::Static;
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

/// Rows whose patterns one task finds.
const ROWS_PER_TASK: usize = 1024;

/// Ascending columns `j < i` of every row i.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pattern {
    offsets: Vec<usize>,
    columns: Vec<u32>,
}

impl Pattern {
    /// The strict lower triangle of `Ã^power`, each row the nodes at graph distance ≤ power.
    pub(super) fn new(a: &SparseMatrix<f64>, diagonal: &[f64], settings: Static) -> Self {
        let n = a.rows();
        let tasks: Vec<(Vec<usize>, Vec<u32>)> = (0..n.div_ceil(ROWS_PER_TASK))
            .into_par_iter()
            .map_init(
                || vec![usize::MAX; n],
                |seen, task| {
                    let (mut lengths, mut columns, mut row) = (Vec::new(), Vec::new(), Vec::new());
                    for i in task * ROWS_PER_TASK..n.min((task + 1) * ROWS_PER_TASK) {
                        reach(a, diagonal, settings, i, seen, &mut row);
                        lengths.push(row.len());
                        columns.extend_from_slice(&row);
                    }
                    (lengths, columns)
                },
            )
            .collect();
        let (mut offsets, mut columns) = (vec![0], Vec::new());
        for (lengths, part) in tasks {
            for len in lengths {
                offsets.push(offsets[offsets.len() - 1] + len);
            }
            columns.extend(part);
        }
        Self { offsets, columns }
    }

    /// Columns of row i.
    pub(super) fn row(&self, i: usize) -> &[u32] {
        &self.columns[self.offsets[i]..self.offsets[i + 1]]
    }
}

/// Columns j < i within `power` strong connections of i.
fn reach(
    a: &SparseMatrix<f64>,
    diagonal: &[f64],
    settings: Static,
    i: usize,
    seen: &mut [usize],
    row: &mut Vec<u32>,
) {
    let offsets = a.indptr();
    let offsets = offsets.raw_storage();
    let limit = settings.filter * settings.filter;
    row.clear();
    row.push(i as u32);
    seen[i] = i;
    let mut front = 0;
    for _ in 0..settings.power {
        let end = row.len();
        for k in front..end {
            let l = row[k] as usize;
            let range = offsets[l]..offsets[l + 1];
            for (j, value) in a.indices()[range.clone()].iter().zip(&a.data()[range]) {
                let at = *j as usize;
                let strong = value * value >= limit * diagonal[l] * diagonal[at];
                if seen[at] != i && strong {
                    seen[at] = i;
                    row.push(*j);
                }
            }
        }
        front = end;
    }
    row.retain(|j| (*j as usize) < i);
    row.sort_unstable();
}
