//! The largest eigenvalue of D⁻¹A, and a bound of the smallest one of M⁻¹A.

use crate::eigen::lanczos::largest_of_tridiagonal;
use fracas_operators::Real;
use fracas_operators::random::signed;
use fracas_operators::vector::{axpy, dot, xpby};

/// Lanczos steps: three digits of an outer eigenvalue that is well separated from nothing.
pub(crate) const STEPS: usize = 10;

/// Lanczos steps that show whether a cycle hardly sees something: a smallest Ritz value of 0.027 after four was 0.021 after ten, and those of 0.18
/// and more were 0.099 and more.
const FEW_STEPS: usize = 4;

/// Lanczos values approach from below; the estimate is at least this factor above them. Unit: 1.
const SAFETY: f64 = 1.05;

/// An upper estimate of `λ_max(D⁻¹A)` for n unknowns by so many `steps`, given `y ← A x` and `z ← D⁻¹ r`.
///
/// # Cost
/// A product per step: the coefficients of conjugate gradients preconditioned by D are a Lanczos matrix of D⁻¹A. Its largest
/// eigenvalue θ is below λ_max; what comes back is the larger of 1.05 θ and θ plus the norm of the residual of its vector.
///
/// # Source
/// Zhou, Li, Lin. Alg. Appl. 435 (2011) 480–493, for the residual.
pub(crate) fn largest_generalized<R: Real>(
    (n, steps): (usize, usize),
    product: impl FnMut(&[R], &mut [R]),
    mut diagonal_solve: impl FnMut(&[R], &mut [R]),
) -> f64 {
    let mut z = vec![R::zero(); n];
    let r = start(n, &mut diagonal_solve, &mut z);
    let Lanczos { diagonal, off, .. } = lanczos(steps, r, z, product, diagonal_solve);
    let theta = largest_of_tridiagonal(&diagonal, &off);
    f64::max(SAFETY * theta, theta + residual(theta, &diagonal, &off))
}

/// The smallest Ritz value of `M⁻¹A` for n unknowns after few steps, given `y ← A x`, `z ← D⁻¹ r` and `z ← M⁻¹ r`: λ_min is at most that; −∞
/// where M is not positive definite.
///
/// # Cost
/// Four products and five solves with M.
pub(crate) fn least_generalized<R: Real>(
    n: usize,
    product: impl FnMut(&[R], &mut [R]),
    mut diagonal_solve: impl FnMut(&[R], &mut [R]),
    solve: impl FnMut(&[R], &mut [R]),
) -> f64 {
    let mut z = vec![R::zero(); n];
    let r = start(n, &mut diagonal_solve, &mut z);
    let Lanczos {
        diagonal,
        off,
        is_definite,
    } = lanczos(FEW_STEPS, r, z, product, solve);
    if !is_definite {
        return f64::NEG_INFINITY;
    }
    let most = largest_of_tridiagonal(&diagonal, &off);
    let below: Vec<f64> = diagonal.iter().map(|d| most - d).collect();
    most - largest_of_tridiagonal(&below, &off)
}

/// A Lanczos matrix.
struct Lanczos {
    diagonal: Vec<f64>,
    off: Vec<f64>,
    /// No rᵀM⁻¹r was negative beyond rounding.
    is_definite: bool,
}

/// The Lanczos matrix of `M⁻¹A` that begins with r, given `y ← A x` and `z ← M⁻¹ r`; z is scratch.
fn lanczos<R: Real>(
    steps: usize,
    mut r: Vec<R>,
    mut z: Vec<R>,
    mut product: impl FnMut(&[R], &mut [R]),
    mut solve: impl FnMut(&[R], &mut [R]),
) -> Lanczos {
    let [mut p, mut q] = [0; 2].map(|_| vec![R::zero(); r.len()]);
    let (mut diagonal, mut off) = (Vec::new(), Vec::new());
    let (mut beta, mut alpha_before) = (0.0, 1.0);
    solve(&r, &mut z);
    p.copy_from_slice(&z);
    let mut rho = dot(&r, &z).to_f64_exact();
    let (rounding, first, mut most) = (R::epsilon().to_f64_exact(), rho, 0.0f64);
    for _ in 0..steps {
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
        solve(&r, &mut z);
        let next = dot(&r, &z).to_f64_exact();
        beta = next / rho;
        off.push(beta.max(0.0).sqrt() / alpha);
        xpby(&z, R::of(beta), &mut p);
        (rho, alpha_before) = (next, alpha);
    }
    Lanczos {
        diagonal,
        off,
        is_definite: rho >= -rounding * first.abs(),
    }
}

/// A vector r with a part in every eigenvector, the same on every machine: white noise with the weight √D at every node. A wave would
/// be nearly an eigenvector on a regular grid; without the weight stiff regions, whose share of `rᵀD⁻¹r` falls with their stiffness,
/// would not be heard in ten steps.
fn start<R: Real>(
    n: usize,
    diagonal_solve: &mut impl FnMut(&[R], &mut [R]),
    z: &mut [R],
) -> Vec<R> {
    let mut r: Vec<R> = (0..n as u64).map(|i| R::of(signed(i))).collect();
    diagonal_solve(&r, z);
    let norm = |v: &[R]| dot(v, v).to_f64_exact().sqrt();
    for (r, z) in r.chunks_mut(3).zip(z.chunks(3)) {
        let weight = (norm(r) / norm(z)).sqrt();
        // fixed nodes have no D⁻¹
        if weight.is_finite() {
            r.iter_mut().for_each(|r| *r *= R::of(weight));
        }
    }
    r
}

