//! Compressed rows of 3×3 blocks, one per pair of nodes.

use super::{SparseMatrix, SparseRows};
use crate::operator::assert_product;
use crate::simd::{Kernel, Lanes, Level, MAX_WIDTH, prefetch};
use crate::small::{Matrix3, cast};
use crate::vector::for_row_ranges;
use crate::{AdjointOperator, LinearOperator, Real, Shape};

/// A sparse matrix of 3×3 blocks (row-major inside a block).
///
/// # Cost
/// One product: 18 flops and 76 bytes per block in f64.
#[derive(Clone, Debug)]
pub struct Block3<R> {
    /// One block more than stored, zero, so that a register may be loaded from the start of any block.
    rows: SparseRows<Matrix3<R>>,
    cols: usize,
    level: Level,
}

/// Blocks that are asked for ahead of their use: 4.5 KiB of f64. Measured: 24 blocks reach 67 % of the read bandwidth, 64
/// blocks 80 %.
const AHEAD: usize = 64;

/// Block rows that one task multiplies: about 500 KiB of f64 of a 3-D stiffness.
const ROWS_PER_TASK: usize = 256;

impl<R: Real> Block3<R> {
    /// From block rows and the number of block columns.
    pub fn new(mut rows: SparseRows<Matrix3<R>>, cols: usize) -> Self {
        let SparseRows { pattern, values } = &mut rows;
        assert_eq!(pattern.columns.len(), values.len());
        assert_eq!(pattern.offsets.last().copied(), Some(values.len()));
        values.push([[R::zero(); 3]; 3]);
        Self {
            rows,
            cols,
            level: Level::best(),
        }
    }

    /// The same with a chosen instruction set.
    pub fn with_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Block rows.
    pub fn block_rows(&self) -> usize {
        self.rows.pattern.rows()
    }

    /// Stored blocks.
    pub fn block_count(&self) -> usize {
        self.rows.pattern.columns.len()
    }

    /// Block columns and blocks of a block row, columns ascending.
    pub fn block_row(&self, i: usize) -> impl Iterator<Item = (usize, &Matrix3<R>)> {
        self.rows.row(i)
    }

    /// Block (i, j), where it is stored.
    pub fn block(&self, i: usize, j: usize) -> Option<&Matrix3<R>> {
        let at = self.rows.pattern.row(i).binary_search(&(j as u32)).ok()?;
        self.rows.values.get(self.rows.pattern.offsets[i] + at)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.rows.bytes()
    }

    /// Entries (column, value) of one scalar row, zeros inside blocks included.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, R)> + '_ {
        let r = row % 3;
        self.block_row(row / 3)
            .flat_map(move |(j, block)| (0..3).map(move |c| (3 * j + c, block[r][c])))
    }

    /// The same matrix in another precision.
    pub fn cast<S: Real>(&self) -> Block3<S> {
        Block3 {
            rows: SparseRows {
                pattern: self.rows.pattern.clone(),
                values: self.rows.values.iter().map(cast).collect(),
            },
            cols: self.cols,
            level: self.level,
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
            self.level.run(Rows {
                matrix: self,
                first: start / 3,
                alpha,
                x,
                y: part,
            });
        });
    }

    fn flops(&self) -> u64 {
        18 * self.block_count() as u64 + 6 * self.block_rows() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Block3<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape().transposed(), x, y);
        for (row, x_i) in x.chunks_exact(3).enumerate() {
            for (j, b) in self.block_row(row) {
                for c in 0..3 {
                    y[3 * j + c] +=
                        alpha * (b[0][c] * x_i[0] + b[1][c] * x_i[1] + b[2][c] * x_i[2]);
                }
            }
        }
    }

    fn adjoint_flops(&self) -> u64 {
        18 * self.block_count() as u64 + 6 * self.block_rows() as u64
    }
}

/// Consecutive block rows of one product.
struct Rows<'a, R> {
    matrix: &'a Block3<R>,
    first: usize,
    alpha: R,
    x: &'a [R],
    y: &'a mut [R],
}

impl<R: Real> Kernel<R> for Rows<'_, R> {
    /// The nine products of a block fall into nine lanes, `b_{rc} x_c` into lane 3r + c; lanes are summed per row.
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let SparseRows { pattern, values } = &self.matrix.rows;
        let values = values.as_flattened().as_flattened();
        let zero = L::splat(R::zero());
        for (i, y) in self.y.chunks_exact_mut(3).enumerate() {
            let range = pattern.range(self.first + i);
            // A register holds 4, 8 or 16 lanes, so the nine take 2, 1 or 1 registers and sometimes a scalar.
            let (mut low, mut high, mut last) = (zero, zero, R::zero());
            for (k, j) in range.clone().zip(&pattern.columns[range]) {
                let at = 9 * k;
                prefetch(values, at + 9 * AHEAD);
                let x = &self.x[3 * *j as usize..][..3];
                low = L::load(&values[at..]).mul_add(L::repeat(x, 0), low);
                if L::WIDTH == 4 {
                    high = L::load(&values[at + 4..]).mul_add(L::repeat(x, 1), high);
                }
                if L::WIDTH <= 8 {
                    last += values[at + 8] * x[2];
                }
            }
            let mut lanes = [R::zero(); 2 * MAX_WIDTH];
            low.store(&mut lanes);
            if L::WIDTH == 4 {
                high.store(&mut lanes[4..]);
            }
            if L::WIDTH <= 8 {
                lanes[8] = last;
            }
            for r in 0..3 {
                y[r] += self.alpha * (lanes[3 * r] + lanes[3 * r + 1] + lanes[3 * r + 2]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::{check_adjoint, probe};
    use crate::sparse::Pattern;
    use crate::{Dense, Shape};

    /// A matrix of 7×5 blocks with an empty row, a full row and single blocks.
    fn sample<R: Real>() -> Block3<R> {
        let rows: [&[u32]; 7] = [&[0, 2], &[], &[0, 1, 2, 3, 4], &[4], &[1, 3], &[2], &[0, 4]];
        let own = |i: usize, (): &mut (), columns: &mut Vec<u32>| columns.extend(rows[i]);
        let pattern = Pattern::collect(rows.len(), || (), own);
        let values = probe::<R>(9 * pattern.columns.len(), 11);
        let values = values.as_chunks::<3>().0.as_chunks::<3>().0.to_vec();
        Block3::new(SparseRows { pattern, values }, 5)
    }

    fn oracle<R: Real>(matrix: &Block3<R>) -> Dense<R> {
        let mut dense = Dense::zeros(Shape::new(21, 15));
        for row in 0..21 {
            for (column, value) in matrix.row(row) {
                *dense.entry_mut(row, column) = value;
            }
        }
        dense
    }

    #[test]
    fn products_agree_with_the_dense_oracle_on_every_instruction_set() {
        for level in Level::supported() {
            let matrix = sample::<f64>().with_level(level);
            check_adjoint("Block3 f64", &matrix, Some(&oracle(&matrix))).unwrap();
            let matrix = sample::<f32>().with_level(level);
            check_adjoint("Block3 f32", &matrix, Some(&oracle(&matrix))).unwrap();
        }
    }

    #[test]
    fn the_scalar_matrix_has_the_same_entries() {
        let matrix = sample::<f64>();
        let csr = crate::sparse::Csr::new(matrix.to_csr());
        assert_eq!(Dense::of_operator(&csr), oracle(&matrix));
        let single = matrix.cast::<f32>();
        let block = matrix.block(2, 1).unwrap();
        assert_eq!(single.block(2, 1), Some(&cast(block)));
        assert_eq!(matrix.block(2, 5), None);
    }
}
