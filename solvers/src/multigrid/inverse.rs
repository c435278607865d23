//! The ready preconditioner: f64 outside, f32 or f64 inside.

use super::Summary;
use super::cycle::Hierarchy;
use super::places::Places;
use crate::scratch::{cast, doubles};
use fracas_operators::vector::norm_inf;
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
    places: Places,
    /// What the operator was divided by, and f.
    factor: f64,
}

/// Either hierarchy, as `$h`, in `$value`.
macro_rules! either {
    ($hierarchy:expr, $h:ident => $value:expr) => {
        match &$hierarchy {
            SomeHierarchy::Single($h) => $value,
            SomeHierarchy::Double($h) => $value,
        }
    };
}

impl MultigridInverse {
    /// The cycle of `hierarchy`, whose operator is the given one divided by `scale`, times `over_correction`.
    pub fn new(hierarchy: SomeHierarchy, places: Places, scale: f64, over_correction: f64) -> Self {
        Self {
            hierarchy,
            places,
            factor: over_correction / scale,
        }
    }

    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        either!(self.hierarchy, h => h.summary())
    }

    fn solve_with<R: Real>(&self, h: &Hierarchy<R>, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let largest = norm_inf(r);
        if largest == 0.0 || !largest.is_finite() {
            return z.copy_from_slice(r);
        }
        // a power of two brings r into the range of R and changes no digit
        let size = largest.log2().round().exp2();
        let (b, work) = cast::<R>(work).split_at_mut(h.size(0));
        let (x, work) = work.split_at_mut(h.size(0));
        self.places.spread(r, size.recip(), h.fixed(), b);
        h.solve(b, x, work);
        self.places.gather(x, self.factor * size, h.fixed(), z);
    }
}

impl Preconditioner<f64> for MultigridInverse {
    fn size(&self) -> usize {
        either!(self.hierarchy, h => self.places.unknowns(h.size(0), h.fixed()))
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        assert!(r.len() == self.size() && z.len() == self.size());
        either!(self.hierarchy, h => self.solve_with(h, r, z, work));
    }

    fn work_len(&self) -> usize {
        fn entries<R: Real>(h: &Hierarchy<R>) -> usize {
            doubles::<R>(2 * h.size(0) + h.work_len())
        }
        either!(self.hierarchy, h => entries(h))
    }

    fn flops(&self) -> u64 {
        either!(self.hierarchy, h => h.flops(0))
    }

    fn properties(&self) -> Properties {
        let properties = either!(self.hierarchy, h => h.properties());
        match self.hierarchy {
            SomeHierarchy::Single(_) => properties.and(Properties::SINGLE),
            SomeHierarchy::Double(_) => properties,
        }
    }
}

impl std::fmt::Debug for MultigridInverse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "multigrid cycle of {} unknowns", self.size())
    }
}
