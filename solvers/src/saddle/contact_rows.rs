//! The contact rows of a saddle point, as RACP takes them.

use super::AugmentationMatrix;
use fracas_operators::Preconditioner;

/// C⁻¹ of the rows k that constrain a jump, and rows l with a law `−Λ t_l − L_lk t_k = x_l` for their own traction. Everything of
/// the list of augmentations has no rows l.
pub trait ContactRows: Preconditioner<f64> {
    /// `w_k ← x_k` in the scale of a jump, `w_l ← 0`.
    fn keep(&self, x_t: &[f64], w_t: &mut [f64]) {
        w_t.copy_from_slice(x_t);
    }

    /// `y_l ← y_l + Λ⁻¹ x_l`.
    fn add_laws(&self, _x_t: &[f64], _y_t: &mut [f64]) {}

    /// `y_l ← −Λ⁻¹ (x_l + L_lk y_k)`, of the y_l = 0 that C⁻¹ leaves.
    fn solve_laws(&self, _x_t: &[f64], _y_t: &mut [f64]) {}

    /// Floating-point operations of the three.
    fn law_flops(&self) -> u64 {
        0
    }
}

impl ContactRows for AugmentationMatrix {}
