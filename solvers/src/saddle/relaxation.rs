//! One step of relaxation of the stabilization before and after a preconditioner.

use super::AugmentationMatrix;
use crate::amg::lambda::largest_generalized;
use fracas_operators::{LinearOperator, Preconditioner};
use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// γ where nothing else is asked for. Unit: 1.
///
/// The largest `x (1 − γx)²`, x in [0, 1/γ], is 4/(27 γ): with this γ, `WᵀHW ≤ C` wherever `H ≤ 27/4 C`, and every eigenvalue
/// of M⁻¹𝒜 has a real part in [0, max(β_u, 1)], where without W the upper end is `max(β_u, λ_max(C⁻¹H))` (theorem in the paper).
pub const RELAXATION: f64 = 4.0 / 27.0;

/// Smallest factor `1 − γ λ_max(C⁻¹H)` that γ may lead to. Unit: 1. C = half_h has `λ_max ≤ 4` and keeps γ = 4/27, also with
/// λ_max overestimated by 9 %; where C does not dominate H (local, global) γ gives way.
const LEAST: f64 = 0.35;

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

/// `W = I − γ C⁻¹H` of the tractions: `W M⁻¹ Wᵀ` in place of M⁻¹ (W = I for the displacements).
///
/// A diagonal C = C_local + diag(H) is as large for jumps that vary slowly, which H does not see, as for checkerboards, for
/// which H is up to twice its diagonal. With exact S_u, A regular, and modes that are common to `S = BᵀA⁻¹B`, H and C, with values s, h
/// and c, `M⁻¹𝒜` has the eigenvalues 1 and
/// ```text
/// λ = (s + h)/(s + c)                                                            without W
/// λ₁ λ₂ = q² (s + h)/(s + c),  λ₁ + λ₂ = (c + 2 s q + h q²)/(s + c)             with W,  q = 1 − γ h/c
/// ```
/// Modes of large s have h ≈ 0, and q = 1 leaves their λ ≈ 1 alone; h is large where s is small, and q² takes their λ up to 2
/// to 1 and below. So C stays diagonal, as S_u wants it, and the entries of H beside its diagonal are met none the less.
///
/// # Cost
/// Two products with H and two more with C⁻¹ per M⁻¹.
///
/// # Source
/// Derived here; `relaxation/tests.rs` checks the formula, the paper compares.
pub struct Relaxation<H> {
    h: H,
    gamma: f64,
}

impl<H: LinearOperator<f64>> Relaxation<H> {
    /// γ as asked for, less where `λ_max(C⁻¹H)` would take `1 − γ λ_max` below 0.35; `None` for γ = 0.
    ///
    /// # Cost
    /// Ten products with H.
    pub fn new(h: H, gamma: f64, c_inverse: impl Fn(&[f64], &mut [f64])) -> Option<Self> {
        if gamma == 0.0 {
            return None;
        }
        let n = h.shape().rows;
        let mut work = vec![0.0; h.work_len()];
        let product = |x: &[f64], y: &mut [f64]| h.apply(x, y, &mut work);
        let largest = largest_generalized(n, product, c_inverse);
        let gamma = gamma.min((1.0 - LEAST) / largest);
        Some(Self { h, gamma })
    }

    /// The same for a C.
    pub(super) fn of(h: H, gamma: f64, c: &AugmentationMatrix) -> Option<Self> {
        Self::new(h, gamma, |r, z| c.solve(r, z, &mut []))
    }

    /// γ.
    pub fn gamma(&self) -> f64 {
        self.gamma
    }

    /// `x ← Wᵀ x = x − γ H C⁻¹ x`, given C⁻¹ x.
    pub fn before(&self, c_inverse_x: &[f64], x: &mut [f64], work: &mut [f64]) {
        self.h.apply_add(-self.gamma, c_inverse_x, x, work);
    }

    /// `r ← γ H y`: `W y = y − C⁻¹ r`.
    pub fn after(&self, y: &[f64], r: &mut [f64], work: &mut [f64]) {
        r.fill(0.0);
        self.h.apply_add(self.gamma, y, r, work);
    }

    /// Numbers of `work` that [`before`](Self::before) and [`after`](Self::after) need.
    pub fn work_len(&self) -> usize {
        self.h.work_len()
    }

    /// Of one product with H.
    pub fn flops(&self) -> u64 {
        self.h.flops()
    }
}

#[cfg(test)]
mod tests;
