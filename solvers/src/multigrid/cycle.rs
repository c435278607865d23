//! V, W and K cycles.

use super::bottom::Bottom;
use super::level::{Chebyshev, Level};
use crate::amg::{LevelSummary, Smoother, Smoothing, Summary};
use fracas_operators::Real;
use fracas_operators::vector::{axpby, axpy, dot};
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
    /// As a preconditioner of two steps of flexible conjugate gradients: not a linear map.
    K,
}

/// How one level visits the next one.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Visit {
    Once,
    Twice,
    /// Two steps of flexible conjugate gradients.
    TwoSteps,
}

impl Visit {
    /// Vectors of the next level's length: its b and x, and what a second visit needs.
    fn vectors(self) -> usize {
        match self {
            Self::Once => 2,
            Self::Twice => 3,
            Self::TwoSteps => 5,
        }
    }
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

    /// How level k visits the next one; a solver needs no second visit.
    fn visiting(&self, k: usize) -> Visit {
        match self.cycle {
            _ if k + 1 >= self.levels.len() => Visit::Once,
            Cycle::V => Visit::Once,
            Cycle::VThenW if k == 0 => Visit::Once,
            Cycle::VThenW | Cycle::W => Visit::Twice,
            Cycle::K => Visit::TwoSteps,
        }
    }

    /// True if `M⁻¹` is a linear map.
    pub(super) fn is_linear(&self) -> bool {
        let mut visits = (0..self.levels.len()).map(|k| self.visiting(k));
        self.bottom.is_linear() && visits.all(|visit| visit != Visit::TwoSteps)
    }

    /// Scratch entries of a cycle.
    pub(super) fn work_len(&self) -> usize {
        let below = |k: usize| self.visiting(k).vectors() * self.size(k + 1);
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
        self.visit(self.visiting(k), k + 1, r_c, x_c, work);
        // x ← x + P x_c
        level.transfer.prolong(x_c, d);
        level.clear_fixed(d);
        level.correct(d, x, r, work);
        level.smooth::<false>(self.smoothing, x, r, d, work);
        if residual {
            level.subtract_product(d, r, work);
        }
    }

    /// `x ≈ A⁻¹ b` on level k by one or two cycles; b arrives in r, which is destroyed.
    fn visit(&self, visit: Visit, k: usize, r: &mut [R], x: &mut [R], work: &mut [R]) {
        match visit {
            Visit::Once => self.cycle(k, r, x, work, false),
            Visit::Twice => {
                // x ← x + M⁻¹ (b − A x)
                let (d, work) = work.split_at_mut(r.len());
                self.cycle(k, r, x, work, true);
                self.cycle(k, r, d, work, false);
                axpy(R::one(), d, x);
            }
            Visit::TwoSteps => self.two_steps(k, r, x, work),
        }
    }

    /// Two steps of flexible conjugate gradients on level k from x = 0, preconditioned by its cycle; b arrives in r, which is
    /// destroyed. Products with A are differences of residuals, which the cycles leave.
    ///
    /// # Source
    /// Notay & Vassilevski, Numer. Linear Algebra Appl. 15 (2008); both steps always, without their tolerance of ¼.
    fn two_steps(&self, k: usize, r: &mut [R], x: &mut [R], work: &mut [R]) {
        let n = r.len();
        let (q, work) = work.split_at_mut(n);
        let (d, work) = work.split_at_mut(n);
        let (s, work) = work.split_at_mut(n);
        // p = M⁻¹ b, in x;  q = A p = b − r
        q.copy_from_slice(r);
        self.cycle(k, r, x, work, true);
        let along = dot(x, q);
        axpy(-R::one(), r, q);
        let curvature = dot(x, q);
        let alpha = along / curvature;
        if !(curvature > R::zero() && alpha.is_finite()) {
            // b = 0, or beyond the range of R: the cycle as it is
            return;
        }
        // r ← b − α q, d = M⁻¹ r, A d = s − r
        axpy(R::one() - alpha, q, r);
        s.copy_from_slice(r);
        self.cycle(k, r, d, work, true);
        let slope = dot(d, s);
        axpy(-R::one(), r, s);
        // d − β p is conjugate to p
        let beta = dot(d, q) / curvature;
        let second = dot(d, s) - beta * beta * curvature;
        let step = slope / second;
        let step = match second > R::zero() && step.is_finite() {
            true => step,
            false => R::zero(),
        };
        // x = α p + step (d − β p)
        axpby(step, d, alpha - step * beta, x);
    }

    /// Flops of a cycle from level k down.
    pub(super) fn flops(&self, k: usize) -> u64 {
        let Some(level) = self.levels.get(k) else {
            return self.bottom.flops();
        };
        let below = self.flops(k + 1);
        // a cycle that leaves its residual has a product more
        let (product, n) = self
            .levels
            .get(k + 1)
            .map_or((0, 0), |next| (next.operator.flops(), next.size() as u64));
        let visit = match self.visiting(k) {
            Visit::Once => below,
            Visit::Twice => 2 * below + product + n,
            Visit::TwoSteps => 2 * (below + product) + 19 * n,
        };
        level.flops(self.smoothing.degree) + visit
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

#[cfg(test)]
mod tests;
