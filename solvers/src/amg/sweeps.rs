//! Gauss–Seidel sweeps and products with one matrix of 3×3 blocks.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::schedule::Schedule;
use super::sums::Sums;
use crate::multigrid::lambda::largest_generalized;
use fracas_operators::shared::Shared;
use fracas_operators::simd::{Kernel, Lanes, Level, prefetch};
use fracas_operators::small::{Matrix3, cast, times};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::{for_each_task, for_row_ranges};
use fracas_operators::{LinearOperator, Real, Shape};
use rayon::prelude::*;

/// Rows that are asked for ahead of their use, the same part of each: 3 KiB of f32 of a 3-D stiffness.
const ROWS_AHEAD: usize = 3;

/// Pivot of a diagonal block with unit diagonal below which it counts as singular. Unit: 1.
pub(super) const SINGULAR: f64 = 1e-12;

/// Block rows that one task multiplies.
const ROWS_PER_TASK: usize = 256;

/// A symmetric matrix `A = L + D + U` of 3×3 blocks, L what a sweep has already visited, U what comes later.
///
/// Each row holds L, D, U in this order, so a half sweep reads half the matrix.
#[derive(Clone, Debug)]
pub(super) struct SweepMatrix<R> {
    offsets: Vec<usize>,
    /// Where the diagonal block of each row lies.
    diagonals: Vec<usize>,
    columns: Vec<u32>,
    /// One block more than stored, zero, so that a register may be loaded from the start of any block.
    blocks: Vec<Matrix3<R>>,
    /// D⁻¹.
    inverse: Vec<Matrix3<R>>,
    schedule: Schedule,
    level: Level,
}

/// Puts a row into the order L, D, U; gives the place of D.
fn order_row<R: Real>(
    i: usize,
    (columns, blocks): (&mut [u32], &mut [Matrix3<R>]),
    schedule: &Schedule,
    row: &mut Vec<(u32, Matrix3<R>)>,
) -> usize {
    row.clear();
    row.extend(columns.iter().copied().zip(blocks.iter().copied()));
    // a stable sort keeps ascending columns within L and U
    row.sort_by_key(|(j, _)| match *j as usize {
        j if j == i => 1,
        j if schedule.before(j, i) => 0,
        _ => 2_u8,
    });
    for (k, (j, block)) in row.iter().enumerate() {
        columns[k] = *j;
        blocks[k] = *block;
    }
    let lower = columns.iter().position(|j| *j as usize == i);
    debug_assert!(lower.is_some(), "row {i} has no diagonal block");
    lower.unwrap_or(0)
}

/// Which part of the rows.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Lower,
    Upper,
    OffDiagonal,
    All,
}

impl<R: Real> SweepMatrix<R> {
    /// From block rows with ascending columns, every diagonal block present, and the inverses of the diagonal blocks.
    pub(super) fn new(
        offsets: Vec<usize>,
        mut columns: Vec<u32>,
        mut blocks: Vec<Matrix3<R>>,
        inverse: Vec<Matrix3<R>>,
    ) -> Self {
        let rows = offsets.len() - 1;
        let schedule = Schedule::new(&offsets, &columns);
        let mut diagonals = vec![0; rows];
        let mut tasks = Vec::with_capacity(rows / ROWS_PER_TASK + 1);
        let (mut all_columns, mut all_blocks) = (&mut columns[..], &mut blocks[..]);
        for (k, own) in diagonals.chunks_mut(ROWS_PER_TASK).enumerate() {
            let rows = k * ROWS_PER_TASK..k * ROWS_PER_TASK + own.len();
            let length = offsets[rows.end] - offsets[rows.start];
            let (own_columns, other_columns) = all_columns.split_at_mut(length);
            let (own_blocks, other_blocks) = all_blocks.split_at_mut(length);
            (all_columns, all_blocks) = (other_columns, other_blocks);
            tasks.push((rows, own, own_columns, own_blocks));
        }
        tasks
            .into_par_iter()
            .for_each_init(Vec::new, |row, (rows, diagonals, columns, blocks)| {
                let start = offsets[rows.start];
                for (i, diagonal) in rows.zip(diagonals) {
                    let range = offsets[i] - start..offsets[i + 1] - start;
                    let own = (&mut columns[range.clone()], &mut blocks[range]);
                    *diagonal = offsets[i] + order_row(i, own, &schedule, row);
                }
            });
        blocks.push([[R::zero(); 3]; 3]);
        Self {
            offsets,
            diagonals,
            columns,
            blocks,
            inverse,
            schedule,
            level: Level::best(),
        }
    }

