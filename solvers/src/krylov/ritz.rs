//! The Ritz value nearest to zero: how much smaller than the error `M⁻¹r` may be.

use super::run::carve;
use fracas_operators::Real;
use fracas_operators::vector::norm2;

/// Steps of inverse iteration; the growth over the second half counts. Unit: 1.
const STEPS: usize = 32;

/// Steps of a short recurrence whose coefficients are kept: beyond that many the extreme Ritz values have settled.
const KEPT: usize = 400;

/// The Ritz value nearest to zero of several iterations with one M⁻¹𝒜, some of which know none.
pub fn least(seen: [Option<f64>; 2]) -> Option<f64> {
    seen.into_iter().flatten().reduce(f64::min)
}

/// `|θ| = (‖y_m‖/‖y_{2m}‖)^{1/m}` with `y ← T⁻¹ y`, the modulus also of a complex pair; `None` where T is singular.
pub(super) fn nearest_to_zero<R: Real>(y: &mut [R], mut solve: impl FnMut(&mut [R])) -> Option<R> {
    y.fill(R::one());
    let mut logarithm = R::zero();
    for step in 0..STEPS {
        solve(y);
        let growth = norm2(y);
        if !growth.is_finite() || growth <= R::zero() {
            return None;
        }
        y.iter_mut().for_each(|y| *y /= growth);
        if step >= STEPS / 2 {
            logarithm += growth.ln();
        }
    }
    Some((-logarithm / R::of((STEPS - STEPS / 2) as f64)).exp())
}

/// The coefficients of a coupled two-term recurrence,
/// ```text
/// A q_k = (r_k − r_{k+1})/α_k        q_k = M⁻¹r_k + β_k q_{k−1}
/// ```
/// so `A M⁻¹ R = R L D⁻¹ U`: L = unit lower bidiagonal with −1, D = diag α, U = unit upper bidiagonal with −β.
pub(super) struct Coefficients<'w, R> {
    k: usize,
    alpha: &'w mut [R],
    /// β of the step after.
    beta: &'w mut [R],
    /// ‖r_k‖, so that the matrix is that of normalised residuals.
    norm: &'w mut [R],
    y: &'w mut [R],
}

impl<'w, R: Real> Coefficients<'w, R> {
    /// Entries that they need.
    pub(super) fn work_len(max_iterations: usize) -> usize {
        4 * max_iterations.min(KEPT)
    }

    pub(super) fn new(max_iterations: usize, work: &mut &'w mut [R]) -> Self {
        let [alpha, beta, norm, y] = [0; 4].map(|_| carve(work, max_iterations.min(KEPT)));
        Self {
            k: 0,
            alpha,
            beta,
            norm,
            y,
        }
    }

    /// α_k of a step from a residual of norm `‖r_k‖`.
    pub(super) fn advance(&mut self, alpha: R, norm: R) {
        if self.k < self.alpha.len() {
            (self.alpha[self.k], self.norm[self.k]) = (alpha, norm);
            self.beta[self.k] = R::zero();
            self.k += 1;
        }
    }

    /// `β_{k+1}`, which leads to the next step.
    pub(super) fn turn(&mut self, beta: R) {
        if self.k < self.alpha.len() && self.k > 0 {
            self.beta[self.k - 1] = beta;
        }
    }

    /// Modulus of the Ritz value of `A M⁻¹` nearest to zero.
    pub(super) fn ritz_nearest_to_zero(&mut self) -> Option<R> {
        let k = self.k;
        if k == 0 {
            return None;
        }
        let (alpha, beta, norm) = (&*self.alpha, &*self.beta, &*self.norm);
        nearest_to_zero(&mut self.y[..k], |y| {
            // U⁻¹ D L⁻¹ y in the basis of residuals
            let mut sum = R::zero();
            for j in 0..k {
                sum += y[j] / norm[j];
                y[j] = alpha[j] * sum;
            }
            for j in (0..k - 1).rev() {
                y[j] += beta[j] * y[j + 1];
            }
            y.iter_mut().zip(norm).for_each(|(y, norm)| *y *= *norm);
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::*;
    use super::super::{Cg, Fgmres, Gmres, KrylovMethod, Sqmr};
    use fracas_operators::laws::probe;

    /// Condition 10⁴ with one small eigenvalue far from the others.
    #[test]
    fn the_eigenvalue_nearest_to_zero_is_found_by_every_method_that_says_one() {
        let n = 40;
        for small in [1.0, -1.0] {
            let value = |k: usize| {
                if k == 0 {
                    1e-3 * small
                } else {
                    1.0 + k as f64 / 4.0
                }
            };
            let a = with_eigenvalues(&(0..n).map(value).collect::<Vec<_>>(), 5);
            let m = exact(&spd(n, 9));
            let product = {
                let (a, m) = (faer_of(&a), faer_of(&m.0));
                a * m
            };
            let spectrum = crate::eigen::dense::general_eigenvalues(product.as_ref()).unwrap();
            let nearest = (spectrum.iter()).fold(f64::INFINITY, |s, v| s.min(v.re.hypot(v.im)));
            let mut methods: Vec<Box<dyn KrylovMethod<f64>>> = vec![
                Box::new(Gmres::default()),
                Box::new(Fgmres::default()),
                Box::new(Sqmr {}),
            ];
            if small > 0.0 {
                methods.push(Box::new(Cg {}));
            }
            for method in methods {
                let (_, report) = solve(&*method, &a, &m, &probe(n, 3), until(1e-10, 200));
                let ritz = report.unwrap().smallest_ritz.unwrap();
                let off = (ritz / nearest).ln().abs();
                assert!(off < 0.05, "{}: {ritz:e}, not {nearest:e}", method.name());
            }
        }
    }

    /// `[c −s; s c]` has the pair c ± i s of modulus 1.
    #[test]
    fn of_a_complex_pair_it_is_the_modulus() {
        let (c, s) = (0.6, 0.8);
        let inverse = |y: &mut [f64]| (y[0], y[1]) = (c * y[0] + s * y[1], c * y[1] - s * y[0]);
        let found = super::nearest_to_zero(&mut [0.0; 2], inverse).unwrap();
        assert!((found - 1.0).abs() < 1e-12, "{found}");
    }
}
