//! Compressed rows of 3×3 blocks, one per pair of nodes.

use super::SparseMatrix;
use crate::operator::assert_product;
use crate::vector::for_row_ranges;
use crate::{AdjointOperator, LinearOperator, Real, Shape};

/// A sparse matrix of 3×3 blocks (row-major inside a block).
///
/// # Cost
/// One product: 18 flops and 76 bytes per block in f64.
#[derive(Clone, Debug)]
pub struct Block3<R> {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    blocks: Vec<[R; 9]>,
    cols: usize,
}

/// Block rows that one thread handles without splitting.
const ROWS_PER_TASK: usize = 256;

impl<R: Real> Block3<R> {
    /// From raw block rows: `offsets` (block rows + 1), block `columns`, `blocks`, and the number of block columns.
    pub fn from_raw(
        offsets: Vec<usize>,
        columns: Vec<u32>,
        blocks: Vec<[R; 9]>,
        cols: usize,
    ) -> Self {
        assert_eq!(columns.len(), blocks.len());
        assert_eq!(offsets.last().copied(), Some(columns.len()));
        Self {
            offsets,
            columns,
            blocks,
            cols,
        }
    }

    /// Block rows.
    pub fn block_rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Stored blocks.
    pub fn block_count(&self) -> usize {
        self.blocks.len()
    }

    /// Block row offsets (block rows + 1).
    pub fn offsets(&self) -> &[usize] {
        &self.offsets
    }

    /// Block columns, row after row.
    pub fn columns(&self) -> &[u32] {
        &self.columns
    }

    /// Blocks, row after row, each row-major.
    pub fn blocks(&self) -> &[[R; 9]] {
        &self.blocks
    }

    /// Entries (column, value) of one scalar row, zeros inside blocks included.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, R)> + '_ {
        let range = self.offsets[row / 3]..self.offsets[row / 3 + 1];
        let r = 3 * (row % 3);
        range.flat_map(move |k| {
            let (block, j) = (&self.blocks[k], 3 * self.columns[k] as usize);
            (0..3).map(move |c| (j + c, block[r + c]))
        })
    }

    /// The same matrix in another precision.
    pub fn cast<S: Real>(&self) -> Block3<S> {
        Block3 {
            offsets: self.offsets.clone(),
            columns: self.columns.clone(),
            blocks: self
                .blocks
                .iter()
                .map(|b| b.map(|v| S::of(v.to_f64_exact())))
                .collect(),
            cols: self.cols,
        }
    }

    /// The same matrix entry by entry, without the zeros inside blocks.
    pub fn to_csr(&self) -> SparseMatrix<R> {
        let n = 3 * self.block_rows();
        let mut offsets = vec![0];
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for row in 0..n {
            for (column, value) in self.row(row).filter(|entry| entry.1 != R::zero()) {
                columns.push(column as u32);
                values.push(value);
            }
            offsets.push(columns.len());
        }
        SparseMatrix::new((n, 3 * self.cols), offsets, columns, values)
    }
}

impl<R: Real> LinearOperator<R> for Block3<R> {
    fn shape(&self) -> Shape {
        Shape::new(3 * self.block_rows(), 3 * self.cols)
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape(), x, y);
        for_row_ranges(0, 3 * ROWS_PER_TASK, y, &|start, part| {
            for (i, y_i) in part.chunks_exact_mut(3).enumerate() {
                let row = start / 3 + i;
                let mut sum = [R::zero(); 3];
                for k in self.offsets[row]..self.offsets[row + 1] {
                    let (b, j) = (&self.blocks[k], 3 * self.columns[k] as usize);
                    let x = &x[j..j + 3];
                    for r in 0..3 {
                        sum[r] += b[3 * r] * x[0] + b[3 * r + 1] * x[1] + b[3 * r + 2] * x[2];
                    }
                }
                for r in 0..3 {
                    y_i[r] += alpha * sum[r];
                }
            }
        });
    }

    fn flops(&self) -> u64 {
        18 * self.blocks.len() as u64 + 6 * self.block_rows() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Block3<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape().transposed(), x, y);
        for (row, x_i) in x.chunks_exact(3).enumerate() {
            for k in self.offsets[row]..self.offsets[row + 1] {
                let (b, j) = (&self.blocks[k], 3 * self.columns[k] as usize);
                for c in 0..3 {
                    y[j + c] += alpha * (b[c] * x_i[0] + b[3 + c] * x_i[1] + b[6 + c] * x_i[2]);
                }
            }
        }
    }
}
