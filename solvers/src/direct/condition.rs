//! Estimate of ‖A⁻¹‖₁ from a few solves.

use super::Factorization;
use fracas_operators::sparse::SparseMatrix;

/// Estimate of `1 / κ₁(A) = 1 / (‖A‖₁ ‖A⁻¹‖₁)`; 0 when the factors are not finite.
///
/// The estimate of ‖A⁻¹‖₁ is a lower bound, almost always within a factor 3, so κ₁ is at least what this says.
///
/// # Cost
/// Between 4 and 11 solves.
///
/// # Source
/// N. J. Higham, ACM Trans. Math. Softw. 14 (1988) 381–396, algorithm 4.1 (LAPACK's xLACON).
pub fn reciprocal_condition(a: &SparseMatrix<f64>, factors: &dyn Factorization) -> f64 {
    let norm = norm1(a);
    let inverse = inverse_norm1(factors);
    let condition = norm * inverse;
    if factors.size() == 0 {
        1.0
    } else if condition.is_finite() && condition > 0.0 {
        1.0 / condition
    } else {
        0.0
    }
}

/// `‖A‖₁ = max_j Σ_i |a_ij|`.
fn norm1(a: &SparseMatrix<f64>) -> f64 {
    let mut sums = vec![0.0; a.cols()];
    for (outer, vector) in a.outer_iterator().enumerate() {
        for (inner, value) in vector.iter() {
            sums[if a.is_csr() { inner } else { outer }] += value.abs();
        }
    }
    sums.into_iter().fold(0.0, f64::max)
}

/// Lower bound of `‖A⁻¹‖₁`; NaN or infinite when the factors are.
fn inverse_norm1(factors: &dyn Factorization) -> f64 {
    const MAX_STEPS: usize = 5;
    let n = factors.size();
    let mut work = vec![0.0; factors.work_len()];
    let (mut x, mut y) = (vec![1.0 / n as f64; n], vec![0.0; n]);
    let mut signs = vec![0.0; n];
    let mut estimate = 0.0;
    for step in 0..MAX_STEPS {
        // y = A⁻¹ x, a candidate for the maximum of ‖A⁻¹ x‖₁ over ‖x‖₁ = 1
        factors.solve(&x, &mut y, &mut work);
        let norm: f64 = y.iter().map(|v| v.abs()).sum();
        if !norm.is_finite() {
            return norm;
        }
        let unchanged = y.iter().zip(&signs).all(|(v, s)| v.signum() == *s);
        if step > 0 && (norm <= estimate || unchanged) {
            estimate = norm.max(estimate);
            break;
        }
        estimate = norm;
        // z = A⁻ᵀ sign(y) is a subgradient; its largest entry shows the next unit vector
        for (s, v) in signs.iter_mut().zip(&y) {
            *s = v.signum();
        }
        factors.solve_adjoint(&signs, &mut y, &mut work);
        let Some(j) = (0..n).max_by(|&i, &j| y[i].abs().total_cmp(&y[j].abs())) else {
            break;
        };
        let bound: f64 = x.iter().zip(&y).map(|(x, z)| x * z).sum();
        if step > 0 && y[j].abs() <= bound {
            break;
        }
        x.fill(0.0);
        x[j] = 1.0;
    }
    // A vector of alternating sign and growing size guards against exact cancellation.
    for (i, v) in x.iter_mut().enumerate() {
        let size = 1.0 + i as f64 / (n.max(2) - 1) as f64;
        *v = if i % 2 == 0 { size } else { -size };
    }
    factors.solve(&x, &mut y, &mut work);
    let alternating: f64 = 2.0 / (3.0 * n as f64) * y.iter().map(|v| v.abs()).sum::<f64>();
    if alternating.is_finite() {
        estimate.max(alternating)
    } else {
        alternating
    }
}
