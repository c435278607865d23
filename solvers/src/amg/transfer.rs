//! P and Pᵀ between two levels.

use crate::multigrid;
use fracas_operators::Real;
use fracas_operators::simd::{Kernel, Lanes, Level, MAX_WIDTH};
use fracas_operators::sparse::{Pattern, Transposed};
use fracas_operators::vector::for_row_ranges;
use rayon::prelude::*;
use std::sync::Arc;

/// Block rows, or coarse nodes, that one task computes.
const ROWS_PER_TASK: usize = 256;

/// Where P has blocks; outlives changes of values.
#[derive(Clone, Debug)]
pub(super) struct TransferPattern {
    /// Coarse nodes of every block row.
    pub(super) p: Pattern,
    /// Block rows of every coarse node.
    pub(super) transposed: Transposed,
}

impl TransferPattern {
    /// For `count` coarse nodes.
    pub(super) fn new(p: Pattern, count: usize) -> Self {
        assert!(u32::try_from(p.columns.len()).is_ok(), "blocks of P");
        let transposed = p.transposed(count);
        Self { p, transposed }
    }

    pub(super) fn bytes(&self) -> usize {
        self.p.bytes() + self.transposed.bytes()
    }
}

/// Prolongation and restriction by 3×K blocks, K unknowns per coarse node.
#[derive(Clone, Debug)]
pub(super) struct Transfer<R> {
    pattern: Arc<TransferPattern>,
    /// The blocks of P, each row-major; padded.
    values: Vec<R>,
    /// The same blocks in the order of Pᵀ: a restriction that picked them from P would read twice the cache lines.
    transposed: Vec<R>,
    /// K: 3 or 6.
    width: usize,
    level: Level,
}

impl<R: Real> Transfer<R> {
    /// P by its blocks.
    pub(super) fn new<const K: usize>(
        pattern: Arc<TransferPattern>,
        blocks: Vec<[[R; K]; 3]>,
    ) -> Self {
        assert_eq!(blocks.len(), pattern.p.columns.len(), "blocks of P");
        let entries = pattern.transposed.entries().par_iter();
        let transposed = entries.map(|(_, at)| blocks[*at as usize]).collect();
        let padded = |blocks: Vec<[[R; K]; 3]>| {
            let mut values = blocks.into_flattened().into_flattened();
            values.extend([R::zero(); MAX_WIDTH]);
            values
        };
        Self {
            pattern,
            values: padded(blocks),
            transposed: padded(transposed),
            width: K,
            level: Level::best(),
        }
    }

    fn restrict_by<const K: usize>(&self, r: &[R], coarse: &mut [R]) {
        let values = &self.transposed[..];
        let pattern = &self.pattern.transposed;
        assert!(r.len() == 3 * self.pattern.p.rows() && coarse.len() == K * pattern.rows());
        for_row_ranges(0, K * ROWS_PER_TASK, coarse, &|start, coarse| {
            let first = start / K;
            self.level.run(Restrict::<R, K> {
                pattern,
                values,
                first,
                r,
                coarse,
            });
        });
    }

    fn prolong_by<const K: usize, const ADD: bool>(&self, coarse: &[R], x: &mut [R]) {
        let values = &self.values[..];
        let pattern = &self.pattern.p;
        let count = self.pattern.transposed.rows();
        assert!(x.len() == 3 * pattern.rows() && coarse.len() == K * count);
        for_row_ranges(0, 3 * ROWS_PER_TASK, x, &|start, x| {
            let first = start / 3;
            self.level.run(Prolong::<R, K, ADD> {
                pattern,
                values,
                first,
                coarse,
                x,
            });
        });
    }
}

impl<R: Real> multigrid::Transfer<R> for Transfer<R> {
    fn coarse_len(&self) -> usize {
        self.width * self.pattern.transposed.rows()
    }

