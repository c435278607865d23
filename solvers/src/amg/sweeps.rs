//! Gauss–Seidel sweeps and products with half a symmetric matrix of 3×3 blocks.
#![allow(unsafe_code, reason = "reads and writes of tasks that share no entry")]

use super::matrix::NodeMatrix;
use super::schedule::Schedule;
use super::sums::Sums;
use fracas_operators::shared::Shared;
use fracas_operators::simd::{CACHE_LINE, Kernel, Lanes, Level, prefetch};
use fracas_operators::small::{Matrix3, cast, times};
use fracas_operators::sparse::Pattern;
use fracas_operators::vector::{for_each_task, for_row_ranges};
use fracas_operators::{LinearOperator, Real, Shape};
use rayon::prelude::*;
use std::ops::Range;

/// Rows that are asked for ahead of their use, the same part of each: 3 KiB of f32 of a 3-D stiffness.
const ROWS_AHEAD: usize = 6;

/// Block rows that one task divides by their diagonal blocks.
const ROWS_PER_TASK: usize = 256;

/// A symmetric matrix `A = L + D + Lᵀ` of 3×3 blocks, L what a forward sweep visits before a row.
///
/// Only L and D are stored. A task that holds row i of L adds `L_i x` to row i and `L_ijᵀ x_i` to the rows j before it, so that
/// sweeps, the residuals behind them and products read each block once.
#[derive(Clone, Debug)]
pub(super) struct Sweeps<R> {
    /// Of L; ascending columns.
    pattern: Pattern,
    /// Of L; one more, zero, so that a register may be loaded from the start of any block.
    blocks: Vec<Matrix3<R>>,
    diagonal: Vec<Matrix3<R>>,
    /// D⁻¹.
    inverse: Vec<Matrix3<R>>,
    schedule: Schedule,
    level: Level,
}

/// What a forward sweep knows of `r = −Lᵀx`, and what it leaves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Forward {
    /// x arrives as zero, r with any content.
    pub(super) from_zero: bool,
    /// r leaves as `b − A x` in place of `−Lᵀx`.
    pub(super) residual: bool,
}

impl<R: Real> Sweeps<R> {
    /// L and D of a matrix, whose Lᵀ is not looked at, in another precision.
    pub(super) fn new<S: Real>(a: &NodeMatrix<S>) -> Self {
        let all = a.pattern();
        let schedule = Schedule::new(&all.offsets, &all.columns);
        let is_before = |j: usize, i: usize| schedule.before(j, i);
        let pattern = Pattern::collect(
            a.rows(),
            || (),
            |i, (), columns| {
                let row = a.columns_of(i).iter().copied();
                columns.extend(row.filter(|j| is_before(*j as usize, i)));
            },
        );
        let count = pattern.columns.len();
        let mut blocks = vec![[[R::zero(); 3]; 3]; count + 1];
        pattern.fill(
            &mut blocks[..count],
            || (),
            |rows, part, ()| {
                let of_row = |i: usize| {
                    let row = a.row(i).filter(move |(j, _)| is_before(*j, i));
                    row.map(|(_, block)| cast(block))
                };
                let before = rows.flat_map(of_row);
                part.iter_mut().zip(before).for_each(|(to, b)| *to = b);
            },
        );
        let each = |of: fn(&NodeMatrix<S>, usize) -> &Matrix3<S>| {
            let rows = (0..a.rows()).into_par_iter();
            rows.map(|i| cast(of(a, i))).collect()
        };
        Self {
            pattern,
            blocks,
            diagonal: each(NodeMatrix::diagonal),
            inverse: each(NodeMatrix::inverse),
            schedule,
            level: Level::best(),
        }
    }

    /// Block rows.
    pub(super) fn rows(&self) -> usize {
        self.inverse.len()
    }

    /// Inverse diagonal block of a row.
    pub(super) fn inverse(&self, i: usize) -> &Matrix3<R> {
        &self.inverse[i]
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.pattern.bytes()
            + size_of_val(&*self.blocks)
            + size_of_val(&*self.diagonal)
            + size_of_val(&*self.inverse)
    }

