//! A preconditioner of f64 for an iteration in f32.

use crate::scratch::doubles_of;
use fracas_operators::{Preconditioner, Properties};

/// `z ← fl(M⁻¹ r)`: r is widened, and what M⁻¹ gives is rounded.
#[derive(Debug)]
pub struct Narrowed<M>(pub M);

impl<M: Preconditioner<f64>> Preconditioner<f32> for Narrowed<M> {
    fn size(&self) -> usize {
        self.0.size()
    }

    fn solve(&self, r: &[f32], z: &mut [f32], work: &mut [f32]) {
        let n = self.size();
        let (wide, work) = doubles_of(work).split_at_mut(n);
        let (inverse, work) = work.split_at_mut(n);
        wide.iter_mut().zip(r).for_each(|(w, r)| *w = f64::from(*r));
        self.0.solve(wide, inverse, &mut work[..self.0.work_len()]);
        z.iter_mut().zip(inverse).for_each(|(z, w)| *z = *w as f32);
    }

    fn work_len(&self) -> usize {
        // one more than twice as many, since memory of f32 may begin within an f64
        2 * (2 * self.size() + self.0.work_len()) + 1
    }

    fn flops(&self) -> u64 {
        self.0.flops()
    }

    fn properties(&self) -> Properties {
        self.0.properties()
    }
}
