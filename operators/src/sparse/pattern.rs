//! Where a sparse matrix has entries, collected and filled in parallel, each chunk of rows its own part.

use rayon::prelude::*;
use std::ops::Range;

/// Rows that one task fills.
const ROWS_PER_TASK: usize = 2048;

/// Ranges of rows of fixed length, so that no result depends on the number of threads.
fn chunks(rows: usize) -> impl IndexedParallelIterator<Item = Range<usize>> {
    (0..rows.div_ceil(ROWS_PER_TASK))
        .into_par_iter()
        .map(move |k| k * ROWS_PER_TASK..rows.min((k + 1) * ROWS_PER_TASK))
}

/// A pattern: where rows begin, and their columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Pattern {
    /// Rows + 1.
    pub offsets: Vec<usize>,
    /// Ascending within a row.
    pub columns: Vec<u32>,
}

impl Pattern {
    /// Collects `row(i, scratch, columns)`, which appends the ascending columns of row i; every task has its own scratch.
    pub fn collect<S>(
        rows: usize,
        scratch: impl Fn() -> S + Sync + Send,
        row: impl Fn(usize, &mut S, &mut Vec<u32>) + Sync + Send,
    ) -> Self {
        let (offsets, parts) = parts(rows, scratch, row);
        let mut columns = Vec::with_capacity(parts.iter().map(Vec::len).sum());
        // a part is given back before the next one is copied
        parts.into_iter().for_each(|part| columns.extend(part));
        Self { offsets, columns }
    }

    /// Rows.
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.offsets) + size_of_val(&*self.columns)
    }

    /// Where a row stands.
    #[inline(always)]
    pub fn range(&self, i: usize) -> Range<usize> {
        self.offsets[i]..self.offsets[i + 1]
    }

    /// Columns of a row.
    #[inline(always)]
    pub fn row(&self, i: usize) -> &[u32] {
        &self.columns[self.range(i)]
    }

    /// Where entry (i, j) stands, which is there.
    pub fn place(&self, i: usize, j: u32) -> usize {
        let range = self.range(i);
        let at = range.start + self.columns[range].partition_point(|column| *column < j);
        debug_assert_eq!(self.columns[at], j);
        at
    }

    /// Fills `values`, one per column, by `fill(rows, their values, scratch)`.
    pub fn fill<V: Send, S>(
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

    /// The rows of every column, and where their entries lie.
    pub fn transposed(&self, columns: usize) -> Transposed {
        let mut offsets = vec![0; columns + 1];
        self.columns
            .iter()
            .for_each(|j| offsets[*j as usize + 1] += 1);
        (0..columns).for_each(|j| offsets[j + 1] += offsets[j]);
        let mut next = offsets.clone();
        let mut entries = vec![(0, 0); self.columns.len()];
        for i in 0..self.rows() {
            for at in self.offsets[i]..self.offsets[i + 1] {
                let next = &mut next[self.columns[at] as usize];
                entries[*next] = (i as u32, at as u32);
                *next += 1;
            }
        }
        Transposed { offsets, entries }
    }
}

/// A value per entry of a pattern.
#[derive(Clone, Debug)]
pub struct SparseRows<T> {
    /// Where it has entries.
    pub pattern: Pattern,
    /// Row after row.
    pub values: Vec<T>,
}

impl<T: Copy + Send + Sync> SparseRows<T> {
    /// Collects `row(i, scratch, entries)`, which appends the entries of row i, columns ascending.
    pub fn collect<S>(
        rows: usize,
        scratch: impl Fn() -> S + Sync + Send,
        row: impl Fn(usize, &mut S, &mut Vec<(u32, T)>) + Sync + Send,
    ) -> Self {
        let (offsets, parts) = parts(rows, scratch, row);
        let length = parts.iter().map(Vec::len).sum();
        let (mut columns, mut values) = (Vec::with_capacity(length), Vec::with_capacity(length));
        for part in parts {
            columns.extend(part.iter().map(|entry| entry.0));
            values.extend(part.iter().map(|entry| entry.1));
        }
        Self {
            pattern: Pattern { offsets, columns },
            values,
        }
    }

    /// Columns and values of a row.
    #[inline(always)]
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, &T)> {
        let columns = self.pattern.row(i).iter().map(|j| *j as usize);
        columns.zip(&self.values[self.pattern.offsets[i]..])
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.pattern.bytes() + size_of_val(&*self.values)
    }
}

/// Where the rows begin, and their entries by tasks.
fn parts<S, E: Send>(
    rows: usize,
    scratch: impl Fn() -> S + Sync + Send,
    row: impl Fn(usize, &mut S, &mut Vec<E>) + Sync + Send,
) -> (Vec<usize>, Vec<Vec<E>>) {
    let of_task = |scratch: &mut S, range: Range<usize>| {
        let (mut ends, mut entries) = (Vec::with_capacity(range.len()), Vec::new());
        for i in range {
            row(i, scratch, &mut entries);
            ends.push(entries.len());
        }
        (ends, entries)
    };
    let tasks: Vec<_> = chunks(rows).map_init(scratch, of_task).collect();
    let mut offsets = vec![0];
    let mut before = 0;
    let parts = tasks.into_iter().map(|(ends, entries)| {
        offsets.extend(ends.iter().map(|end| before + end));
        before += entries.len();
        entries
    });
    let parts = parts.collect();
    (offsets, parts)
}

/// The transpose of a [`Pattern`].
#[derive(Clone, Debug)]
pub struct Transposed {
    offsets: Vec<usize>,
    entries: Vec<(u32, u32)>,
}

impl Transposed {
    /// Rows of the transpose.
    pub fn rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Ascending rows with an entry in column j, and the place of that entry.
    pub fn row(&self, j: usize) -> &[(u32, u32)] {
        &self.entries[self.range(j)]
    }

    /// Where the entries of column j lie.
    #[inline(always)]
    pub fn range(&self, j: usize) -> Range<usize> {
        self.offsets[j]..self.offsets[j + 1]
    }

    /// Row and place of all entries, column by column.
    #[inline(always)]
    pub fn entries(&self) -> &[(u32, u32)] {
        &self.entries
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.offsets) + size_of_val(&*self.entries)
    }
}