    /// Flops of one sweep with what it leaves: a product with L and Lᵀ and one with D⁻¹.
    pub(super) fn sweep_flops(&self) -> u64 {
        36 * self.pattern.columns.len() as u64 + 21 * self.rows() as u64
    }

    /// One forward sweep: `x ← (D + L)⁻¹ (b − Lᵀx)`, and what the settings say of r.
    pub(super) fn forward(&self, b: &[R], x: &mut [R], r: &mut [R], settings: Forward) {
        assert!(b.len() == 3 * self.rows() && x.len() == b.len() && r.len() == b.len());
        let (x, r) = (&Shared::new(x), &Shared::new(r));
        self.visit(false, Work::Forward { b, x, r, settings });
    }

    /// One backward sweep: `x ← (D + Lᵀ)⁻¹ (b − L x)`; s is destroyed.
    pub(super) fn backward(&self, b: &[R], x: &mut [R], s: &mut [R]) {
        assert!(b.len() == 3 * self.rows() && x.len() == b.len() && s.len() == b.len());
        s.fill(R::zero());
        let (x, s) = (&Shared::new(x), &Shared::new(s));
        self.visit(true, Work::Backward { b, x, s });
    }

    /// `r ← b − A x`.
    pub(super) fn residual(&self, b: &[R], x: &[R], r: &mut [R]) {
        r.copy_from_slice(b);
        self.apply_add(-R::one(), x, r, &mut []);
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

    /// Every chunk of rows, colour after colour, in the order of a sweep.
    fn visit(&self, backward: bool, work: Work<'_, R>) {
        let groups = self.schedule.groups();
        for k in 0..groups.len() {
            let group = &groups[if backward { groups.len() - 1 - k } else { k }];
            for_each_task(0..group.len(), &|k| {
                let rows = self.schedule.chunk(group[k]);
                self.level.run(Chunk {
                    matrix: self,
                    rows,
                    work,
                });
            });
        }
    }
}

impl<R: Real> LinearOperator<R> for Sweeps<R> {
    fn shape(&self) -> Shape {
        Shape::square(3 * self.rows())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert!(x.len() == 3 * self.rows() && y.len() == x.len());
        let y = &Shared::new(y);
        self.visit(false, Work::Product { alpha, x, y });
    }

    fn flops(&self) -> u64 {
        36 * self.pattern.columns.len() as u64 + 18 * self.rows() as u64
    }
}

/// The three entries of a block row.
///
/// # Safety
/// As [`Shared::triple`].
#[inline(always)]
unsafe fn triple<R: Real>(x: &Shared<'_, R>, row: usize) -> [R; 3] {
    // SAFETY: by contract.
    let x = unsafe { x.triple(row) };
    [x[0], x[1], x[2]]
}

impl<R: Real> Sweeps<R> {
    /// Asks for the blocks of a row that is wanted soon.
    #[inline(always)]
    fn ask(&self, soon: usize) {
        let soon = soon.min(self.rows() - 1);
        let [first, last] = [self.pattern.offsets[soon], self.pattern.offsets[soon + 1]];
        let values = self.blocks.as_flattened().as_flattened();
        let line = CACHE_LINE / size_of::<R>();
        (9 * first..9 * last)
            .step_by(line)
            .for_each(|at| prefetch(values, at));
    }

    /// `L_i x`.
    #[inline(always)]
    fn row_times<'x, L: Lanes<R>>(&self, i: usize, x: impl Fn(usize) -> &'x [R]) -> [R; 3] {
        let values = self.blocks.as_flattened().as_flattened();
        let mut sums = Sums::<L, R>::zero();
        for k in self.pattern.range(i) {
            sums.add(values, 9 * k, x(self.pattern.columns[k] as usize));
        }
        sums.finish()
    }