    fn restrict(&self, r: &[R], coarse: &mut [R]) {
        match self.width {
            3 => self.restrict_by::<3>(r, coarse),
            6 => self.restrict_by::<6>(r, coarse),
            k => unreachable!("{k} unknowns per coarse node"),
        }
    }

    fn prolong(&self, coarse: &[R], x: &mut [R]) {
        match self.width {
            3 => self.prolong_by::<3, false>(coarse, x),
            6 => self.prolong_by::<6, false>(coarse, x),
            k => unreachable!("{k} unknowns per coarse node"),
        }
    }

    fn prolong_add(&self, coarse: &[R], x: &mut [R]) {
        match self.width {
            3 => self.prolong_by::<3, true>(coarse, x),
            6 => self.prolong_by::<6, true>(coarse, x),
            k => unreachable!("{k} unknowns per coarse node"),
        }
    }

    fn flops(&self) -> u64 {
        12 * (self.width * self.pattern.p.columns.len()) as u64
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.transposed) + self.pattern.bytes()
    }
}

/// Registers that hold a row of a block.
const fn registers<const K: usize>(width: usize) -> usize {
    K.div_ceil(width)
}

/// Most of them: six entries in registers of two.
const MOST_REGISTERS: usize = 3;

/// `b_J = Σ_i P_iJᵀ r_i` for consecutive coarse nodes J.
struct Restrict<'a, R, const K: usize> {
    pattern: &'a Transposed,
    /// Padded, so that a register may be loaded from the start of any row of a block.
    values: &'a [R],
    first: usize,
    r: &'a [R],
    coarse: &'a mut [R],
}

impl<R: Real, const K: usize> Kernel<R> for Restrict<'_, R, K> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let registers = registers::<K>(L::WIDTH);
        let mut lanes = [R::zero(); MOST_REGISTERS * MAX_WIDTH];
        for (k, target) in self.coarse.chunks_exact_mut(K).enumerate() {
            let mut sums = [L::splat(R::zero()); MOST_REGISTERS];
            for at in self.pattern.range(self.first + k) {
                let r = &self.r[3 * self.pattern.entries()[at].0 as usize..][..3];
                for a in 0..3 {
                    let row = (3 * at + a) * K;
                    let r = L::splat(r[a]);
                    for v in 0..registers {
                        sums[v] = L::load(&self.values[row + v * L::WIDTH..]).mul_add(r, sums[v]);
                    }
                }
            }
            for v in 0..registers {
                sums[v].store(&mut lanes[v * L::WIDTH..]);
            }
            target.copy_from_slice(&lanes[..K]);
        }
    }
}

/// `x_i ← Σ_J P_iJ x_J`, or `x_i ← x_i + Σ_J P_iJ x_J` if `ADD`, for consecutive block rows i.
struct Prolong<'a, R, const K: usize, const ADD: bool> {
    pattern: &'a Pattern,
    /// Padded, so that a register may be loaded from the start of any row of a block.
    values: &'a [R],
    first: usize,
    coarse: &'a [R],
    x: &'a mut [R],
}

