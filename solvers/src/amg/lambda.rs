//! The largest eigenvalue of D⁻¹A.

use super::sweeps::SweepMatrix;
use fracas_operators::Real;
use fracas_operators::vector::{axpy, dot, xpby};

/// Lanczos steps: three digits of an outer eigenvalue that is well separated from nothing.
const STEPS: usize = 10;

/// Lanczos values approach from below; this factor covers what ten steps leave. Unit: 1.
const SAFETY: f64 = 1.05;

/// An upper estimate of `λ_max(D⁻¹A)`, D the 3×3 diagonal blocks.
pub(super) fn largest_eigenvalue<R: Real>(a: &SweepMatrix<R>) -> f64 {
    let product = |x: &[R], y: &mut [R]| a.product(x, y);
    largest_generalized(3 * a.rows(), product, |r, z| a.diagonal_solve(r, z))
}

/// An upper estimate of `λ_max(D⁻¹A)` for n unknowns, given `y ← A x` and `z ← D⁻¹ r`.
///
/// # Cost
/// Ten products: the coefficients of conjugate gradients preconditioned by D are a Lanczos matrix of D⁻¹A.
pub(crate) fn largest_generalized<R: Real>(
    n: usize,
    mut product: impl FnMut(&[R], &mut [R]),
    diagonal_solve: impl Fn(&[R], &mut [R]),
) -> f64 {
    // a start with a part in every eigenvector, the same on every machine
    let mut r: Vec<R> = (0..n)
        .map(|i| R::of(0.1 + (1.0 + i as f64 * 1.618).sin()))
        .collect();
    let [mut z, mut p, mut q] = [0; 3].map(|_| vec![R::zero(); n]);
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    let (mut beta, mut alpha_before) = (0.0, 1.0);
    diagonal_solve(&r, &mut z);
    p.copy_from_slice(&z);
    let mut rho = dot(&r, &z).to_f64_exact();
    let (rounding, first, mut most) = (R::epsilon().to_f64_exact(), rho, 0.0f64);
    for _ in 0..STEPS {
        // few unknowns: what follows the last direction would be rounding
        if rho.is_nan() || rho <= rounding * rounding * first {
            break;
        }
        product(&p, &mut q);
        let curvature = dot(&p, &q).to_f64_exact();
        // a direction in the kernel: 1/α = 0, and nothing after it
        if curvature.is_nan() || curvature <= rounding * most * rho {
            diagonal.push(beta / alpha_before);
            break;
        }
        let alpha = rho / curvature;
        let entry = 1.0 / alpha + beta / alpha_before;
        diagonal.push(entry);
        most = entry.max(most);
        axpy(R::of(-alpha), &q, &mut r);
        diagonal_solve(&r, &mut z);
        let next = dot(&r, &z).to_f64_exact();
        beta = next / rho;
        off.push(beta.max(0.0).sqrt() / alpha);
        xpby(&z, R::of(beta), &mut p);
        (rho, alpha_before) = (next, alpha);
    }
    SAFETY * largest_of_tridiagonal(&diagonal, &off)
}

/// Largest eigenvalue of a symmetric tridiagonal matrix by bisection on the count of negative pivots.
fn largest_of_tridiagonal(diagonal: &[f64], off: &[f64]) -> f64 {
    let n = diagonal.len();
    let radius = |i: usize| {
        let left = if i > 0 { off[i - 1].abs() } else { 0.0 };
        let right = if i + 1 < n { off[i].abs() } else { 0.0 };
        left + right
    };
    let mut high = (0..n).map(|i| diagonal[i] + radius(i)).fold(0.0, f64::max);
    let mut low = diagonal.iter().copied().fold(0.0, f64::max);
    let above = |x: f64| {
        // x exceeds every eigenvalue if all pivots of x − T are positive
        let mut pivot = 1.0;
        (0..n).all(|i| {
            let coupling = if i > 0 { off[i - 1] * off[i - 1] } else { 0.0 };
            pivot = x - diagonal[i] - coupling / pivot;
            pivot > 0.0
        })
    };
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if above(middle) {
            high = middle
        } else {
            low = middle
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_unknowns_and_a_kernel_leave_no_rounding() {
        // a path of n nodes: λ_max = 2 + 2 cos(π/n), kernel of constants
        for n in 2..9usize {
            let product = |x: &[f64], y: &mut [f64]| {
                for i in 0..n {
                    let [left, right] = [i.checked_sub(1), (i + 1 < n).then_some(i + 1)];
                    let near = [left, right].into_iter().flatten();
                    y[i] = near.map(|j| x[i] - x[j]).sum();
                }
            };
            let value =
                largest_generalized(n, product, |r: &[f64], z: &mut [f64]| z.copy_from_slice(r));
            let exact = 2.0 + 2.0 * (std::f64::consts::PI / n as f64).cos();
            assert!(
                (value / SAFETY - exact).abs() < 1e-6 * exact,
                "{n}: {value} {exact}"
            );
        }
    }

    #[test]
    fn bisection_finds_the_largest_eigenvalue_of_the_second_difference() {
        let n = 12;
        let value = largest_of_tridiagonal(&vec![2.0; n], &vec![-1.0; n]);
        let exact = 2.0 - 2.0 * (n as f64 * std::f64::consts::PI / (n as f64 + 1.0)).cos();
        assert!((value - exact).abs() < 1e-9);
    }
}
