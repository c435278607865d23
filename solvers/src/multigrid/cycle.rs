//! V, W and K cycles.

use super::bottom::Bottom;
use super::level::Level;
use super::smooth::Hand;
use super::step_length::step;
use super::{LevelSummary, Smoothing, Summary};
use fracas_operators::vector::{axpby, axpy, dot, scale};
use fracas_operators::{Properties, Real};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How often a level visits the next one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Cycle {
    /// Once.
    V,
    /// Once the finest, coarse levels twice: the work of V and a few percent for levels that shrink to an eighth. Where levels shrink
    /// slowly some of them once, so that the unknowns visited fall by a quarter per level at least.
    #[default]
    VThenW,
    /// Twice.
    W,
    /// As a preconditioner of two steps of flexible conjugate gradients: not a linear map, where there are three levels or more.
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

/// Share of the unknowns visited that may remain from level to level. Where levels shrink to 0.45 each (`inclined_crack`,
/// `line_crack`, `penny_crack`, every cell of an axis counted by itself) 38, 30, 17 iterations; without a bound 32, 29, 17 in
/// twice the time, with 0.6 44, 36, 17 in the same. Unit: 1.
const REMAINING: f64 = 0.75;

/// How every level visits the next one, where these are the unknowns of the levels and of the solver below them, which needs no
/// second visit.
fn visits(cycle: Cycle, sizes: &[usize]) -> Vec<Visit> {
    // unknowns visited on the next level, and how many may be, over its size and that of level 1
    let (mut times, mut bound) = (1.0, 1.0);
    let levels = sizes.len() - 1;
    let visit = |k: usize| {
        if k > 0 {
            bound *= REMAINING;
        }
        let affords = || 2.0 * times * sizes[k + 1] as f64 <= bound * sizes[1] as f64;
        let visit = match cycle {
            _ if k + 1 == levels => Visit::Once,
            Cycle::V => Visit::Once,
            Cycle::VThenW if k == 0 || !affords() => Visit::Once,
            Cycle::VThenW | Cycle::W => Visit::Twice,
            Cycle::K => Visit::TwoSteps,
        };
        if visit != Visit::Once {
            times *= 2.0;
        }
        visit
    };
    (0..levels).map(visit).collect()
}

/// All levels, finest first, and the solver below them.
pub struct Hierarchy<R> {
    levels: Vec<Level<R>>,
    bottom: Bottom<R>,
    /// How every level visits the next one.
    visits: Vec<Visit>,
    about: About,
}

/// What a hierarchy says of itself.
#[derive(Clone, Copy, Debug)]
pub struct About {
    /// What the coarse spaces reproduce.
    pub near_null_space: &'static str,
    /// What smooths, and why.
    pub smoothing: Smoothing,
}

impl<R: Real> Hierarchy<R> {
    /// Levels, each the next one of the one before, and the solver of what is below them.
    pub fn new(levels: Vec<Level<R>>, bottom: Bottom<R>, cycle: Cycle, about: About) -> Self {
        let mut sizes: Vec<usize> = levels.iter().map(Level::size).collect();
        sizes.push(bottom.size());
        for (k, level) in levels.iter().enumerate() {
            assert_eq!(level.transfer().coarse_len(), sizes[k + 1], "level {k}");
        }
        Self {
            levels,
            bottom,
            visits: visits(cycle, &sizes),
            about,
        }
    }

    /// The levels that smooth, finest first.
    pub fn levels(&self) -> &[Level<R>] {
        &self.levels
    }

    /// The solver below them.
    pub(super) fn bottom(&self) -> &Bottom<R> {
        &self.bottom
    }

    /// Unknowns of level k, the coarsest included.
    pub(super) fn size(&self, k: usize) -> usize {
        self.levels.get(k).map_or(self.bottom.size(), Level::size)
    }

    /// Components of the finest level that are no unknowns, ascending.
    pub(super) fn fixed(&self) -> &[u32] {
        self.levels.first().map_or(&[], Level::fixed)
    }

    /// Those of a cycle in exact arithmetic.
    pub(super) fn properties(&self) -> Properties {
        let cycle = if self.visits.contains(&Visit::TwoSteps) {
            Properties::NONLINEAR
        } else {
            Properties::LINEAR
        };
        cycle.and(self.bottom.properties())
    }

    /// Scratch entries of a cycle.
    pub(super) fn work_len(&self) -> usize {
        let below = |k: usize| self.visits[k].vectors() * self.size(k + 1);
        let own = |(k, level): (usize, &Level<R>)| level.smoother().own_len() + below(k);
        let vectors: usize = self.levels.iter().enumerate().map(own).sum();
        let products = self.levels.iter().map(|level| level.operator().work_len());
        vectors + products.fold(self.bottom.work_len(), usize::max)
    }

    /// `x ← M⁻¹ b` on the finest level; b arrives in r, which is destroyed.
    pub(super) fn solve(&self, r: &mut [R], x: &mut [R], work: &mut [R]) {
        self.cycle(0, r, x, work, false);
    }

    /// `x ← M⁻¹ b` from level k down; b leaves as `b − A x` if `residual`, else destroyed.
    fn cycle(&self, k: usize, b: &mut [R], x: &mut [R], work: &mut [R], residual: bool) {
        let Some(level) = self.levels.get(k) else {
            return self.bottom.solve(b, x, work);
        };
        let smoother = level.smoother();
        let (own, work) = work.split_at_mut(smoother.own_len());
        let m = self.size(k + 1);
        let (b_c, work) = work.split_at_mut(m);
        let (x_c, work) = work.split_at_mut(m);
        // x ← S b,  x_c ≈ A_c⁻¹ Pᵀ(b − A x)
        let mut hand = Hand { b, x, own, work };
        level.restrict(smoother.before(&mut hand), b_c);
        self.visit(self.visits[k], k + 1, b_c, x_c, hand.work);
        // x ← x + P x_c,  x ← x + Sᵀ(b − A x)
        smoother.after(&level.correction(x_c), &mut hand, residual);
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
    /// Notay & Vassilevski, Numer. Linear Algebra Appl. 15 (2008); both steps always, without their tolerance of ¼, and
    /// the bound on [`step`] is ours.
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
        let Some(alpha) = step(along, curvature) else {
            // b = 0, or beyond the range of R: the cycle as it is
            return;
        };
        // r ← b − α q,  d = M⁻¹ r,  A d = s − r
        axpy(R::one() - alpha, q, r);
        s.copy_from_slice(r);
        self.cycle(k, r, d, work, true);
        let slope = dot(d, s);
        axpy(-R::one(), r, s);
        // d − β p is conjugate to p, along which a step that was cut short leaves pᵀ(b − α q)
        let beta = dot(d, q) / curvature;
        let slope = slope - beta * (along - alpha * curvature);
        let second = dot(d, s) - beta * beta * curvature;
        // x = α p + (d − β p) · step
        match step(slope, second) {
            Some(step) => axpby(step, d, alpha - step * beta, x),
            None => scale(alpha, x),
        }
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
            .map_or((0, 0), |next| (next.operator().flops(), next.size() as u64));
        let visit = match self.visits[k] {
            Visit::Once => below,
            Visit::Twice => 2 * (below + n) + product,
            Visit::TwoSteps => 2 * (below + product) + 19 * n,
        };
        level.flops() + visit
    }

    /// Levels and memory; `nnz` counts half the flops of a product, which is the stored entries where there are any.
    pub(super) fn summary(&self) -> Summary {
        let smoothing = self.levels.iter().map(|level| LevelSummary {
            n: level.size() - level.fixed().len(),
            nnz: level.operator().flops() as usize / 2,
            bytes: level.bytes(),
        });
        let below = self.bottom.levels().iter().copied();
        let levels: Vec<LevelSummary> = smoothing.chain(below).collect();
        let total = |of: fn(&LevelSummary) -> usize| {
            levels.iter().map(of).sum::<usize>() as f64 / of(&levels[0]).max(1) as f64
        };
        Summary {
            operator_complexity: total(|level| level.nnz),
            grid_complexity: total(|level| level.n),
            near_null_space: self.about.near_null_space,
            smoothing: self.about.smoothing,
            levels,
        }
    }
}

#[cfg(test)]
mod tests;