impl<R: Real, const K: usize, const ADD: bool> Kernel<R> for Prolong<'_, R, K, ADD> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let offsets = &self.pattern.offsets;
        let registers = registers::<K>(L::WIDTH);
        let mut lanes = [R::zero(); MOST_REGISTERS * MAX_WIDTH];
        let mut last = [R::zero(); MOST_REGISTERS * MAX_WIDTH];
        for (k, target) in self.x.chunks_exact_mut(3).enumerate() {
            let i = self.first + k;
            let mut sums = [[L::splat(R::zero()); MOST_REGISTERS]; 3];
            for at in offsets[i]..offsets[i + 1] {
                let mut coarse = &self.coarse[K * self.pattern.columns[at] as usize..];
                if coarse.len() < registers * L::WIDTH {
                    last[..K].copy_from_slice(&coarse[..K]);
                    coarse = &last;
                }
                for v in 0..registers {
                    let x = L::load(&coarse[v * L::WIDTH..]);
                    for a in 0..3 {
                        let row = (3 * at + a) * K + v * L::WIDTH;
                        sums[a][v] = L::load(&self.values[row..]).mul_add(x, sums[a][v]);
                    }
                }
            }
            for a in 0..3 {
                for v in 0..registers {
                    sums[a][v].store(&mut lanes[v * L::WIDTH..]);
                }
                let mut sum = R::zero();
                for c in 0..K {
                    sum += lanes[c];
                }
                target[a] = if ADD { target[a] + sum } else { sum };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multigrid::Transfer as _;
    use fracas_operators::laws::probe;

    /// Seven block rows, four coarse nodes: an empty row, a coarse node that nothing takes from, the last one alone in a row.
    fn pattern() -> Arc<TransferPattern> {
        let rows: [&[u32]; 7] = [&[0, 1], &[0], &[], &[0, 1, 3], &[3], &[1, 3], &[0]];
        let mut p = Pattern {
            offsets: vec![0],
            columns: Vec::new(),
        };
        for row in rows {
            p.columns.extend(row);
            p.offsets.push(p.columns.len());
        }
        Arc::new(TransferPattern::new(p, 4))
    }

    /// Both transfers against plain loops in f64; the unused coarse node holds NaN.
    fn check<R: Real, const K: usize>(level: Level) {
        let pattern = pattern();
        let entries = pattern.p.columns.len();
        let values = probe::<f64>(3 * K * entries, 5);
        let value = |at: usize, r: usize, c: usize| values[(3 * at + r) * K + c];
        let blocks = (0..entries)
            .map(|at| std::array::from_fn(|r| std::array::from_fn(|c| R::of(value(at, r, c)))))
            .collect();
        let transfer = Transfer {
            level,
            ..Transfer::<R>::new::<K>(pattern.clone(), blocks)
        };
        let (r, x) = (probe::<f64>(21, 1), probe::<f64>(4 * K, 2));
        let (mut down, mut up) = (vec![0.0; 4 * K], r.clone());
        for i in 0..7 {
            for at in pattern.p.offsets[i]..pattern.p.offsets[i + 1] {
                let j = pattern.p.columns[at] as usize;
                for a in 0..3 {
                    for c in 0..K {
                        down[K * j + c] += value(at, a, c) * r[3 * i + a];
                        up[3 * i + a] += value(at, a, c) * x[K * j + c];
                    }
                }
            }
        }
        let cast = |v: &[f64]| v.iter().map(|v| R::of(*v)).collect::<Vec<R>>();
        let mut coarse = cast(&x);
        transfer.restrict(&cast(&r), &mut coarse);
        let near = |found: &[R], exact: &[f64]| {
            found
                .iter()
                .zip(exact)
                .all(|(f, e)| (f.to_f64_exact() - e).abs() <= 30.0 * R::epsilon().to_f64_exact())
        };
        assert!(near(&coarse, &down), "Pᵀ, K = {K}, {level:?}");
        let mut coarse = cast(&x);
        coarse[2 * K..3 * K].fill(R::nan());
        let mut fine = cast(&r);
        transfer.prolong_add(&coarse, &mut fine);
        assert!(near(&fine, &up), "P, K = {K}, {level:?}");
        let mut written = vec![R::nan(); r.len()];
        transfer.prolong(&coarse, &mut written);
        let added = written.iter().zip(&r).map(|(p, r)| R::of(*r) + *p);
        assert_eq!(added.collect::<Vec<R>>(), fine);
    }

    #[test]
    fn both_transfers_are_those_of_plain_loops_on_every_instruction_set() {
        for level in Level::supported() {
            check::<f32, 3>(level);
            check::<f32, 6>(level);
            check::<f64, 3>(level);
            check::<f64, 6>(level);
        }
    }
}
