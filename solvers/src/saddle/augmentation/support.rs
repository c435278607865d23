//! Columns of B and principal submatrices of A on their supports.

use fracas_operators::sparse::SparseMatrix;

/// B by columns, explicit zeros dropped.
pub(super) struct Columns {
    offsets: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Columns {
    pub(super) fn new(b: &SparseMatrix<f64>) -> Self {
        let by_column = b.to_csc();
        let (mut offsets, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in by_column.outer_iterator() {
            for (row, value) in column.iter().filter(|(_, v)| **v != 0.0) {
                rows.push(row);
                values.push(*value);
            }
            offsets.push(rows.len());
        }
        Self {
            offsets,
            rows,
            values,
        }
    }

    /// n_t.
    pub(super) fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Rows of the entries of column i, ascending.
    pub(super) fn support(&self, i: usize) -> &[usize] {
        &self.rows[self.offsets[i]..self.offsets[i + 1]]
    }

    /// Entries of column i.
    pub(super) fn values(&self, i: usize) -> &[f64] {
        &self.values[self.offsets[i]..self.offsets[i + 1]]
    }

    /// ‖r(b_i)‖₂².
    pub(super) fn norm_squared(&self, i: usize) -> f64 {
        self.values(i).iter().map(|v| v * v).sum()
    }

    /// Columns without entries.
    pub(super) fn empty(&self) -> Vec<usize> {
        (0..self.len())
            .filter(|&i| self.support(i).is_empty())
            .collect()
    }
}

/// Entries `(row, column, value)` of A restricted to `support` (ascending), in local numbers.
pub(in crate::saddle) fn for_restricted(
    a: &SparseMatrix<f64>,
    support: &[usize],
    mut entry: impl FnMut(usize, usize, f64),
) {
    for (i, &row) in support.iter().enumerate() {
        let Some(vector) = a.outer_view(row) else {
            continue;
        };
        let (columns, values) = (vector.indices(), vector.data());
        let mut k = 0;
        for (j, &column) in support.iter().enumerate() {
            k += columns[k..].partition_point(|c| (*c as usize) < column);
            if columns.get(k).is_some_and(|c| *c as usize == column) {
                entry(i, j, values[k]);
            }
        }
    }
}
