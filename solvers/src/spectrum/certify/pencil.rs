//! The pencil `𝒜 x = λ M x` with exact S_u, `M = [A B1; B1ᵀ −C]`: every block is explicit, nothing is inverted.

use super::inertia::Symmetric;
use super::rounding::{U, above, largest};
use crate::eigen::dense;
use crate::saddle::{AugmentationMatrix, SaddleBlocks};
use faer::Mat;

/// The blocks, in scales that are powers of two, which round nothing.
pub(super) struct Pencil {
    pub(super) a: Mat<f64>,
    pub(super) b: Mat<f64>,
    /// B2; `None` for B1ᵀ.
    pub(super) b2: Option<Mat<f64>>,
    pub(super) c: Mat<f64>,
    pub(super) h: Mat<f64>,
}

/// What the counting of signs rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Route {
    /// A ≻ 0 and C ≻ 0.
    Stiff,
    /// C ≻ H, and M has n_u positive and n_t negative eigenvalues.
    Dominated,
}

/// A power of two near `size^{-1/2}`, exact whatever the library of functions rounds.
fn power_of_two(size: f64) -> f64 {
    const BIAS: i64 = 1023;
    match size > 0.0 && size.is_finite() {
        // |exponent| ≤ 537, so that the number is normal
        true => f64::from_bits(((BIAS - (0.5 * size.log2()).round() as i64) as u64) << 52),
        false => 1.0,
    }
}

