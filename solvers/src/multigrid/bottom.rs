//! The solver below the coarsest level.

use crate::amg::scratch::doubles_of;
use fracas_operators::{Preconditioner, Real};

/// `A⁻¹`, or an approximation of it, over the free unknowns of the coarsest level.
pub struct Bottom {
    inverse: Box<dyn Preconditioner<f64>>,
    /// Where the unknowns of `inverse` stand among those of the level.
    free: Vec<u32>,
    n: usize,
}

impl Bottom {
    /// `inverse` over the unknowns `free` of a level of n.
    pub fn new(inverse: Box<dyn Preconditioner<f64>>, free: Vec<u32>, n: usize) -> Self {
        assert_eq!(inverse.size(), free.len(), "free unknowns of another level");
        Self { inverse, free, n }
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

    pub(super) fn is_linear(&self) -> bool {
        self.inverse.is_linear()
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
