//! Relaxation of the stabilization before and after a preconditioner.

mod polynomial;

use crate::multigrid::lambda::{STEPS, largest_generalized};
use fracas_operators::{LinearOperator, Preconditioner};
pub use polynomial::{POLYNOMIALS, Polynomial};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

/// γ where nothing else is asked for. Unit: 1.
///
/// The largest `x (1 − γx)²`, x in [0, 1/γ], is 4/(27 γ): with this γ, `WᵀHW ≤ C`, which polynomials of a higher degree keep for a
/// larger H, and every eigenvalue of M⁻¹𝒜 has a real part of at most max(β_u, 1), where without W the upper end is `max(β_u, λ_max(C⁻¹H))` (theorem in the paper).
pub const RELAXATION: f64 = 4.0 / 27.0;

/// The largest `λ_max(C⁻¹H)` that γ = 4/27 serves. Unit: 1.
pub const REACH: f64 = POLYNOMIALS[POLYNOMIALS.len() - 1].end;

/// Reads γ.
///
/// # Errors
/// A number outside [0, 1].
pub fn factor<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let gamma = f64::deserialize(deserializer)?;
    match (0.0..=1.0).contains(&gamma) {
        true => Ok(gamma),
        false => Err(Error::custom(format!(
            "relaxation {gamma}: expected a number from 0 (none) to 1"
        ))),
    }
}

/// `W = p(σ C⁻¹H)`, σ = 27γ/4, of the tractions: `W M⁻¹ Wᵀ` in place of M⁻¹ (W = I for the displacements). p is
/// 1 − 4x/27, so that `W = I − γ C⁻¹H`, while `σ λ_max(C⁻¹H) ≤ 4.5`, and of a degree up to four where C is smaller
/// beside H than that.
///
/// A diagonal C = C_local + diag(H) is as large for jumps that vary slowly, which H does not see, as for checkerboards, for
/// which H is up to twice its diagonal. With exact S_u, A regular, and modes that are common to `S = BᵀA⁻¹B`, H and C, with values s, h
/// and c, `M⁻¹𝒜` has the eigenvalues 1 and
/// ```text
/// λ = (s + h)/(s + c)                                                            without W
/// λ₁ λ₂ = q² (s + h)/(s + c),  λ₁ + λ₂ = (c + 2 s q + h q²)/(s + c)             with W,  q = p(σ h/c)
/// ```
/// Modes of large s and small h have q ≈ 1, which leaves their λ ≈ 1 alone; where h is large and s small, `q² ≈ c/(σh)` takes λ
/// to one and below. So C stays diagonal, as S_u wants it, and may be much smaller than H: modes with s and h both below c, whose λ is
/// small, become few.
///
/// # Cost
/// With degree d, 2d products with H and as many more with C⁻¹ per M⁻¹.
///
/// # Source
/// Derived here; `relaxation/tests.rs` checks the formula, the paper compares.
pub struct Relaxation<'a> {
    h: Box<dyn LinearOperator<f64> + 'a>,
    sigma: f64,
    polynomial: &'static Polynomial,
}

/// What a [`Relaxation`] does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct RelaxationSummary {
    /// γ as applied; 0 = H is not relaxed.
    pub gamma: f64,
    /// Degree of W in C⁻¹H; 0 = H is not relaxed.
    pub degree: usize,
    /// Largest λ_max(C⁻¹H) for which `W C⁻¹H W` is at most γ₀/γ, γ₀ = 4/27; 0 = H is not relaxed.
    pub reach: f64,
}

impl<'a> Relaxation<'a> {
    /// γ as asked for, less where `27γ/4 λ_max(C⁻¹H)` would be beyond [`REACH`]; `None` for γ = 0.
    ///
    /// # Cost
    /// Ten products with H and as many solves with C.
    pub fn new(
        h: Box<dyn LinearOperator<f64> + 'a>,
        gamma: f64,
        c: &dyn Preconditioner<f64>,
    ) -> Option<Self> {
        if gamma == 0.0 {
            return None;
        }
        let mut work = vec![0.0; h.work_len()];
        let mut work_c = vec![0.0; c.work_len()];
        let product = |x: &[f64], y: &mut [f64]| h.apply(x, y, &mut work);
        let c_inverse = |r: &[f64], z: &mut [f64]| c.solve(r, z, &mut work_c);
        let largest = largest_generalized((h.shape().rows, STEPS), product, c_inverse);
        let sigma = (gamma / RELAXATION).min(REACH / largest);
        let polynomial = Polynomial::up_to(sigma * largest);
        Some(Self {
            h,
            sigma,
            polynomial,
        })
    }

    /// The same W with the same H by something else: the rows of a rank.
    #[must_use]
    pub fn over<'h>(self, h: Box<dyn LinearOperator<f64> + 'h>) -> Relaxation<'h> {
        Relaxation {
            h,
            sigma: self.sigma,
            polynomial: self.polynomial,
        }
    }

    /// What W makes of a mode of tractions with the eigenvalue h of C⁻¹H: `p(σh)`.
    pub fn at(&self, h: f64) -> f64 {
        self.polynomial.at(self.sigma * h)
    }

    /// γ and the degree.
    pub fn summary(&self) -> RelaxationSummary {
        RelaxationSummary {
            gamma: self.sigma * RELAXATION,
            degree: self.polynomial.degree(),
            reach: self.polynomial.end / self.sigma,
        }
    }

    /// `r ← Wᵀ r = p(σ H C⁻¹) r`, by Horner's rule; `W C⁻¹ r` is C⁻¹ of it, which gets what [`work_len`](Self::work_len) leaves.
    pub fn apply_transpose(&self, c: &dyn Preconditioner<f64>, r: &mut [f64], work: &mut [f64]) {
        let (z, work) = work.split_at_mut(r.len());
        let (v, work) = work.split_at_mut(r.len());
        // p(x) = 1 + c₁x (1 + c₂/c₁ x (1 + c₃/c₂ x (…))): v ← r + c_k/c_{k−1} σ H C⁻¹ v from k = d down to 1
        let coefficients = self.polynomial.coefficients;
        v.copy_from_slice(r);
        for (k, c_k) in coefficients.iter().enumerate().rev() {
            let before = k.checked_sub(1).map_or(1.0, |k| coefficients[k]);
            c.solve(v, z, work);
            v.copy_from_slice(r);
            self.h.apply_add(self.sigma * c_k / before, z, v, work);
        }
        r.copy_from_slice(v);
    }

    /// Numbers of `work` that [`apply_transpose`](Self::apply_transpose) needs, given those of C⁻¹.
    pub fn work_len(&self, c_inverse: usize) -> usize {
        2 * self.h.shape().rows + self.h.work_len().max(c_inverse)
    }

    /// Of Wᵀ, given those of C⁻¹.
    pub fn flops(&self, c_inverse: u64) -> u64 {
        self.polynomial.degree() as u64 * (self.h.flops() + c_inverse)
    }
}

/// The end and the coefficients of the polynomial of a degree from one to four.
#[cfg(test)]
pub(crate) fn polynomial_of_degree(degree: usize) -> (f64, &'static [f64]) {
    let p = &POLYNOMIALS[degree - 1];
    (p.end, p.coefficients)
}
