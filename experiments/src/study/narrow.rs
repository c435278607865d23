//! A preconditioner of f64 for an iteration in f32.

use fracas_operators::{Preconditioner, Properties};

/// `z ← fl(M⁻¹ r)`.
pub(super) struct Narrow<'a>(&'a dyn Preconditioner<f64>);

impl<'a> Narrow<'a> {
    pub(super) fn new(inverse: &'a dyn Preconditioner<f64>) -> Self {
        Self(inverse)
    }
}

impl Preconditioner<f32> for Narrow<'_> {
    fn size(&self) -> usize {
        self.0.size()
    }

    fn solve(&self, r: &[f32], z: &mut [f32], _work: &mut [f32]) {
        // scratch of f32 need not lie where f64 may: here alone a solve allocates
        let r: Vec<f64> = r.iter().map(|r| f64::from(*r)).collect();
        let mut wide = vec![0.0; r.len()];
        self.0
            .solve(&r, &mut wide, &mut vec![0.0; self.0.work_len()]);
        z.iter_mut().zip(wide).for_each(|(z, w)| *z = w as f32);
    }

    fn flops(&self) -> u64 {
        self.0.flops()
    }

    fn properties(&self) -> Properties {
        self.0.properties()
    }
}