impl Pencil {
    pub(super) fn new(blocks: &SaddleBlocks, c: &AugmentationMatrix) -> Self {
        let (a, b, c) = (
            dense::to_dense(&blocks.a),
            dense::to_dense(&blocks.b1),
            c.to_dense(),
        );
        let (n_u, n_t) = (a.nrows(), c.nrows());
        let h = match &blocks.h {
            Some(h) => dense::to_dense(h),
            None => Mat::zeros(n_t, n_t),
        };
        let d_t: Vec<f64> = (0..n_t).map(|k| power_of_two(c[(k, k)])).collect();
        // diag(A + B diag(C)⁻¹ Bᵀ)
        let size = |i: usize| {
            let of_b = (0..n_t).map(|k| b[(i, k)] * b[(i, k)] / c[(k, k)]);
            a[(i, i)] + of_b.sum::<f64>()
        };
        let d_u: Vec<f64> = (0..n_u).map(|i| power_of_two(size(i))).collect();
        // an entry that underflows or overflows on the way is none, and nothing is proved
        let scaled = |m: &Mat<f64>, rows: &[f64], columns: &[f64]| {
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| {
                let entry = rows[i] * m[(i, j)] * columns[j];
                match entry / rows[i] / columns[j] == m[(i, j)] {
                    true => entry,
                    false => f64::NAN,
                }
            })
        };
        let b2 = (blocks.b2.as_ref().map(dense::to_dense))
            .filter(|b2| (0..n_u).any(|i| (0..n_t).any(|k| b2[(k, i)] != b[(i, k)])));
        Self {
            a: scaled(&a, &d_u, &d_u),
            b: scaled(&b, &d_u, &d_t),
            b2: b2.map(|b2| scaled(&b2, &d_t, &d_u)),
            c: scaled(&c, &d_t, &d_t),
            h: scaled(&h, &d_t, &d_t),
        }
    }

    pub(super) fn sizes(&self) -> (usize, usize) {
        (self.a.nrows(), self.c.nrows())
    }

    /// All blocks are symmetric to the last bit, and B2 = B1ᵀ.
    pub(super) fn is_symmetric(&self) -> bool {
        let same = |m: &Mat<f64>| {
            let n = m.nrows();
            (0..n).all(|j| (0..j).all(|i| m[(i, j)] == m[(j, i)]))
        };
        self.b2.is_none() && [&self.a, &self.c, &self.h].into_iter().all(same)
    }

    /// C − H with what its subtraction rounds.
    fn remainder(&self) -> Symmetric {
        let n = self.c.nrows();
        let matrix = Mat::from_fn(n, n, |i, j| self.c[(i, j)] - self.h[(i, j)]);
        let rounding = |i: usize| above((0..n).map(|j| U * matrix[(i, j)].abs()).sum(), n);
        let rows: Vec<f64> = (0..n).map(rounding).collect();
        Symmetric {
            error: largest(&rows),
            matrix,
        }
    }

    /// C ≻ H.
    pub(super) fn c_dominates(&self) -> bool {
        self.remainder().is_positive()
    }

    pub(super) fn a_is_positive(&self) -> bool {
        Symmetric::exact(self.a.clone()).is_positive()
    }

    /// What can be proved; `None` where neither can.
    pub(super) fn route(&self) -> Option<Route> {
        if !Symmetric::exact(self.c.clone()).is_positive() {
            return None;
        }
        if self.a_is_positive() {
            return Some(Route::Stiff);
        }
        let (n_u, n_t) = self.sizes();
        let m = Symmetric::exact(self.m());
        let is_dominated = self.c_dominates()
            && m.most_nonnegative() == Some(n_u)
            && m.most_nonpositive() == Some(n_t);
        is_dominated.then_some(Route::Dominated)
    }

    /// M.
    pub(super) fn m(&self) -> Mat<f64> {
        self.combined(|a| a, |b| b, |c, _| -c)
    }

    fn combined(
        &self,
        of_a: impl Fn(f64) -> f64,
        of_b: impl Fn(f64) -> f64,
        of_c: impl Fn(f64, f64) -> f64,
    ) -> Mat<f64> {
        let (n_u, n_t) = self.sizes();
        Mat::from_fn(n_u + n_t, n_u + n_t, |i, j| match (i < n_u, j < n_u) {
            (true, true) => of_a(self.a[(i, j)]),
            (true, false) => of_b(self.b[(i, j - n_u)]),
            (false, true) => of_b(self.b[(j, i - n_u)]),
            (false, false) => of_c(self.c[(i - n_u, j - n_u)], self.h[(i - n_u, j - n_u)]),
        })
    }

    /// `𝒜 − σM = [(1−σ)A (1−σ)B; (1−σ)Bᵀ σC−H]`, displacements scaled by a power of two near `|1−σ|^{−1/2}`.
    fn shifted(&self, sigma: f64) -> Symmetric {
        let factor = 1.0 - sigma;
        let d = power_of_two(factor.abs());
        // the scales first: what underflows in a product is not enlarged afterwards
        let (of_a, of_b) = (d * factor * d, d * factor);
        let matrix = self.combined(|a| of_a * a, |b| of_b * b, |c, h| sigma * c - h);
        // 1 − σ and its product round, σC and its difference from H
        let (n_u, n_t) = self.sizes();
        let row = |i: usize| {
            let entry = |j: usize| match i >= n_u && j >= n_u {
                true => {
                    (sigma * self.c[(i - n_u, j - n_u)]).abs() + self.h[(i - n_u, j - n_u)].abs()
                }
                false => matrix[(i, j)].abs(),
            };
            above((0..n_u + n_t).map(|j| 3.0 * U * entry(j)).sum(), n_u + n_t)
        };
        let rows: Vec<f64> = (0..n_u + n_t).map(row).collect();
        Symmetric {
            error: largest(&rows),
            matrix,
        }
    }

    /// No eigenvalue is ≤ σ < 1: by [`Route`], as many as `n₊(𝒜 − σM) − n_u` lie below σ.
    pub(super) fn none_below(&self, sigma: f64) -> bool {
        let (n_u, _) = self.sizes();
        sigma < 1.0
            && self
                .shifted(sigma)
                .most_nonnegative()
                .is_some_and(|n| n <= n_u)
    }

    /// One is ≤ σ < 1.
    pub(super) fn one_below(&self, sigma: f64) -> bool {
        let (_, n_t) = self.sizes();
        sigma < 1.0
            && self
                .shifted(sigma)
                .most_nonpositive()
                .is_some_and(|n| n < n_t)
    }

    /// No eigenvalue is ≥ σ > 1: above σ lie `n₋(𝒜 − σM) − n_u` where A ≻ 0, and `n_u − n₋` where C ≻ H.
    pub(super) fn none_above(&self, sigma: f64, route: Route) -> bool {
        let (n_u, n_t) = self.sizes();
        let shifted = self.shifted(sigma);
        sigma > 1.0
            && match route {
                Route::Stiff => shifted.most_nonpositive().is_some_and(|n| n <= n_u),
                Route::Dominated => shifted.most_nonnegative().is_some_and(|n| n <= n_t),
            }
    }

    /// One is ≥ σ > 1.
    pub(super) fn one_above(&self, sigma: f64, route: Route) -> bool {
        let (n_u, n_t) = self.sizes();
        let shifted = self.shifted(sigma);
        sigma > 1.0
            && match route {
                Route::Stiff => shifted.most_nonnegative().is_some_and(|n| n < n_t),
                Route::Dominated => shifted.most_nonpositive().is_some_and(|n| n < n_u),
            }
    }
}