/// `|β s_k|`: the norm of `D⁻¹A v − θ v` for the Lanczos vector v of the largest eigenvalue θ of the k × k matrix, from its
/// last component; the last of k entries `off` is β, 0 where there are fewer.
fn residual(theta: f64, diagonal: &[f64], off: &[f64]) -> f64 {
    let k = diagonal.len();
    let Some(beta) = off.get(k.wrapping_sub(1)) else {
        return 0.0;
    };
    // upwards from s_k = 1: the components of the outermost vector grow that way
    let (mut below, mut s, mut square) = (0.0, 1.0, 1.0);
    for i in (0..k - 1).rev() {
        let coupled = if i + 2 < k { off[i + 1] * below } else { 0.0 };
        (below, s) = (s, ((theta - diagonal[i + 1]) * s - coupled) / off[i]);
        square += s * s;
    }
    // two parts that nothing couples leave 0/0: no residual then
    let residual = beta / f64::sqrt(square);
    if residual.is_finite() { residual } else { 0.0 }
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
            let value = largest_generalized((n, STEPS), product, |r: &[f64], z: &mut [f64]| {
                z.copy_from_slice(r)
            });
            let exact = 2.0 + 2.0 * (std::f64::consts::PI / n as f64).cos();
            assert!(
                (value / SAFETY - exact).abs() < 1e-6 * exact,
                "{n}: {value} {exact}"
            );
        }
    }

    /// A chain of springs, stiff and fixed at its end, then soft: the largest eigenvalue of D⁻¹A is local to the stiff part,
    /// which the soft one, with an own spring at every node, does not have.
    #[test]
    fn a_contrast_hides_no_stiff_region() {
        let n = 600;
        let stiff = |i: usize| i < n / 2;
        for contrast in [1.0, 1e3, 1e6, 1e9] {
            let spring = |i: usize| if stiff(i) { contrast } else { 1.0 };
            let own = |i: usize| if stiff(i) { 0.0 } else { 2.0 };
            let diagonal = |i: usize| spring(i) + if i > 0 { spring(i - 1) } else { 0.0 } + own(i);
            let product = |x: &[f64], y: &mut [f64]| {
                for i in 0..n {
                    let left = if i > 0 { spring(i - 1) * x[i - 1] } else { 0.0 };
                    let right = if i + 1 < n { spring(i) * x[i + 1] } else { 0.0 };
                    y[i] = diagonal(i) * x[i] - left - right;
                }
            };
            let solve = |r: &[f64], z: &mut [f64]| (0..n).for_each(|i| z[i] = r[i] / diagonal(i));
            let value = largest_generalized((n, STEPS), product, solve);
            // the stiff part alone has 1 + cos(π/(n/2 + 1)) and a little less: 2 to four digits
            assert!(value > 1.97 && value < 2.15, "{contrast}: {value}");
        }
    }

    #[test]
    fn what_m_hardly_sees_is_found_among_much_that_it_solves() {
        // A = 1, M⁻¹ = 1 but for a few entries
        for (n, least) in [(10, 0.5), (500, 0.02), (5000, 1e-3)] {
            let factor = |i: usize| if i % 50 == 7 { least } else { 1.0 };
            let solve = |r: &[f64], z: &mut [f64]| (0..n).for_each(|i| z[i] = factor(i) * r[i]);
            let copy = |x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
            let found = least_generalized(n, copy, copy, solve);
            assert!((found - least).abs() < 1e-9, "{n}: {found} {least}");
        }
    }

    #[test]
    fn an_indefinite_m_is_told() {
        let solve = |r: &[f64], z: &mut [f64]| {
            (0..r.len()).for_each(|i| z[i] = if i == 7 { -2.0 } else { 1.0 } * r[i])
        };
        let copy = |x: &[f64], y: &mut [f64]| y.copy_from_slice(x);
        assert_eq!(least_generalized(30, copy, copy, solve), f64::NEG_INFINITY);
    }

    /// Eigenvalues that thin out towards the largest one, of which r has little.
    #[test]
    fn more_steps_find_an_eigenvalue_that_hardly_stands_out() {
        let n = 20_000;
        let value = |i: usize| 1.0 - (i as f64 / n as f64).powf(0.25);
        let product = |x: &[f64], y: &mut [f64]| (0..n).for_each(|i| y[i] = value(i) * x[i]);
        let copy = |r: &[f64], z: &mut [f64]| z.copy_from_slice(r);
        let error = |steps| 1.0 - largest_generalized((n, steps), product, copy) / SAFETY;
        assert!(error(40) < 0.2 * error(10), "{} {}", error(10), error(40));
    }

    #[test]
    fn the_residual_is_that_of_the_largest_pair() {
        // two steps: T = [2 1; 1 2], θ = 3 with (1, 1)/√2
        let value = residual(3.0, &[2.0, 2.0], &[1.0, 0.5]);
        assert!((value - 0.5 / 2f64.sqrt()).abs() < 1e-14);
        assert_eq!(residual(3.0, &[2.0, 2.0], &[1.0]), 0.0);
        assert_eq!(residual(2.0, &[2.0, 1.0], &[0.0, 0.5]), 0.0);
    }

    #[test]
    fn bisection_finds_the_largest_eigenvalue_of_the_second_difference() {
        let n = 12;
        let value = largest_of_tridiagonal(&vec![2.0; n], &vec![-1.0; n]);
        let exact = 2.0 - 2.0 * (n as f64 * std::f64::consts::PI / (n as f64 + 1.0)).cos();
        assert!((value - exact).abs() < 1e-9);
    }
}
