//! The ready preconditioner: f64 and free unknowns outside.

use super::cycle::Hierarchy;
use crate::amg::scratch::{cast, doubles};
use crate::amg::{LevelSummary, Summary};
use fracas_operators::free_entries::{gather, spread};
use fracas_operators::vector::norm2;
use fracas_operators::{Preconditioner, Properties, Real};

/// A hierarchy in one of the two precisions.
pub enum SomeHierarchy {
    /// 32 bits.
    Single(Hierarchy<f32>),
    /// 64 bits.
    Double(Hierarchy<f64>),
}

/// One multigrid cycle per solve: `z ← f M⁻¹ r`.
pub struct MultigridInverse {
    hierarchy: SomeHierarchy,
    /// What the operator was divided by, and f.
    factor: f64,
    below: Vec<LevelSummary>,
    spaces: &'static str,
}

impl MultigridInverse {
    /// The cycle of `hierarchy`, whose operator is the given one divided by `scale`, times `over_correction`. Unknowns
    /// are those of the finest level without its fixed ones. `below` describes what is under the coarsest level,
    /// `spaces` what the coarse spaces reproduce.
    pub fn new(
        hierarchy: SomeHierarchy,
        scale: f64,
        over_correction: f64,
        below: Vec<LevelSummary>,
        spaces: &'static str,
    ) -> Self {
        Self {
            hierarchy,
            factor: over_correction / scale,
            below,
            spaces,
        }
    }

    /// The hierarchy.
    pub fn hierarchy(&self) -> &SomeHierarchy {
        &self.hierarchy
    }

    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => h.summary(&self.below, self.spaces),
            SomeHierarchy::Double(h) => h.summary(&self.below, self.spaces),
        }
    }

    fn solve_with<R: Real>(&self, h: &Hierarchy<R>, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let length = norm2(r);
        if length == 0.0 || !length.is_finite() {
            return z.copy_from_slice(r);
        }
        // a power of two brings r into the range of R and changes no digit
        let size = length.log2().round().exp2();
        let finest = &h.levels()[0];
        let (b, work) = cast::<R>(work).split_at_mut(finest.size());
        let (x, work) = work.split_at_mut(finest.size());
        spread(r, 1.0 / size, &finest.fixed, b);
        h.solve(b, x, work);
        let factor = self.factor * size;
        gather(x, &finest.fixed, z, &|x, z| *z = factor * x.to_f64_exact());
    }
}

impl Preconditioner<f64> for MultigridInverse {
    fn size(&self) -> usize {
        let free = |size: usize, fixed: &[u32]| size - fixed.len();
        match &self.hierarchy {
            SomeHierarchy::Single(h) => free(h.levels()[0].size(), &h.levels()[0].fixed),
            SomeHierarchy::Double(h) => free(h.levels()[0].size(), &h.levels()[0].fixed),
        }
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        assert!(r.len() == self.size() && z.len() == self.size());
        match &self.hierarchy {
            SomeHierarchy::Single(h) => self.solve_with(h, r, z, work),
            SomeHierarchy::Double(h) => self.solve_with(h, r, z, work),
        }
    }

    fn work_len(&self) -> usize {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => doubles::<f32>(2 * h.levels()[0].size() + h.work_len()),
            SomeHierarchy::Double(h) => 2 * h.levels()[0].size() + h.work_len(),
        }
    }

    fn flops(&self) -> u64 {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => h.flops(0),
            SomeHierarchy::Double(h) => h.flops(0),
        }
    }

    fn properties(&self) -> Properties {
        match &self.hierarchy {
            SomeHierarchy::Single(h) => h.properties().and(Properties::SINGLE),
            SomeHierarchy::Double(h) => h.properties(),
        }
    }
}
