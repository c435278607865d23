//! The solver below the coarsest level.

use super::semidefinite::Semidefinite;
use crate::amg::scratch::doubles_of;
use fracas_operators::{Preconditioner, Properties, Real};

/// `A⁻¹`, or an approximation of it, over the free unknowns of the coarsest level.
pub struct Bottom {
    inverse: Box<dyn Preconditioner<f64>>,
    /// Where the unknowns of `inverse` stand among those of the level.
    free: Vec<u32>,
    n: usize,
    /// What the coarse matrix maps to rounding, over all unknowns of the level.
    null: Option<Vec<f64>>,
}

impl Bottom {
    /// `inverse` over the unknowns `free` of a level of n.
    pub fn new(inverse: Box<dyn Preconditioner<f64>>, free: Vec<u32>, n: usize) -> Self {
        assert_eq!(inverse.size(), free.len(), "free unknowns of another level");
        let null = None;
        Self {
            inverse,
            free,
            n,
            null,
        }
    }

    /// `A_c⁺` where functions of the coarsest level may depend on each other.
    pub fn semidefinite(inverse: Semidefinite, free: Vec<u32>, n: usize) -> Self {
        let full = |null: &[f64]| {
            let mut full = vec![0.0; n];
            free.iter()
                .zip(null)
                .for_each(|(i, v)| full[*i as usize] = *v);
            full
        };
        let null = inverse.null().map(full);
        Self {
            null,
            ..Self::new(Box::new(inverse), free, n)
        }
    }

    /// A random vector that the coarse matrix maps to rounding, where some functions are left out.
    pub(super) fn null(&self) -> Option<&[f64]> {
        self.null.as_deref()
    }

    /// Unknowns of the level, fixed ones included.
    pub fn size(&self) -> usize {
        self.n
    }

    /// `x ← A⁻¹ b`, zero where fixed.
    pub(super) fn solve<R: Real>(&self, b: &[R], x: &mut [R], work: &mut [R]) {
        let m = self.free.len();
        let (r, work) = doubles_of(work).split_at_mut(m);
        let (z, work) = work.split_at_mut(m);
        for (r, i) in r.iter_mut().zip(&self.free) {
            *r = b[*i as usize].to_f64_exact();
        }
        self.inverse.solve(r, z, work);
        x.fill(R::zero());
        for (z, i) in z.iter().zip(&self.free) {
            x[*i as usize] = R::of(*z);
        }
    }

    pub(super) fn work_len<R: Real>(&self) -> usize {
        let entries = 2 * self.free.len() + self.inverse.work_len();
        // one more, because scratch of R need not start where an f64 may
        (entries + 1) * (size_of::<f64>() / size_of::<R>())
    }

    pub(super) fn properties(&self) -> Properties {
        self.inverse.properties()
    }

    pub(super) fn flops(&self) -> u64 {
        self.inverse.flops()
    }
}

impl std::fmt::Debug for Bottom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "a solver of {} unknowns", self.free.len())
    }
}
