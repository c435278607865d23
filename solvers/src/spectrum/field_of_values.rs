//! The field of values of M⁻¹𝒜 where no theorem speaks of its eigenvalues.

use crate::SetupError;
use crate::eigen::{LanczosSettings, extreme_eigenvalues};
use faer::MatRef;
use fracas_operators::{AdjointOperator, Dense, LinearOperator, Shape};
use serde::Serialize;

/// The inner product in which T of the module [`spectrum`](super) is M⁻¹𝒜.
pub(super) const OF_SIMILARITY: &str = "|u|^2 in S_u~ plus |t - C^-1 B^T u|^2 in C";

/// The one of `D M⁻¹𝒜 D⁻¹` with the scales of energy.
pub(super) const OF_SCALES: &str = "Euclidean, in scales of energy";

/// Directions at which the boundary is supported.
const ANGLES: usize = 32;

/// An outer polygon of `W(T) = {v*Tv : ‖v‖ = 1}`.
///
/// For T = Z⁻¹M⁻¹𝒜Z lengths are those of `‖u‖²_{S̃_u} + ‖t − C⁻¹Bᵀu‖²_C`; `inner_product` says which it is. The support function `h(θ) = λ_max(½(e^{−iθ}T + e^{iθ}Tᵀ))` gives half planes `Re(e^{−iθ}z) ≤ h(θ)`; W lies in their
/// intersection and touches every edge line.
///
/// # Cost
/// Lanczos with products with T and Tᵀ at 9 of the 32 angles; the others follow from symmetry.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldOfValues {
    /// Inner product in which W is taken.
    pub inner_product: &'static str,
    /// Directions θ_k = 2πk/32 of the outer normals.
    pub angles: Vec<f64>,
    /// h(θ_k).
    pub support: Vec<f64>,
    /// Real parts of the vertices of the polygon, counter-clockwise.
    pub re: Vec<f64>,
    /// Their imaginary parts.
    pub im: Vec<f64>,
    /// True when a half plane excludes 0: GMRES then converges at a rate that W bounds.
    pub excludes_zero: bool,
}

impl FieldOfValues {
    /// The least Re z.
    pub fn least_real_part(&self) -> f64 {
        -self.support[ANGLES / 2]
    }
}

/// Support function and polygon of a dense T.
pub(super) fn of_matrix(
    t: MatRef<'_, f64>,
    inner_product: &'static str,
) -> Result<FieldOfValues, SetupError> {
    let n = t.nrows();
    let t = Dense::from_fn(Shape::square(n), |i, j| t[(i, j)]);
    let quarter = ANGLES / 4;
    let mut support = vec![0.0; ANGLES];
    for k in 0..=quarter {
        let theta = angle(k);
        let (low, high) = support_pair(&t, theta)?;
        // h(−θ) = h(θ) for a real T, and h(θ + π) = −λ_min
        for (index, value) in [
            (k, high),
            (ANGLES - k, high),
            (ANGLES / 2 + k, -low),
            (ANGLES / 2 - k, -low),
        ] {
            support[index % ANGLES] = value;
        }
    }
    let (mut re, mut im) = (Vec::new(), Vec::new());
    for k in 0..ANGLES {
        let (a, b) = (angle(k), angle(k + 1));
        // Intersection of two neighbouring support lines: x cos θ + y sin θ = h(θ)
        let (p, q) = (support[k], support[(k + 1) % ANGLES]);
        let determinant = (b - a).sin();
        re.push((p * b.sin() - q * a.sin()) / determinant);
        im.push((q * a.cos() - p * b.cos()) / determinant);
    }
    Ok(FieldOfValues {
        inner_product,
        angles: (0..ANGLES).map(angle).collect(),
        excludes_zero: support.iter().any(|h| *h < 0.0),
        support,
        re,
        im,
    })
}

fn angle(k: usize) -> f64 {
    2.0 * std::f64::consts::PI * k as f64 / ANGLES as f64
}

/// λ_min and λ_max of `½(e^{−iθ}T + e^{iθ}Tᵀ) = cos θ·½(T+Tᵀ) − i sin θ·½(T−Tᵀ)` as a real matrix of twice the size.
fn support_pair(t: &Dense<f64>, theta: f64) -> Result<(f64, f64), SetupError> {
    let n = t.shape().rows;
    let (c, s) = (0.5 * theta.cos(), 0.5 * theta.sin());
    let mut hermitian = |x: &[f64], y: &mut [f64]| {
        let (x_re, x_im) = x.split_at(n);
        let (y_re, y_im) = y.split_at_mut(n);
        y_re.fill(0.0);
        y_im.fill(0.0);
        t.apply_add(c, x_re, y_re, &mut []);
        t.apply_adjoint_add(c, x_re, y_re, &mut []);
        t.apply_add(s, x_im, y_re, &mut []);
        t.apply_adjoint_add(-s, x_im, y_re, &mut []);
        t.apply_add(c, x_im, y_im, &mut []);
        t.apply_adjoint_add(c, x_im, y_im, &mut []);
        t.apply_add(-s, x_re, y_im, &mut []);
        t.apply_adjoint_add(s, x_re, y_im, &mut []);
    };
    let settings = LanczosSettings {
        tolerance: 1e-8,
        max_steps: 200,
        ..LanczosSettings::default()
    };
    let (low, high) = extreme_eigenvalues(2 * n, &mut hermitian, None, settings)?;
    Ok((low.value - low.error, high.value + high.error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Mat;

    #[test]
    fn a_jordan_block_has_a_disc_and_a_normal_matrix_the_hull_of_its_eigenvalues() {
        // W([1 1; 0 1]) is the disc of radius ½ around 1.
        let jordan = Mat::from_fn(2, 2, |i, j| if j >= i { 1.0 } else { 0.0 });
        let w = of_matrix(jordan.as_ref(), "").unwrap();
        for (theta, h) in w.angles.iter().zip(&w.support) {
            assert!((h - (theta.cos() + 0.5)).abs() < 1e-8);
        }
        assert!(w.excludes_zero);
        // Rotation by 90° plus 0: the segment from −i to i.
        let rotation = Mat::from_fn(2, 2, |i, j| {
            if i == j {
                0.0
            } else if j > i {
                -1.0
            } else {
                1.0
            }
        });
        let w = of_matrix(rotation.as_ref(), "").unwrap();
        for (theta, h) in w.angles.iter().zip(&w.support) {
            assert!((h - theta.sin().abs()).abs() < 1e-8);
        }
        assert!(!w.excludes_zero);
    }
}