    /// `y_j ← y_j + L_ijᵀ x_i` for every j.
    ///
    /// # Safety
    /// Nobody else reads or writes the rows of y before row i meanwhile.
    #[inline(always)]
    unsafe fn add_column(&self, i: usize, x: [R; 3], y: &Shared<'_, R>) {
        let range = self.pattern.range(i);
        let columns = &self.pattern.columns[range.clone()];
        for (j, l) in columns.iter().zip(&self.blocks[range]) {
            let mut image = [R::zero(); 3];
            for c in 0..3 {
                image[c] = l[0][c] * x[0] + l[1][c] * x[1] + l[2][c] * x[2];
            }
            // SAFETY: columns are rows of the square matrix; by contract nobody else has them.
            let y = unsafe { y.part_unchecked(3 * *j as usize, 3) };
            (0..3).for_each(|c| y[c] += image[c]);
        }
    }
}

/// What a visit does with every row, in the order of a sweep.
enum Work<'a, R> {
    Forward {
        b: &'a [R],
        x: &'a Shared<'a, R>,
        r: &'a Shared<'a, R>,
        settings: Forward,
    },
    Backward {
        b: &'a [R],
        x: &'a Shared<'a, R>,
        /// −Lᵀx of the rows visited.
        s: &'a Shared<'a, R>,
    },
    Product {
        alpha: R,
        x: &'a [R],
        y: &'a Shared<'a, R>,
    },
}

impl<R: Copy> Clone for Work<'_, R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R: Copy> Copy for Work<'_, R> {}

/// One chunk of rows.
///
/// It writes its rows and those that its rows of L reach; chunks of one colour share none of these.
struct Chunk<'a, R> {
    matrix: &'a Sweeps<R>,
    rows: Range<usize>,
    work: Work<'a, R>,
}

impl<R: Real> Kernel<R> for Chunk<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let Self { matrix, rows, work } = self;
        match work {
            Work::Forward { b, x, r, settings } => {
                let Forward {
                    from_zero,
                    residual,
                } = settings;
                for i in rows {
                    matrix.ask(i + ROWS_AHEAD);
                    // SAFETY: rows before i, and i itself, are written by this task alone meanwhile.
                    let sum = matrix.row_times::<L>(i, |j| unsafe { x.triple(j) });
                    let known = match from_zero {
                        true => [R::zero(); 3],
                        // SAFETY: as above.
                        false => unsafe { triple(r, i) },
                    };
                    let left: [R; 3] = std::array::from_fn(|c| b[3 * i + c] + known[c] - sum[c]);
                    let x_i = times(&matrix.inverse[i], &left);
                    let start = match residual {
                        true => known.map(|v| R::zero() - v),
                        false => [R::zero(); 3],
                    };
                    // SAFETY: as above.
                    unsafe {
                        x.set(i, x_i);
                        r.set(i, start);
                        matrix.add_column(i, x_i.map(|v| -v), r);
                    }
                }
            }
            Work::Backward { b, x, s } => {
                for i in rows.rev() {
                    matrix.ask(i.saturating_sub(ROWS_AHEAD));
                    // SAFETY: rows before i, and i itself, are written by this task alone meanwhile.
                    let sum = matrix.row_times::<L>(i, |j| unsafe { x.triple(j) });
                    // SAFETY: as above.
                    unsafe {
                        let known = triple(s, i);
                        let left = std::array::from_fn(|c| b[3 * i + c] + known[c] - sum[c]);
                        let x_i = times(&matrix.inverse[i], &left);
                        x.set(i, x_i);
                        matrix.add_column(i, x_i.map(|v| -v), s);
                    }
                }
            }
            Work::Product { alpha, x, y } => {
                for i in rows {
                    matrix.ask(i + ROWS_AHEAD);
                    let x_i = [x[3 * i], x[3 * i + 1], x[3 * i + 2]];
                    let own = times(&matrix.diagonal[i], &x_i);
                    let sum = matrix.row_times::<L>(i, |j| &x[3 * j..][..3]);
                    // SAFETY: rows before i, and i itself, are written by this task alone meanwhile.
                    unsafe {
                        let y_i = triple(y, i);
                        y.set(
                            i,
                            std::array::from_fn(|c| y_i[c] + alpha * (own[c] + sum[c])),
                        );
                        matrix.add_column(i, x_i.map(|v| alpha * v), y);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
