//! V and W cycles.

use super::bottom::Bottom;
use super::level::{Chebyshev, Level};
use crate::amg::{LevelSummary, Smoother, Smoothing, Summary};
use fracas_operators::Real;
use fracas_operators::vector::axpy;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How often a level visits the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cycle {
    /// Once.
    V,
    /// Once the finest, every coarse level twice: the work of V and a few percent, for levels that shrink to an eighth.
    #[default]
    VThenW,
    /// Twice.
    W,
}

/// All levels, finest first, and the solver below them.
pub struct Hierarchy<R> {
    levels: Vec<Level<R>>,
    bottom: Bottom,
    cycle: Cycle,
    smoothing: Chebyshev,
}

impl<R: Real> Hierarchy<R> {
    /// A cycle that smooths by the same polynomial on every level.
    pub fn new(levels: Vec<Level<R>>, bottom: Bottom, cycle: Cycle, smoothing: Chebyshev) -> Self {
        assert!(smoothing.degree > 0, "a smoother smooths");
        assert!(!levels.is_empty(), "a hierarchy has a finest level");
        for (k, level) in levels.iter().enumerate() {
            let below = levels.get(k + 1).map_or(bottom.size(), Level::size);
            assert_eq!(level.transfer.coarse_len(), below, "level {k}");
        }
        Self {
            levels,
            bottom,
            cycle,
            smoothing,
        }
    }

    /// The levels that smooth, finest first.
    pub fn levels(&self) -> &[Level<R>] {
        &self.levels
    }

    /// Unknowns of level k, the coarsest included.
    fn size(&self, k: usize) -> usize {
        self.levels.get(k).map_or(self.bottom.size(), Level::size)
    }

    /// True if level k visits the next one twice; a direct solver below it needs no second visit.
    fn twice(&self, k: usize) -> bool {
        let asked = match self.cycle {
            Cycle::V => false,
            Cycle::VThenW => k > 0,
            Cycle::W => true,
        };
        asked && k + 1 < self.levels.len()
    }

    /// Scratch entries of a cycle.
    pub(super) fn work_len(&self) -> usize {
        // what comes down and what goes up, once more where it does so twice
        let below = |k: usize| (2 + usize::from(self.twice(k))) * self.size(k + 1);
        let vectors: usize = (0..self.levels.len())
            .map(|k| self.size(k) + below(k))
            .sum();
        let products = self.levels.iter().map(|level| level.operator.work_len());
        let below = products.max().unwrap_or(0).max(self.bottom.work_len::<R>());
        vectors + below
    }

    /// `x ← M⁻¹ b` on the finest level; b arrives in r, which is destroyed.
    pub(super) fn solve(&self, r: &mut [R], x: &mut [R], work: &mut [R]) {
        self.cycle(0, r, x, work, false);
    }

    /// `x ← M⁻¹ b` from level k down; b arrives in r, which leaves as `b − A x` if `residual`, else destroyed.
    fn cycle(&self, k: usize, r: &mut [R], x: &mut [R], work: &mut [R], residual: bool) {
        let Some(level) = self.levels.get(k) else {
            return self.bottom.solve(r, x, work);
        };
        let (d, work) = work.split_at_mut(level.size());
        let m = self.size(k + 1);
        let (r_c, work) = work.split_at_mut(m);
        let (x_c, work) = work.split_at_mut(m);
        // x ← p(D⁻¹A) D⁻¹ b,  r ← b − A x
        level.smooth::<true>(self.smoothing, x, r, d, work);
        level.subtract_product(d, r, work);
        level.clear_fixed(r);
        // x_c ≈ A_c⁻¹ Pᵀ r
        level.transfer.restrict(r, r_c);
        let twice = self.twice(k);
        self.cycle(k + 1, r_c, x_c, work, twice);
        if twice {
            let (d_c, work) = work.split_at_mut(m);
            self.cycle(k + 1, r_c, d_c, work, false);
            axpy(R::one(), d_c, x_c);
        }
        // x ← x + P x_c
        level.transfer.prolong(x_c, d);
        level.clear_fixed(d);
        level.correct(d, x, r, work);
        level.smooth::<false>(self.smoothing, x, r, d, work);
        if residual {
            level.subtract_product(d, r, work);
        }
    }

    /// Flops of a cycle from level k down.
    pub(super) fn flops(&self, k: usize) -> u64 {
        let Some(level) = self.levels.get(k) else {
            return self.bottom.flops();
        };
        let below = self.flops(k + 1);
        let visits = if self.twice(k) { 2 } else { 1 };
        level.flops(self.smoothing.degree) + visits * below
    }

    /// Levels and memory; `nnz` counts half the flops of a product, which is the stored entries where there are any.
    pub(super) fn summary(&self, below: &Summary, spaces: &'static str) -> Summary {
        let smoothing = self.levels.iter().map(|level| LevelSummary {
            n: level.size() - level.fixed.len(),
            nnz: level.operator.flops() as usize / 2,
            bytes: level.total_bytes(),
        });
        let levels: Vec<LevelSummary> = smoothing.chain(below.levels.iter().copied()).collect();
        let total = |of: fn(&LevelSummary) -> usize| {
            levels.iter().map(of).sum::<usize>() as f64 / of(&levels[0]).max(1) as f64
        };
        Summary {
            operator_complexity: total(|level| level.nnz),
            grid_complexity: total(|level| level.n),
            near_null_space: spaces,
            smoothing: Smoothing {
                smoother: Smoother::Chebyshev,
                chained: None,
            },
            levels,
        }
    }
}
