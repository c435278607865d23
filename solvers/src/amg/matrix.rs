//! A matrix of 3×3 blocks, all of it, from which a level is made.

use super::sums::Sums;
use crate::multigrid::lambda::{STEPS, largest_generalized};
use fracas_operators::Real;
use fracas_operators::simd::{Kernel, Lanes, Level, prefetch};
use fracas_operators::small::{Matrix3, times};
use fracas_operators::sparse::{Pattern, SparseMatrix};
use fracas_operators::vector::for_row_ranges;

/// Rows that are asked for ahead of their use, the same part of each: 3 KiB of f32 of a 3-D stiffness.
const ROWS_AHEAD: usize = 3;

/// Pivot of a diagonal block with unit diagonal below which it counts as singular. Unit: 1.
pub(super) const SINGULAR: f64 = 1e-12;

/// Block rows that one task multiplies.
const ROWS_PER_TASK: usize = 256;

/// A symmetric matrix of 3×3 blocks, both triangles stored.
#[derive(Clone, Debug)]
pub(super) struct NodeMatrix<R> {
    /// Every diagonal block is there.
    pattern: Pattern,
    /// One block more than stored, zero, so that a register may be loaded from the start of any block.
    blocks: Vec<Matrix3<R>>,
    /// Inverse diagonal blocks.
    inverse: Vec<Matrix3<R>>,
    level: Level,
}

impl<R: Real> NodeMatrix<R> {
    /// From block rows with every diagonal block present, and the inverses of the diagonal blocks.
    pub(super) fn new(
        pattern: Pattern,
        mut blocks: Vec<Matrix3<R>>,
        inverse: Vec<Matrix3<R>>,
    ) -> Self {
        assert_eq!(blocks.len(), pattern.columns.len(), "blocks of a level");
        assert_eq!(inverse.len(), pattern.rows(), "rows of a level");
        blocks.push([[R::zero(); 3]; 3]);
        Self {
            pattern,
            blocks,
            inverse,
            level: Level::best(),
        }
    }

    /// Block rows.
    pub(super) fn rows(&self) -> usize {
        self.inverse.len()
    }

    /// Stored blocks.
    pub(super) fn block_count(&self) -> usize {
        self.pattern.columns.len()
    }

    /// Where it has blocks.
    pub(super) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// Ascending block columns and blocks of a row.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &Matrix3<R>)> {
        let range = self.pattern.range(i);
        self.columns_of(i)
            .iter()
            .map(|j| *j as usize)
            .zip(&self.blocks[range])
    }

    /// Ascending block columns of a row.
    #[inline(always)]
    pub(super) fn columns_of(&self, i: usize) -> &[u32] {
        self.pattern.row(i)
    }

    /// Diagonal block of a row.
    pub(super) fn diagonal(&self, i: usize) -> &Matrix3<R> {
        &self.blocks[self.pattern.place(i, i as u32)]
    }

    /// Inverse diagonal block of a row.
    pub(super) fn inverse(&self, i: usize) -> &Matrix3<R> {
        &self.inverse[i]
    }

    /// An upper estimate of `λ_max(D⁻¹A)`.
    pub(super) fn largest_eigenvalue(&self) -> f64 {
        largest_generalized(
            (3 * self.rows(), STEPS),
            |x, y| self.apply(x, y),
            |r, z| block_times(&self.inverse, r, z),
        )
    }

    /// Its pattern, blocks with the one of zeros behind them, and inverse diagonal blocks.
    pub(super) fn into_parts(self) -> (Pattern, Vec<Matrix3<R>>, Vec<Matrix3<R>>) {
        (self.pattern, self.blocks, self.inverse)
    }

    /// The entries that are to be kept, in f64.
    pub(super) fn to_csr(&self, keeps: impl Fn(f64) -> bool) -> SparseMatrix<f64> {
        let n = 3 * self.rows();
        let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for i in 0..self.rows() {
            for r in 0..3 {
                for (j, block) in self.row(i) {
                    for c in 0..3 {
                        let value = block[r][c].to_f64_exact();
                        if keeps(value) {
                            columns.push((3 * j + c) as u32);
                            values.push(value);
                        }
                    }
                }
                offsets.push(columns.len());
            }
        }
        SparseMatrix::new((n, n), offsets, columns, values)
    }

    /// `y ← A x`.
    fn apply(&self, x: &[R], y: &mut [R]) {
        assert!(x.len() == 3 * self.rows() && y.len() == x.len());
        for_row_ranges(0, 3 * ROWS_PER_TASK, y, &|start, y| {
            let first = start / 3;
            self.level.run(Rows {
                matrix: self,
                first,
                x,
                y,
            });
        });
    }
}

/// `z ← D⁻¹ r` by these inverse diagonal blocks.
pub(super) fn block_times<R: Real>(inverse: &[Matrix3<R>], r: &[R], z: &mut [R]) {
    for_row_ranges(0, 3 * ROWS_PER_TASK, z, &|start, part| {
        let (r, inverse) = (&r[start..].as_chunks().0, &inverse[start / 3..]);
        for ((z, r), inverse) in part.as_chunks_mut().0.iter_mut().zip(*r).zip(inverse) {
            *z = times(inverse, r);
        }
    });
}

/// Consecutive rows of a product.
struct Rows<'a, R> {
    matrix: &'a NodeMatrix<R>,
    first: usize,
    x: &'a [R],
    y: &'a mut [R],
}

impl<R: Real> Kernel<R> for Rows<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let Pattern { offsets, columns } = &self.matrix.pattern;
        let values = self.matrix.blocks.as_flattened().as_flattened();
        let last = self.matrix.rows() - 1;
        for (k, y) in self.y.as_chunks_mut().0.iter_mut().enumerate() {
            let i = self.first + k;
            let ahead = 9 * (offsets[(i + ROWS_AHEAD).min(last)] - offsets[i]);
            let mut sums = Sums::<L, R>::zero();
            for k in offsets[i]..offsets[i + 1] {
                prefetch(values, 9 * k + ahead);
                sums.add(values, 9 * k, &self.x[3 * columns[k] as usize..][..3]);
            }
            *y = sums.finish();
        }
    }
}
