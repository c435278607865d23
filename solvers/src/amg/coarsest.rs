//! The coarsest level: a dense inverse.

use super::sweeps::SweepMatrix;
use crate::eigen::dense;
use faer::Mat;
use fracas_operators::Real;

/// A⁻¹ of the coarsest matrix, row by row.
#[derive(Clone, Debug)]
pub(super) struct Coarsest<R> {
    n: usize,
    inverse: Vec<R>,
}

impl<R: Real> Coarsest<R> {
    /// # Errors
    /// The scalar row whose pivot is not positive.
    pub(super) fn new<S: Real>(a: &SweepMatrix<S>) -> Result<Self, usize> {
        let n = 3 * a.rows();
        let mut matrix = Mat::<f64>::zeros(n, n);
        for i in 0..a.rows() {
            for (j, block) in a.row(i) {
                for k in 0..9 {
                    matrix[(3 * i + k / 3, 3 * j + k % 3)] = block[k].to_f64_exact();
                }
            }
        }
        // a unit diagonal makes "singular" a matter of digits
        let scale: Vec<f64> = (0..n).map(|i| matrix[(i, i)].sqrt().recip()).collect();
        let scaled = Mat::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
        let l = dense::cholesky(scaled)?;
        if let Some(row) = (0..n).find(|i| l[(*i, *i)] < SINGULAR) {
            return Err(row);
        }
        let mut inverse = Mat::<f64>::identity(n, n);
        dense::solve_lower(l.as_ref(), &mut inverse);
        dense::solve_lower_adjoint(l.as_ref(), &mut inverse);
        let entry = |k: usize| {
            let (i, j) = (k / n, k % n);
            // symmetric to the last bit
            let value = 0.5 * (inverse[(i, j)] + inverse[(j, i)]);
            R::of(value * scale[i] * scale[j])
        };
        Ok(Self {
            n,
            inverse: (0..n * n).map(entry).collect(),
        })
    }

    /// `x ← A⁻¹ b`.
    pub(super) fn solve(&self, b: &[R], x: &mut [R]) {
        for (x, row) in x.iter_mut().zip(self.inverse.chunks_exact(self.n)) {
            let (row8, row) = row.as_chunks::<8>();
            let (b8, b) = b.as_chunks::<8>();
            let mut sums = [R::zero(); 8];
            for (a, b) in row8.iter().zip(b8) {
                for lane in 0..8 {
                    sums[lane] += a[lane] * b[lane];
                }
            }
            let tail: R = row.iter().zip(b).map(|(a, b)| *a * *b).sum();
            *x = sums.iter().copied().sum::<R>() + tail;
        }
    }

    /// Unknowns.
    pub(super) fn size(&self) -> usize {
        self.n
    }

    pub(super) fn flops(&self) -> u64 {
        2 * (self.n * self.n) as u64
    }

    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.inverse)
    }
}

/// Diagonal entry of the Cholesky factor of a matrix with unit diagonal below which it counts as singular. Unit: 1.
const SINGULAR: f64 = 1e-6;
