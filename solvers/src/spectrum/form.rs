//! The matrix T that is similar to M⁻¹𝒜 where all blocks are symmetric, and what its parts prove.
//!
//! In the scales of S̃_u and C, with the eigenvectors of `Ĥ = FᵀHF` for tractions and W = p(C⁻¹H) relaxing H on both sides,
//! ```text
//! T = [ K        G N ]     K = Σ + G diag(2q − a − 1) Gᵀ     Σ = Eᵀ S_u E     q_j = p(h_j)
//!     [ −N Gᵀ     Ã  ]     N = diag(q − a)                   Ã = diag(a)      a_j = h_j q_j²
//! ```
//! Without relaxation q = 1 and a = h: K = K_H, N = I − Ĥ.

use super::bounds::Ingredients;
use super::discs::{self, Mode};
use super::real_ends::{self, Ends};
use super::region::Circle;
use crate::SetupError;
use crate::eigen::dense;
use faer::Mat;

/// An eigenvalue of C⁻¹H below this fraction of max(1, η) is a zero of H. Unit: 1.
const ZERO: f64 = 1e-13;

/// T by its parts.
pub(super) struct Form {
    /// Σ; `None` = I.
    sigma: Option<Mat<f64>>,
    /// In the eigenvectors of Ĥ.
    g: Mat<f64>,
    /// h, q.
    modes: Vec<Mode>,
    /// Eigenvectors of Ĥ; `None` = I.
    basis: Option<Mat<f64>>,
    /// Displacements beside those of Σ that nothing couples: eigenvalues 1.
    ones: usize,
}

/// What the parts of T prove.
pub(super) struct Statements {
    pub(super) ingredients: Ingredients,
    /// One circle at least holds a non-real eigenvalue.
    pub(super) circles: Vec<Circle>,
    /// They do where Re λ ≥ 0 only.
    pub(super) right_of_zero: bool,
    /// So does this one, where it is there.
    pub(super) around_one: Option<Circle>,
    /// Ends of the real eigenvalues.
    pub(super) real: Option<(f64, f64)>,
}

impl Form {
    /// Of Σ, G, Ĥ and p.
    pub(super) fn new(
        sigma: Option<Mat<f64>>,
        g: &Mat<f64>,
        h_hat: Option<&Mat<f64>>,
        p: &dyn Fn(f64) -> f64,
        ones: usize,
    ) -> Result<Self, SetupError> {
        let Some(h_hat) = h_hat.filter(|h| h.norm_max() > 0.0) else {
            return Ok(Self {
                sigma,
                modes: vec![(0.0, 1.0); g.ncols()],
                g: g.clone(),
                basis: None,
                ones,
            });
        };
        let mut symmetric = h_hat.clone();
        dense::symmetrize(&mut symmetric);
        let (values, basis) = dense::symmetric_eigen(symmetric.as_ref())?;
        let size = values.iter().fold(1.0f64, |m, h| m.max(h.abs()));
        let mode = |h: &f64| match h.abs() <= ZERO * size {
            true => (0.0, 1.0),
            false => (*h, p(*h)),
        };
        Ok(Self {
            sigma,
            g: dense::multiply(g.as_ref(), basis.as_ref()),
            modes: values.iter().map(mode).collect(),
            basis: Some(basis),
            ones,
        })
    }

    fn n_u(&self) -> usize {
        self.g.nrows()
    }

    /// `Σ + G diag(d) Gᵀ`.
    fn displacements(&self, d: impl Fn(Mode) -> f64) -> Mat<f64> {
        let n = self.n_u();
        let scaled = Mat::from_fn(n, self.modes.len(), |i, j| {
            self.g[(i, j)] * d(self.modes[j])
        });
        let mut k = dense::multiply(scaled.as_ref(), self.g.transpose());
        match &self.sigma {
            Some(sigma) => k += sigma,
            None => (0..n).for_each(|i| k[(i, i)] += 1.0),
        }
        dense::symmetrize(&mut k);
        k
    }

    fn k(&self) -> Mat<f64> {
        self.displacements(|mode| 2.0 * mode.1 - discs::relaxed(mode) - 1.0)
    }

    /// `G N`.
    fn coupling(&self) -> Mat<f64> {
        Mat::from_fn(self.n_u(), self.modes.len(), |i, j| {
            self.g[(i, j)] * (self.modes[j].1 - discs::relaxed(self.modes[j]))
        })
    }

