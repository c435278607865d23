//! Half of a symmetric matrix of 3×3 blocks, and products with it.
#![allow(unsafe_code, reason = "reads and writes of tasks that share no entry")]

use super::schedule::Schedule;
use super::sums::Sums;
use fracas_operators::Real;
use fracas_operators::shared::Shared;
use fracas_operators::simd::{CACHE_LINE, Kernel, Lanes, Level, prefetch};
use fracas_operators::small::{Matrix3, times};
use fracas_operators::sparse::Pattern;
use fracas_operators::vector::for_each_task;
use std::ops::Range;

/// Rows that are asked for ahead of their use, the same part of each: 3 KiB of f32 of a 3-D stiffness.
pub(super) const ROWS_AHEAD: usize = 6;

/// A symmetric matrix `A = L + D + Lᵀ` of 3×3 blocks, L what the schedule visits before a row.
///
/// Only L and D are stored. A task that holds row i of L adds `L_i x` to row i and `L_ijᵀ x_i` to the rows j before it, so that
/// a product reads each block once.
#[derive(Clone, Debug)]
pub(super) struct Half<R> {
    /// Of L; ascending columns.
    pub(super) pattern: Pattern,
    /// Of L; one more, zero, so that a register may be loaded from the start of any block.
    pub(super) blocks: Vec<Matrix3<R>>,
    pub(super) diagonal: Vec<Matrix3<R>>,
    pub(super) schedule: Schedule,
    pub(super) level: Level,
}

impl<R: Real> Half<R> {
    /// From L, with one block more than it has, zero, and D.
    pub(super) fn new(
        (pattern, blocks): (Pattern, Vec<Matrix3<R>>),
        diagonal: Vec<Matrix3<R>>,
        schedule: Schedule,
    ) -> Self {
        assert_eq!(blocks.len(), pattern.columns.len() + 1, "blocks of L");
        assert_eq!(diagonal.len(), pattern.rows(), "blocks of D");
        Self {
            pattern,
            blocks,
            diagonal,
            schedule,
            level: Level::best(),
        }
    }

    /// Block rows.
    pub(super) fn rows(&self) -> usize {
        self.diagonal.len()
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.pattern.bytes() + size_of_val(&*self.blocks) + size_of_val(&*self.diagonal)
    }

    /// Columns and blocks of a row of L.
    pub(super) fn before(&self, i: usize) -> impl Iterator<Item = (usize, &Matrix3<R>)> {
        let range = self.pattern.range(i);
        let columns = self.pattern.row(i).iter().map(|j| *j as usize);
        columns.zip(&self.blocks[range])
    }

    /// Flops of a product.
    pub(super) fn flops(&self) -> u64 {
        36 * self.pattern.columns.len() as u64 + 18 * self.rows() as u64
    }

    /// `y ← y + α A x`.
    pub(super) fn apply_add(&self, alpha: R, x: &[R], y: &mut [R]) {
        assert!(x.len() == 3 * self.rows() && y.len() == x.len());
        let y = &Shared::new(y);
        self.visit(false, |rows| {
            self.level.run(Product {
                half: self,
                rows,
                alpha,
                x,
                y,
            });
        });
    }

    /// Every chunk of rows, colour after colour, in the order of a sweep; those of one colour share neither a row nor a column.
    #[inline(always)]
    pub(super) fn visit(&self, backward: bool, work: impl Fn(Range<usize>) + Sync) {
        let groups = self.schedule.groups();
        for k in 0..groups.len() {
            let group = &groups[if backward { groups.len() - 1 - k } else { k }];
            for_each_task(0..group.len(), &|k| work(self.schedule.chunk(group[k])));
        }
    }

    /// Asks for the blocks of a row that is wanted soon.
    #[inline(always)]
    pub(super) fn ask(&self, soon: usize) {
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
    pub(super) fn row_times<'x, L: Lanes<R>>(
        &self,
        i: usize,
        x: impl Fn(usize) -> &'x [R],
    ) -> [R; 3] {
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
    pub(super) unsafe fn add_column(&self, i: usize, x: [R; 3], y: &Shared<'_, R>) {
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

/// The three entries of a block row.
///
/// # Safety
/// As [`Shared::triple`].
#[inline(always)]
pub(super) unsafe fn triple<R: Real>(x: &Shared<'_, R>, row: usize) -> [R; 3] {
    // SAFETY: by contract.
    let x = unsafe { x.triple(row) };
    [x[0], x[1], x[2]]
}

/// One chunk of rows of a product.
///
/// It writes its rows and those that its rows of L reach; chunks of one colour share none of these.
struct Product<'a, R> {
    half: &'a Half<R>,
    rows: Range<usize>,
    alpha: R,
    x: &'a [R],
    y: &'a Shared<'a, R>,
}

impl<R: Real> Kernel<R> for Product<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let Self {
            half,
            rows,
            alpha,
            x,
            y,
        } = self;
        for i in rows {
            half.ask(i + ROWS_AHEAD);
            let x_i = [x[3 * i], x[3 * i + 1], x[3 * i + 2]];
            let own = times(&half.diagonal[i], &x_i);
            let sum = half.row_times::<L>(i, |j| &x[3 * j..][..3]);
            // SAFETY: rows before i, and i itself, are written by this task alone meanwhile.
            unsafe {
                let y_i = triple(y, i);
                y.set(
                    i,
                    std::array::from_fn(|c| y_i[c] + alpha * (own[c] + sum[c])),
                );
                half.add_column(i, x_i.map(|v| alpha * v), y);
            }
        }
    }
}

/// Leaves of every row, in their memory, the entries (row, column) that are to stay; their number. Columns of the rest are given back, values
/// are left to the caller.
pub(super) fn retain<V: Copy>(
    (offsets, columns): (&mut [usize], &mut Vec<u32>),
    values: &mut [V],
    stays: impl Fn(usize, usize) -> bool,
) -> usize {
    let (mut end, mut from) = (0, offsets[0]);
    for i in 0..offsets.len() - 1 {
        let to = offsets[i + 1];
        for k in from..to {
            if stays(i, columns[k] as usize) {
                (columns[end], values[end]) = (columns[k], values[k]);
                end += 1;
            }
        }
        from = to;
        offsets[i + 1] = end;
    }
    columns.truncate(end);
    columns.shrink_to_fit();
    end
}
