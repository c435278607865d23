//! The first rows and columns of the inverse of a larger matrix.

use crate::direct::Factorization;
use fracas_operators::{Preconditioner, Properties};

/// `z ← y_1` with `M [y_1; y_2] = [r; 0]`: the inverse of a Schur complement by factors of the whole.
pub(super) struct Leading {
    n: usize,
    factors: Box<dyn Factorization>,
}

impl Leading {
    /// The first n unknowns of these factors.
    pub(super) fn new(n: usize, factors: Box<dyn Factorization>) -> Self {
        Self { n, factors }
    }
}

impl Preconditioner<f64> for Leading {
    fn size(&self) -> usize {
        self.n
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let all = self.factors.size();
        let (x, work) = work.split_at_mut(all);
        let (y, work) = work.split_at_mut(all);
        let (first, rest) = x.split_at_mut(self.n);
        first.copy_from_slice(r);
        rest.fill(0.0);
        self.factors.solve(x, y, work);
        z.copy_from_slice(&y[..self.n]);
    }

    fn work_len(&self) -> usize {
        2 * self.factors.size() + self.factors.work_len()
    }

    fn flops(&self) -> u64 {
        self.factors.flops()
    }

    fn properties(&self) -> Properties {
        self.factors.properties()
    }
}
