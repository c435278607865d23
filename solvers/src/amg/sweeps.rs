//! Gauss–Seidel sweeps and products with half a symmetric matrix of 3×3 blocks.
#![allow(unsafe_code, reason = "reads and writes of tasks that share no entry")]

use super::half::{Half, ROWS_AHEAD, retain, triple};
use super::matrix::{NodeMatrix, block_times};
use super::schedule::Schedule;
use fracas_operators::shared::Shared;
use fracas_operators::simd::{Kernel, Lanes};
use fracas_operators::small::{Matrix3, cast, times};
use fracas_operators::sparse::Pattern;
use fracas_operators::{LinearOperator, Real, Shape};
use rayon::prelude::*;
use std::ops::Range;

/// A symmetric matrix by half of its blocks, and its inverse diagonal blocks: sweeps and the residuals behind them read each block
/// once, as products do.
#[derive(Clone, Debug)]
pub(super) struct Sweeps<R> {
    half: Half<R>,
    /// D⁻¹.
    inverse: Vec<Matrix3<R>>,
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
            half: Half::new((pattern, blocks), each(NodeMatrix::diagonal), schedule),
            inverse: each(NodeMatrix::inverse),
        }
    }

    /// L and D of a matrix in its own memory, what is left over given back.
    pub(super) fn of(a: NodeMatrix<R>) -> Self {
        let schedule = Schedule::new(&a.pattern().offsets, &a.pattern().columns);
        let diagonal = (0..a.rows()).into_par_iter();
        let diagonal = diagonal.map(|i| *a.diagonal(i)).collect();
        let (mut pattern, mut blocks, inverse) = a.into_parts();
        let Pattern { offsets, columns } = &mut pattern;
        let before = |i, j| schedule.before(j, i);
        let end = retain((offsets, columns), &mut blocks, before);
        blocks[end] = [[R::zero(); 3]; 3];
        blocks.truncate(end + 1);
        blocks.shrink_to_fit();
        Self {
            half: Half::new((pattern, blocks), diagonal, schedule),
            inverse,
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
        self.half.bytes() + size_of_val(&*self.inverse)
    }

    /// Flops of one sweep with what it leaves: a product with L and Lᵀ and one with D⁻¹.
    pub(super) fn sweep_flops(&self) -> u64 {
        36 * self.half.pattern.columns.len() as u64 + 21 * self.rows() as u64
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
        block_times(&self.inverse, r, z);
    }

    /// Every chunk of rows, colour after colour, in the order of a sweep.
    fn visit(&self, backward: bool, work: Work<'_, R>) {
        self.half.visit(backward, |rows| {
            self.half.level.run(Chunk {
                matrix: self,
                rows,
                work,
            });
        });
    }
}

impl<R: Real> LinearOperator<R> for Sweeps<R> {
    fn shape(&self) -> Shape {
        Shape::square(3 * self.rows())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        self.half.apply_add(alpha, x, y);
    }

    fn flops(&self) -> u64 {
        self.half.flops()
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
        let half = &matrix.half;
        match work {
            Work::Forward { b, x, r, settings } => {
                let Forward {
                    from_zero,
                    residual,
                } = settings;
                for i in rows {
                    half.ask(i + ROWS_AHEAD);
                    // SAFETY: rows before i, and i itself, are written by this task alone meanwhile.
                    let sum = half.row_times::<L>(i, |j| unsafe { x.triple(j) });
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
                        half.add_column(i, x_i.map(|v| -v), r);
                    }
                }
            }
            Work::Backward { b, x, s } => {
                for i in rows.rev() {
                    half.ask(i.saturating_sub(ROWS_AHEAD));
                    // SAFETY: rows before i, and i itself, are written by this task alone meanwhile.
                    let sum = half.row_times::<L>(i, |j| unsafe { x.triple(j) });
                    // SAFETY: as above.
                    unsafe {
                        let known = triple(s, i);
                        let left = std::array::from_fn(|c| b[3 * i + c] + known[c] - sum[c]);
                        let x_i = times(&matrix.inverse[i], &left);
                        x.set(i, x_i);
                        half.add_column(i, x_i.map(|v| -v), s);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
