//! Filling the rows of a sparse structure in parallel, each chunk of rows its own part.

use rayon::prelude::*;
use std::ops::Range;

/// Rows that one task fills.
pub(super) const ROWS_PER_TASK: usize = 2048;

/// Ranges of rows of fixed length, so that no result depends on the number of threads.
pub(super) fn chunks(rows: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    (0..rows.div_ceil(ROWS_PER_TASK))
        .into_par_iter()
        .map(move |k| k * ROWS_PER_TASK..rows.min((k + 1) * ROWS_PER_TASK))
}

/// A pattern: where rows begin, and their columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Pattern {
    /// Rows + 1.
    pub(super) offsets: Vec<usize>,
    /// Ascending within a row.
    pub(super) columns: Vec<u32>,
}

impl Pattern {
    /// Collects `row(i, scratch, columns)`, which appends the ascending columns of row i; every task has its own scratch.
    pub(super) fn collect<S>(
        rows: usize,
        scratch: impl Fn() -> S + Sync,
        row: impl Fn(usize, &mut S, &mut Vec<u32>) + Sync,
    ) -> Self {
        let parts: Vec<(Vec<usize>, Vec<u32>)> = chunks(rows)
            .map_init(&scratch, |scratch, range| {
                let (mut ends, mut columns) = (Vec::with_capacity(range.len()), Vec::new());
                for i in range {
                    row(i, scratch, &mut columns);
                    ends.push(columns.len());
                }
                (ends, columns)
            })
            .collect();
        let mut pattern = Self {
            offsets: vec![0],
            columns: Vec::with_capacity(parts.iter().map(|part| part.1.len()).sum()),
        };
        for (ends, columns) in parts {
            let start = pattern.columns.len();
            pattern.offsets.extend(ends.iter().map(|end| start + end));
            pattern.columns.extend(columns);
        }
        pattern
    }

    /// Rows.
    pub(super) fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Columns of a row.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> &[u32] {
        &self.columns[self.offsets[i]..self.offsets[i + 1]]
    }

    /// Fills `values`, one per column, by `fill(rows, their values, scratch)`.
    pub(super) fn fill<V: Send, S>(
        &self,
        values: &mut [V],
        scratch: impl Fn() -> S + Sync + Send,
        fill: impl Fn(Range<usize>, &mut [V], &mut S) + Sync + Send,
    ) {
        let mut parts = Vec::new();
        let mut rest = values;
        for start in (0..self.rows()).step_by(ROWS_PER_TASK) {
            let end = self.rows().min(start + ROWS_PER_TASK);
            let (part, tail) = rest.split_at_mut(self.offsets[end] - self.offsets[start]);
            parts.push((start..end, part));
            rest = tail;
        }
        parts
            .into_par_iter()
            .for_each_init(&scratch, |scratch, (rows, part)| fill(rows, part, scratch));
    }

    /// Rows of every column.
    pub(super) fn transposed(&self, columns: usize) -> Self {
        let mut offsets = vec![0; columns + 1];
        self.columns
            .iter()
            .for_each(|j| offsets[*j as usize + 1] += 1);
        (0..columns).for_each(|j| offsets[j + 1] += offsets[j]);
        let mut next = offsets.clone();
        let mut rows = vec![0; self.columns.len()];
        for i in 0..self.rows() {
            for j in self.row(i) {
                rows[next[*j as usize]] = i as u32;
                next[*j as usize] += 1;
            }
        }
        Self {
            offsets,
            columns: rows,
        }
    }
}
