//! The true residual, recomputed.

use super::equations::Equations;
use fracas_operators::vector;
use fracas_solvers::saddle::SaddleBlocks;

/// Measures of `b − 𝒜x`; `None` where one is not a number.
pub(super) struct Residual {
    /// `‖b − 𝒜x‖₂ / ‖b‖₂`; 0 for b = 0.
    pub(super) relative: Option<f64>,
    /// `‖b − 𝒜x‖_∞ / (‖𝒜‖_∞ ‖x‖_∞ + ‖b‖_∞)`.
    pub(super) backward: Option<f64>,
    /// `‖r_t‖_∞ / ‖|B1|ᵀ|u| + |b_t|‖_∞`.
    pub(super) contact: Option<f64>,
}

impl Residual {
    /// Of x; in twice the digits from the entries of 𝒜, where they are given.
    pub(super) fn new(
        equations: &dyn Equations,
        x: &[f64],
        b: &[f64],
        entries: Option<&SaddleBlocks>,
    ) -> Self {
        let operator = equations.operator();
        let mut r = b.to_vec();
        match entries {
            Some(blocks) => blocks.residual(b, &[x], &mut r),
            None => operator.apply_add(-1.0, x, &mut r, &mut vec![0.0; operator.work_len()]),
        }
        let over = |r: f64, scale: f64| if r == 0.0 { 0.0 } else { r / scale };
        let number = |v: f64| v.is_finite().then_some(v);
        let [n_u, n_t, _] = equations.lengths();
        let jumps = equations.contact_scale(x, b);
        let scale = equations.norm_inf() * vector::norm_inf(x) + vector::norm_inf(b);
        Self {
            relative: number(over(vector::norm2(&r), vector::norm2(b))),
            backward: number(over(vector::norm_inf(&r), scale)),
            contact: number(over(
                vector::norm_inf(&r[n_u..n_u + n_t]),
                vector::norm_inf(&jumps),
            )),
        }
    }
}