    /// The same matrix in another precision.
    pub(super) fn cast<S: Real>(&self) -> SweepMatrix<S> {
        let cast = |blocks: &[Matrix3<R>]| blocks.par_iter().map(cast).collect();
        SweepMatrix {
            offsets: self.offsets.clone(),
            diagonals: self.diagonals.clone(),
            columns: self.columns.clone(),
            blocks: cast(&self.blocks),
            inverse: cast(&self.inverse),
            schedule: self.schedule.clone(),
            level: self.level,
        }
    }

    /// Block rows.
    pub(super) fn rows(&self) -> usize {
        self.inverse.len()
    }

    /// Stored blocks.
    pub(super) fn block_count(&self) -> usize {
        self.columns.len()
    }

    /// Block columns and blocks of a row, in the order L, D, U.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &Matrix3<R>)> {
        let range = self.offsets[i]..self.offsets[i + 1];
        self.columns[range.clone()]
            .iter()
            .map(|j| *j as usize)
            .zip(&self.blocks[range])
    }

    /// Block columns of a row, in the order L, D, U.
    pub(super) fn columns_of(&self, i: usize) -> &[u32] {
        &self.columns[self.offsets[i]..self.offsets[i + 1]]
    }

    /// Diagonal block of a row.
    pub(super) fn diagonal(&self, i: usize) -> &Matrix3<R> {
        &self.blocks[self.diagonals[i]]
    }

    /// Inverse diagonal block of a row.
    pub(super) fn inverse(&self, i: usize) -> &Matrix3<R> {
        &self.inverse[i]
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.offsets)
            + size_of_val(&*self.diagonals)
            + size_of_val(&*self.columns)
            + size_of_val(&*self.blocks)
            + size_of_val(&*self.inverse)
    }

    /// Flops of one sweep: a product with L + U and one with D⁻¹.
    pub(super) fn sweep_flops(&self) -> u64 {
        self.flops() + 3 * self.rows() as u64
    }

    /// An upper estimate of `λ_max(D⁻¹A)`.
    pub(super) fn largest_eigenvalue(&self) -> f64 {
        largest_generalized(
            3 * self.rows(),
            |x, y| self.apply(x, y, &mut []),
            |r, z| self.diagonal_solve(r, z),
        )
    }

    /// The entries that are to be kept, in f64.
    pub(super) fn to_csr(&self, keeps: impl Fn(f64) -> bool) -> SparseMatrix<f64> {
        let n = 3 * self.rows();
        let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut row: Vec<(usize, &Matrix3<R>)> = Vec::new();
        for i in 0..self.rows() {
            row.clear();
            row.extend(self.row(i));
            row.sort_unstable_by_key(|entry| entry.0);
            for r in 0..3 {
                for (j, block) in &row {
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

    /// `x ← (D + L)⁻¹ b`: a forward sweep from x = 0, reading D and L only.
    pub(super) fn forward_from_zero(&self, b: &[R], x: &mut [R]) {
        self.sweep(b, x, Part::Lower, false);
    }

    /// `r ← −U x`, the residual `b − A x` of what [`forward_from_zero`](Self::forward_from_zero) gives.
    pub(super) fn residual_after_forward(&self, x: &[R], r: &mut [R]) {
        self.rows_into(x, r, Part::Upper, &|_, sum, r| *r = sum.map(|v| -v));
    }

    /// One forward sweep from x.
    pub(super) fn forward(&self, b: &[R], x: &mut [R]) {
        self.sweep(b, x, Part::OffDiagonal, false);
    }

    /// One backward sweep from x.
    pub(super) fn backward(&self, b: &[R], x: &mut [R]) {
        self.sweep(b, x, Part::OffDiagonal, true);
    }

    /// `r ← b − A x`.
    pub(super) fn residual(&self, b: &[R], x: &[R], r: &mut [R]) {
        self.rows_into(x, r, Part::All, &|i, sum, r| {
            *r = std::array::from_fn(|c| b[3 * i + c] - sum[c]);
        });
    }

    /// `z ← D⁻¹ r`.
    pub(super) fn diagonal_solve(&self, r: &[R], z: &mut [R]) {
        for_row_ranges(0, 3 * ROWS_PER_TASK, z, &|start, part| {
            let (r, inverse) = (&r[start..].as_chunks().0, &self.inverse[start / 3..]);
            for ((z, r), inverse) in part.as_chunks_mut().0.iter_mut().zip(*r).zip(inverse) {
                *z = times(inverse, r);
            }
        });
    }

    /// Distance in blocks from row i to the row that is wanted soon.
    #[inline(always)]
    fn ahead(&self, i: usize, backward: bool) -> usize {
        let other = if backward {
            i.saturating_sub(ROWS_AHEAD)
        } else {
            (i + ROWS_AHEAD).min(self.rows() - 1)
        };
        self.offsets[other].wrapping_sub(self.offsets[i])
    }

    fn range(&self, i: usize, part: Part) -> [std::ops::Range<usize>; 2] {
        let (first, middle, last) = (self.offsets[i], self.diagonals[i], self.offsets[i + 1]);
        match part {
            Part::Lower => [first..middle, 0..0],
            Part::Upper => [middle + 1..last, 0..0],
            Part::OffDiagonal => [first..middle, middle + 1..last],
            Part::All => [first..last, 0..0],
        }
    }

    /// Rows one after the other: `x_i ← D_i⁻¹ (b_i − Σ_part A_ij x_j)`.
    fn sweep(&self, b: &[R], x: &mut [R], part: Part, backward: bool) {
        assert!(b.len() == 3 * self.rows() && x.len() == b.len());
        let shared = Shared::new(x);
        let groups = self.schedule.groups();
        for k in 0..groups.len() {
            let group = &groups[if backward { groups.len() - 1 - k } else { k }];
            for_each_task(0..group.len(), &|k| {
                self.level.run(Chunk {
                    matrix: self,
                    rows: self.schedule.chunk(group[k]),
                    part,
                    backward,
                    b,
                    x: &shared,
                });
            });
        }
    }

    /// `finish(i, Σ_part A_ij x_j, y_i)` for every row.
    fn rows_into(
        &self,
        x: &[R],
        y: &mut [R],
        part: Part,
        finish: &(impl Fn(usize, [R; 3], &mut [R; 3]) + Sync),
    ) {
        assert!(x.len() == 3 * self.rows() && y.len() == x.len());
        for_row_ranges(0, 3 * ROWS_PER_TASK, y, &|start, y| {
            self.level.run(Rows {
                matrix: self,
                first: start / 3,
                part,
                x,
                y,
                finish,
            });
        });
    }
}

impl<R: Real> LinearOperator<R> for SweepMatrix<R> {
    fn shape(&self) -> Shape {
        Shape::square(3 * self.rows())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        self.rows_into(x, y, Part::All, &|_, sum, y| {
            (0..3).for_each(|c| y[c] += alpha * sum[c]);
        });
    }

    fn apply(&self, x: &[R], y: &mut [R], _work: &mut [R]) {
        self.rows_into(x, y, Part::All, &|_, sum, y| *y = sum);
    }

    fn flops(&self) -> u64 {
        18 * self.block_count() as u64
    }
}

/// One chunk of a sweep.
struct Chunk<'a, R> {
    matrix: &'a SweepMatrix<R>,
    rows: std::ops::Range<usize>,
    part: Part,
    backward: bool,
    b: &'a [R],
    x: &'a Shared<'a, R>,
}

impl<R: Real> Kernel<R> for Chunk<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let matrix = self.matrix;
        let values = matrix.blocks.as_flattened().as_flattened();
        for k in 0..self.rows.len() {
            let i = if self.backward {
                self.rows.end - 1 - k
            } else {
                self.rows.start + k
            };
            let ahead = 9_usize.wrapping_mul(matrix.ahead(i, self.backward));
            let mut sums = Sums::<L, R>::zero();
            for range in matrix.range(i, self.part) {
                for k in range {
                    let at = 9 * k;
                    prefetch(values, at.wrapping_add(ahead));
                    // SAFETY: other chunks of this colour write only rows that share no entry with row i.
                    let x = unsafe { self.x.triple(matrix.columns[k] as usize) };
                    sums.add(values, at, x);
                }
            }
            let sum = sums.finish();
            let r = [
                self.b[3 * i] - sum[0],
                self.b[3 * i + 1] - sum[1],
                self.b[3 * i + 2] - sum[2],
            ];
            // SAFETY: row i belongs to this chunk alone, and no reference into it is alive.
            unsafe { self.x.set(i, times(&matrix.inverse[i], &r)) };
        }
    }
}

/// Consecutive rows of a product.
struct Rows<'a, R, F> {
    matrix: &'a SweepMatrix<R>,
    first: usize,
    part: Part,
    x: &'a [R],
    y: &'a mut [R],
    finish: &'a F,
}

impl<R: Real, F: Fn(usize, [R; 3], &mut [R; 3])> Kernel<R> for Rows<'_, R, F> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let matrix = self.matrix;
        let values = matrix.blocks.as_flattened().as_flattened();
        for (k, y) in self.y.as_chunks_mut().0.iter_mut().enumerate() {
            let i = self.first + k;
            let ahead = 9 * matrix.ahead(i, false);
            let mut sums = Sums::<L, R>::zero();
            for range in matrix.range(i, self.part) {
                for k in range {
                    prefetch(values, 9 * k + ahead);
                    let x = &self.x[3 * matrix.columns[k] as usize..][..3];
                    sums.add(values, 9 * k, x);
                }
            }
            (self.finish)(i, sums.finish(), y);
        }
    }
}