    /// T, without the displacements that nothing couples.
    pub(super) fn matrix(&self) -> Mat<f64> {
        let n = self.n_u();
        let (k, right) = (self.k(), self.coupling());
        Mat::from_fn(n + right.ncols(), n + right.ncols(), |i, j| {
            match (i < n, j < n) {
                (true, true) => k[(i, j)],
                (true, false) => right[(i, j - n)],
                (false, true) => -right[(j, i - n)],
                (false, false) if i == j => discs::relaxed(self.modes[i - n]),
                (false, false) => 0.0,
            }
        })
    }

    /// Eigenvalues that [`matrix`](Self::matrix) leaves out: all of them 1.
    pub(super) fn ones(&self) -> usize {
        self.ones
    }

    /// From a vector of T to one of its similar matrix before W was made an identity: `(v_u, P (Gᵀv_u + v_t))` in the basis of Ĥ.
    pub(super) fn tractions(&self, v: &[f64]) -> Vec<f64> {
        let n = self.n_u();
        let v_u = Mat::from_fn(n, 1, |i, _| v[i]);
        let mut t = self.g.transpose() * &v_u;
        for (j, mode) in self.modes.iter().enumerate() {
            t[(j, 0)] = mode.1 * (t[(j, 0)] + v[n + j]);
        }
        let t = match &self.basis {
            Some(basis) => basis * &t,
            None => t,
        };
        t.col(0).iter().copied().collect()
    }

    /// Extreme values and what follows from them. The ends of real eigenvalues are stated for H ⪰ 0 and A ⪰ 0.
    pub(super) fn statements(&self) -> Result<Statements, SetupError> {
        let (n_u, n_t) = (self.n_u(), self.modes.len());
        let span = |values: &[f64]| {
            let ends = (
                values.first().copied().unwrap_or(0.0),
                values.last().copied().unwrap_or(0.0),
            );
            match self.ones {
                0 => ends,
                _ if n_u == 0 => (1.0, 1.0),
                _ => (ends.0.min(1.0), ends.1.max(1.0)),
            }
        };
        let singular = dense::singular_values(self.g.as_ref())?;
        let g = (
            match n_t > n_u + self.ones {
                true => 0.0,
                false => singular.last().copied().unwrap_or(0.0),
            },
            singular.first().copied().unwrap_or(0.0),
        );
        let sigma = match &self.sigma {
            None => (1.0, 1.0),
            Some(sigma) => {
                let mut sigma = sigma.clone();
                dense::symmetrize(&mut sigma);
                span(&dense::symmetric_eigenvalues(sigma.as_ref())?)
            }
        };
        let whole = self.displacements(|_| 1.0);
        let k = span(&dense::symmetric_eigenvalues(whole.as_ref())?);
        let (values, vectors) = dense::symmetric_eigen(self.k().as_ref())?;
        let k_h = span(&values);
        let right = self.coupling();
        let a: Vec<f64> = self.modes.iter().copied().map(discs::relaxed).collect();
        let ends = |values: &mut dyn Iterator<Item = f64>| {
            let all: Vec<f64> = values.collect();
            match all.is_empty() {
                true => (0.0, 0.0),
                false => (
                    all.iter().copied().fold(f64::INFINITY, f64::min),
                    all.iter().copied().fold(f64::NEG_INFINITY, f64::max),
                ),
            }
        };
        let h_hat = ends(&mut a.iter().copied());
        let h = ends(&mut self.modes.iter().map(|m| m.0));
        let largest = dense::singular_values(right.as_ref())?;
        let ingredients = Ingredients {
            k,
            g,
            h_hat,
            k_h,
            coupling: largest.first().copied().unwrap_or(0.0),
            sigma,
            h,
        };
        let w = dense::multiply(vectors.transpose(), right.as_ref());
        let ends = Ends {
            k: &values,
            w: &w,
            a: &a,
        };
        let q_fits = self.modes.iter().all(|m| m.1 <= 1.0);
        let real = (h.0 >= 0.0 && q_fits)
            .then(|| {
                let low = ends.lower(k_h.0.min(h_hat.0))?;
                let known = real_ends::upper(sigma.1, g.1 * g.1, h_hat.1);
                let high = ends.upper(known.min(k_h.1.max(h_hat.1)))?;
                Ok::<_, SetupError>(match self.ones {
                    0 => (low, high),
                    _ => (low.min(1.0), high.max(1.0)),
                })
            })
            .transpose()?;
        Ok(Statements {
            ingredients,
            circles: discs::of_modes(&self.modes),
            right_of_zero: false,
            around_one: discs::around_one(sigma.0, &self.modes),
            real,
        })
    }
}
