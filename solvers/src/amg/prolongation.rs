//! Smoothed prolongation.

use super::aggregation::Aggregates;
use super::node_map::NONE;
use super::rows::Pattern;
use super::sweeps::SweepMatrix;
use super::tentative::Tentative;
use fracas_operators::Real;
use fracas_operators::simd::{Kernel, Lanes, Level};

/// `ω λ_max(D⁻¹A)` of the prolongation smoother. Unit: 1. Source: Vaněk, Mandel, Brezina (1996).
const DAMPING: f64 = 4.0 / 3.0;

/// P: for every block row the aggregates it interpolates from, with 3×K blocks.
#[derive(Clone, Debug)]
pub(super) struct Prolongation<const K: usize> {
    /// Aggregates of every block row.
    pub(super) pattern: Pattern,
    /// One block per entry of the pattern.
    pub(super) blocks: Vec<[[f64; K]; 3]>,
}

impl<const K: usize> Prolongation<K> {
    /// Aggregates and blocks of a row.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, &[[f64; K]; 3])> {
        let range = self.pattern.offsets[i]..self.pattern.offsets[i + 1];
        self.pattern.columns[range.clone()]
            .iter()
            .map(|j| *j as usize)
            .zip(&self.blocks[range])
    }
}

/// The pattern of `A P_0`.
pub(super) fn pattern<R: Real>(
    a: &SweepMatrix<R>,
    group: usize,
    aggregates: &Aggregates,
) -> Pattern {
    Pattern::collect(
        a.rows(),
        || (),
        |i, (), columns| {
            let start = columns.len();
            for j in a.columns_of(i) {
                let aggregate = aggregates.of[*j as usize / group];
                // a handful of aggregates per row: a linear search is the fastest
                if aggregate != NONE && !columns[start..].contains(&aggregate) {
                    columns.push(aggregate);
                }
            }
            columns[start..].sort_unstable();
        },
    )
}

/// `P = (I − ω D⁻¹A) P_0`, `ω = 4/(3 λ_max(D⁻¹A))`, D the 3×3 diagonal blocks.
///
/// # Source
/// Vaněk, Mandel, Brezina, Computing 56 (1996).
pub(super) fn smoothed<R: Real, const K: usize>(
    a: &SweepMatrix<R>,
    group: usize,
    aggregates: &Aggregates,
    tentative: &Tentative<K>,
    pattern: Pattern,
    lambda_max: f64,
) -> Prolongation<K> {
    let omega = DAMPING / lambda_max;
    let mut blocks = vec![[[0.0; K]; 3]; pattern.columns.len()];
    let level = Level::best();
    pattern.fill(
        &mut blocks,
        || (),
        |rows, part, ()| {
            level.run::<f64>(Smooth {
                a,
                group,
                aggregates,
                tentative,
                pattern: &pattern,
                rows,
                omega,
                part,
            });
        },
    );
    Prolongation { pattern, blocks }
}

/// `P = P_0`.
pub(super) fn tentative<const K: usize>(
    group: usize,
    aggregates: &Aggregates,
    tentative: &Tentative<K>,
) -> Prolongation<K> {
    let rows = tentative.rows.len();
    let own = |i: usize| Some(aggregates.of[i / group]).filter(|aggregate| *aggregate != NONE);
    let pattern = Pattern::collect(rows, || (), |i, (), columns| columns.extend(own(i)));
    let blocks = (0..rows)
        .filter(|i| own(*i).is_some())
        .map(|i| tentative.rows[i])
        .collect();
    Prolongation { pattern, blocks }
}

struct Smooth<'a, R, const K: usize> {
    a: &'a SweepMatrix<R>,
    group: usize,
    aggregates: &'a Aggregates,
    tentative: &'a Tentative<K>,
    pattern: &'a Pattern,
    rows: std::ops::Range<usize>,
    omega: f64,
    part: &'a mut [[[f64; K]; 3]],
}

impl<R: Real, const K: usize> Kernel<f64> for Smooth<'_, R, K> {
    #[inline(always)]
    fn run<L: Lanes<f64>>(self) {
        let start = self.pattern.offsets[self.rows.start];
        for i in self.rows {
            let range = self.pattern.offsets[i]..self.pattern.offsets[i + 1];
            let columns = &self.pattern.columns[range.clone()];
            let blocks = &mut self.part[range.start - start..range.end - start];
            // A P_0
            for (j, a_ij) in self.a.row(i) {
                let aggregate = self.aggregates.of[j / self.group];
                if let Some(k) = columns.iter().position(|c| *c == aggregate) {
                    add_product(&mut blocks[k], a_ij, &self.tentative.rows[j]);
                }
            }
            // P_0 − ω D⁻¹ (A P_0)
            let scaled = self.a.inverse(i).map(|v| -self.omega * v.to_f64_exact());
            for block in blocks.iter_mut() {
                let image = *block;
                *block = [[0.0; K]; 3];
                add_product(block, &scaled, &image);
            }
            let own = self.aggregates.of[i / self.group];
            if let Some(k) = columns.iter().position(|c| *c == own) {
                for (row, q) in blocks[k].iter_mut().zip(&self.tentative.rows[i]) {
                    row.iter_mut().zip(q).for_each(|(p, q)| *p += q);
                }
            }
        }
    }
}

/// `y ← y + A x` for a row-major 3×3 block A and 3×K blocks x, y.
#[inline(always)]
pub(super) fn add_product<R: Real, const K: usize>(
    y: &mut [[f64; K]; 3],
    a: &[R; 9],
    x: &[[f64; K]; 3],
) {
    for r in 0..3 {
        for k in 0..3 {
            let a_rk = a[3 * r + k].to_f64_exact();
            for c in 0..K {
                y[r][c] += a_rk * x[k][c];
            }
        }
    }
}
