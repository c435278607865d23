//! Extreme eigenvalues of a symmetric pencil by the three-term Lanczos recurrence.

use super::dense;
use crate::SetupError;
use faer::Mat;
use fracas_operators::laws::probe;
use fracas_operators::vector::{axpy, dot, norm_inf, scale};
use std::ops::ControlFlow;

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LanczosSettings {
    /// Relative error bound wanted.
    pub tolerance: f64,
    /// Most products.
    pub max_steps: usize,
    /// Which end decides when to stop.
    pub ends: Ends,
    /// Steps, at least one, before the first look at Ritz values, and half as many between later ones. Each look costs an eigenvalue problem of as
    /// many rows as there were steps.
    pub patience: usize,
}

/// Ends of the spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// Stop when both ends are sharp.
    Both,
    /// Stop when the largest eigenvalue is sharp; the smallest is whatever was reached.
    Largest,
}

/// Chance that an eigenvalue is beyond what is known of it. Unit: 1.
const CHANCE: f64 = 1e-9;

impl LanczosSettings {
    /// So many steps that, however the eigenvalues of a positive semi-definite matrix of n rows lie, the largest Ritz value is below
    /// `(1 − share) λ_max` in one of 10⁹ cases at most: for k steps from a start drawn at random in no more than
    /// `1.648 √n e^{−√share (2k − 1)}` of them. The start is one such draw, the same for every matrix. What residuals say is that some
    /// eigenvalue is near, not that the largest is.
    ///
    /// # Source
    /// J. Kuczyński, H. Woźniakowski, SIAM J. Matrix Anal. Appl. 13 (1992) 1094–1122, Theorem 4.2.
    pub fn within(n: usize, share: f64, ends: Ends) -> Self {
        let needed = (1.648 * (n as f64).sqrt() / CHANCE).ln() / share.sqrt();
        let steps = (0.5 * (needed + 1.0)).ceil() as usize;
        Self {
            max_steps: steps,
            patience: steps,
            ends,
            ..Self::default()
        }
    }

    /// The default accuracy for the largest eigenvalue only.
    pub fn one_sided() -> Self {
        Self {
            ends: Ends::Largest,
            ..Self::default()
        }
    }
}

impl Default for LanczosSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-12,
            max_steps: 600,
            ends: Ends::Both,
            patience: 8,
        }
    }
}

/// An eigenvalue with its error bar.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Extreme {
    /// Ritz value.
    pub value: f64,
    /// An eigenvalue lies within this of `value`: `min(ρ, ρ²/gap)` with the residual norm ρ and the distance to the
    /// next Ritz value.
    pub error: f64,
    /// Products used.
    pub steps: usize,
}

impl Extreme {
    /// The same value in another unit.
    fn times(self, unit: f64) -> Self {
        Self {
            value: self.value * unit,
            error: self.error * unit,
            ..self
        }
    }
}

/// `y ← f(x)` with scratch memory of its own.
pub type Map<'a> = dyn FnMut(&[f64], &mut [f64]) + 'a;

/// Smallest and largest eigenvalue of `K v = λ M v` for symmetric K and SPD M.
///
/// `apply` is y ← K x; `solve` is y ← M⁻¹ x, `None` for M = I. With z = M⁻¹ r:
/// `K v_k = β_{k+1} M v_{k+1} + α_k M v_k + β_k M v_{k−1}`.
///
/// No reorthogonalization: lost orthogonality repeats converged Ritz values, which changes no extreme one. Start
/// vectors are fixed.
///
/// # Cost
/// One product and one solve a step, six vectors.
///
/// # Source
/// C. C. Paige, Linear Algebra Appl. 34 (1980) 235–258, for the error bounds without reorthogonalization.
pub fn extreme_eigenvalues(
    n: usize,
    apply: &mut Map<'_>,
    mut solve: Option<&mut Map<'_>>,
    settings: LanczosSettings,
) -> Result<(Extreme, Extreme), SetupError> {
    let mut lanczos = Lanczos::new(n, settings)?;
    loop {
        if let Some(solve) = &mut solve {
            solve(&lanczos.r, &mut lanczos.z);
        } else {
            lanczos.z.copy_from_slice(&lanczos.r);
        }
        if let Some(found) = lanczos.advance()? {
            return Ok(found);
        }
        apply(&lanczos.v, &mut lanczos.r);
        lanczos.recur();
    }
}

/// The recurrence of [`extreme_eigenvalues`], a product at a time: several of them may share the work of their products.
pub struct Lanczos {
    settings: LanczosSettings,
    r: Vec<f64>,
    z: Vec<f64>,
    v: Vec<f64>,
    p: Vec<f64>,
    p_old: Vec<f64>,
    alphas: Vec<f64>,
    betas: Vec<f64>,
    next_check: usize,
    last: Option<(f64, f64)>,
    unit: f64,
    /// All v so far, where the vector of the largest eigenvalue is wanted.
    basis: Option<Vec<Vec<f64>>>,
}

impl Lanczos {
    /// Before the first product.
    ///
    /// # Errors
    /// An empty matrix.
    pub fn new(n: usize, settings: LanczosSettings) -> Result<Self, SetupError> {
        if n == 0 {
            return Err(SetupError::NotApplicable {
                method: "Lanczos",
                reason: "the matrix is empty".to_owned(),
            });
        }
        let zeros = || vec![0.0; n];
        Ok(Self {
            settings,
            r: probe(n, 11),
            z: zeros(),
            v: zeros(),
            p: zeros(),
            p_old: zeros(),
            alphas: Vec::new(),
            betas: Vec::new(),
            next_check: settings.patience.min(n),
            last: None,
            unit: 1.0,
            basis: None,
        })
    }

    /// The same from a start of one's own, which is not zero, for M = I and few steps: vectors are kept for
    /// [`largest_vector`](Self::largest_vector), and later ones are orthogonal to all of them.
    ///
    /// # Errors
    /// An empty matrix.
    pub fn from_start(start: Vec<f64>, settings: LanczosSettings) -> Result<Self, SetupError> {
        let new = Self::new(start.len(), settings)?;
        Ok(Self {
            r: start,
            basis: Some(Vec::new()),
            ..new
        })
    }

    /// The Ritz vector of the largest eigenvalue, of length 1, from a start of one's own.
    ///
    /// # Errors
    /// Of the eigenvalue problem of the tridiagonal matrix.
    pub fn largest_vector(&self) -> Result<Vec<f64>, SetupError> {
        let k = self.alphas.len();
        let mut vector = vec![0.0; self.v.len()];
        if k > 0 {
            let (_, of_t) =
                dense::symmetric_eigen(tridiagonal(&self.alphas, &self.betas[1..k]).as_ref())?;
            let basis = self.basis.iter().flatten();
            (basis.enumerate()).for_each(|(j, v)| axpy(of_t[(j, k - 1)], v, &mut vector));
        }
        Ok(vector)
    }

    /// For M = I: what was found, or the vector v of the next product.
    ///
    /// # Errors
    /// NaN or infinity in a product.
    pub fn next_vector(&mut self) -> Result<ControlFlow<(Extreme, Extreme), &[f64]>, SetupError> {
        self.z.copy_from_slice(&self.r);
        Ok(match self.advance()? {
            Some(found) => ControlFlow::Break(found),
            None => ControlFlow::Continue(&self.v),
        })
    }

    /// Takes K v.
    pub fn take(&mut self, product: impl Iterator<Item = f64>) {
        self.r.iter_mut().zip(product).for_each(|(r, y)| *r = y);
        self.recur();
    }

    /// From r and `z = M⁻¹ r`: β² = rᵀ M⁻¹ r, v = M⁻¹ r / β, p = M v.
    fn advance(&mut self) -> Result<Option<(Extreme, Extreme)>, SetupError> {
        let settings = self.settings;
        let beta = dot(&self.r, &self.z).max(0.0).sqrt();
        let k = self.alphas.len();
        // the first β is the length of the start, which says nothing of the operator
        let each = self.alphas.iter().chain(self.betas.iter().skip(1));
        let size = each.fold(0.0f64, |m, v| m.max(v.abs()));
        let exhausted = k > 0 && beta <= 1e-15 * size;
        if !beta.is_finite() {
            return Err(SetupError::NotApplicable {
                method: "Lanczos",
                reason: format!(
                    "the recurrence broke down at step {k}: NaN or infinity in a block"
                ),
            });
        }
        if k > 0 && (exhausted || k == self.next_check || k == settings.max_steps) {
            let next = if exhausted { 0.0 } else { beta };
            let (low, high) = ritz(&self.alphas, &self.betas[1..], next)?;
            let settled = |now: f64, before: f64| {
                (now - before).abs() <= 10.0 * settings.tolerance * now.abs()
            };
            let stable = self.last.is_some_and(|(l, h)| {
                settled(high.value, h) && (settings.ends == Ends::Largest || settled(low.value, l))
            });
            let sharp = |e: &Extreme| {
                e.error <= settings.tolerance * e.value.abs().max(f64::EPSILON * size)
            };
            let enough = match settings.ends {
                Ends::Both => sharp(&low) && sharp(&high),
                Ends::Largest => sharp(&high),
            };
            if exhausted || (stable && enough) || k >= settings.max_steps {
                return Ok(Some((low.times(self.unit), high.times(self.unit))));
            }
            self.last = Some((low.value, high.value));
            let until_next = (k / 8).max(settings.patience.div_ceil(2));
            self.next_check = (k + until_next).min(settings.max_steps);
        }
        if k == 0 && beta == 0.0 {
            return Err(SetupError::NotApplicable {
                method: "Lanczos",
                reason: "M is not positive definite".to_owned(),
            });
        }
        self.betas.push(beta);
        std::mem::swap(&mut self.p, &mut self.p_old);
        self.p.copy_from_slice(&self.r);
        scale(1.0 / beta, &mut self.p);
        self.v.copy_from_slice(&self.z);
        scale(1.0 / beta, &mut self.v);
        Ok(None)
    }

    /// `r = K v − α p − β p_old` from `r = K v`.
    fn recur(&mut self) {
        let k = self.alphas.len();
        if k == 0 {
            self.unit = power_of_two(norm_inf(&self.r));
        }
        if self.unit != 1.0 {
            scale(1.0 / self.unit, &mut self.r);
        }
        let alpha = dot(&self.r, &self.v);
        self.alphas.push(alpha);
        axpy(-alpha, &self.p, &mut self.r);
        if k > 0 {
            axpy(-self.betas[k], &self.p_old, &mut self.r);
        }
        if let Some(basis) = &mut self.basis {
            basis.push(self.v.clone());
            for v in basis.iter() {
                let along = dot(&self.r, v);
                axpy(-along, v, &mut self.r);
            }
        }
    }
}

/// The unit in which squares of `size` neither overflow nor vanish: 1 unless the numbers are extreme.
fn power_of_two(size: f64) -> f64 {
    const SAFE: std::ops::Range<f64> = 1e-100..1e100;
    if size == 0.0 || !size.is_finite() || SAFE.contains(&size) {
        1.0
    } else {
        size.log2().round().exp2()
    }
}

/// The tridiagonal matrix of the recurrence.
fn tridiagonal(alphas: &[f64], betas: &[f64]) -> Mat<f64> {
    Mat::from_fn(alphas.len(), alphas.len(), |i, j| {
        match (i.max(j), i.abs_diff(j)) {
            (_, 0) => alphas[i],
            (later, 1) => betas[later - 1],
            _ => 0.0,
        }
    })
}

/// Extreme Ritz values of the tridiagonal matrix with their bounds; `next` is the β of the residual.
fn ritz(alphas: &[f64], betas: &[f64], next: f64) -> Result<(Extreme, Extreme), SetupError> {
    let k = alphas.len();
    let (values, vectors) = dense::symmetric_eigen(tridiagonal(alphas, betas).as_ref())?;
    let size = values[0].abs().max(values[k - 1].abs());
    let bar = |index: usize| {
        let residual = next * vectors[(k - 1, index)].abs();
        let far = |other: &f64| {
            let distance = (other - values[index]).abs();
            (distance > 10.0 * residual && distance > 1e-9 * size).then_some(distance)
        };
        let gap = values.iter().filter_map(far).fold(f64::INFINITY, f64::min);
        let squared = if gap.is_finite() {
            residual * residual / gap
        } else {
            residual
        };
        Extreme {
            value: values[index],
            error: residual
                .min(squared)
                .max(f64::EPSILON * values[index].abs()),
            steps: k,
        }
    };
    Ok((bar(0), bar(k - 1)))
}

/// Largest eigenvalue of a symmetric tridiagonal matrix by bisection on the count of negative pivots.
pub(crate) fn largest_of_tridiagonal(diagonal: &[f64], off: &[f64]) -> f64 {
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
    fn extremes_of_the_1d_laplacian_and_of_a_pencil() {
        let n = 200;
        let laplacian = |x: &[f64], y: &mut [f64]| {
            for i in 0..n {
                let left = if i > 0 { x[i - 1] } else { 0.0 };
                let right = if i + 1 < n { x[i + 1] } else { 0.0 };
                y[i] = 2.0 * x[i] - left - right;
            }
        };
        let exact = |k: f64| 2.0 - 2.0 * (k * std::f64::consts::PI / (n + 1) as f64).cos();
        let (low, high) =
            extreme_eigenvalues(n, &mut { laplacian }, None, LanczosSettings::default()).unwrap();
        assert!((low.value / exact(1.0) - 1.0).abs() < 1e-9, "{low:?}");
        assert!(
            (high.value / exact(n as f64) - 1.0).abs() < 1e-11,
            "{high:?}"
        );

        // K = D Laplacian D, M = D²: the same eigenvalues for any diagonal D.
        let d: Vec<f64> = (0..n).map(|i| 10f64.powf((i % 7) as f64 - 3.0)).collect();
        let mut t = vec![0.0; n];
        let (mut u, e) = (vec![0.0; n], d.clone());
        let mut apply = |x: &[f64], y: &mut [f64]| {
            for i in 0..n {
                t[i] = d[i] * x[i];
            }
            laplacian(&t, &mut u);
            for i in 0..n {
                y[i] = d[i] * u[i];
            }
        };
        let mut solve = |x: &[f64], y: &mut [f64]| {
            for i in 0..n {
                y[i] = x[i] / (e[i] * e[i]);
            }
        };
        let (low, high) =
            extreme_eigenvalues(n, &mut apply, Some(&mut solve), LanczosSettings::default())
                .unwrap();
        assert!((low.value / exact(1.0) - 1.0).abs() < 1e-8, "{low:?}");
        assert!(
            (high.value / exact(n as f64) - 1.0).abs() < 1e-10,
            "{high:?}"
        );
    }

    #[test]
    fn the_largest_vector_of_a_start_of_ones_own() {
        let n = 40;
        let d: Vec<f64> = (0..n).map(|i| 0.9f64.powi(i)).collect();
        let settings = LanczosSettings {
            tolerance: 1e-10,
            patience: 1,
            ..LanczosSettings::one_sided()
        };
        let mut lanczos = Lanczos::from_start(vec![1.0; d.len()], settings).unwrap();
        let largest = loop {
            match lanczos.next_vector().unwrap() {
                ControlFlow::Break((_, largest)) => break largest,
                ControlFlow::Continue(v) => {
                    let product: Vec<f64> = v.iter().zip(&d).map(|(v, d)| v * d).collect();
                    lanczos.take(product.into_iter());
                }
            }
        };
        let vector = lanczos.largest_vector().unwrap();
        assert!(
            (largest.value - 1.0).abs() < 1e-9 && largest.steps < 30,
            "{largest:?}"
        );
        assert!((vector[0].abs() - 1.0).abs() < 1e-9, "{vector:?}");
        assert!(vector[1..].iter().all(|v| v.abs() < 1e-4), "{vector:?}");
    }

    #[test]
    fn tiny_matrices_end_in_an_invariant_subspace() {
        let mut apply = |x: &[f64], y: &mut [f64]| y.copy_from_slice(&[3.0 * x[0], 5.0 * x[1]]);
        let (low, high) =
            extreme_eigenvalues(2, &mut apply, None, LanczosSettings::default()).unwrap();
        assert!((low.value - 3.0).abs() < 1e-12 && (high.value - 5.0).abs() < 1e-12);
    }

    #[test]
    fn the_unit_of_a_pencil_does_not_matter() {
        let n = 60;
        for (of_k, of_m) in [(1e-150, 1.0), (1e120, 1e60), (1e-20, 1e-45), (1.0, 1e-80)] {
            let mut apply = |x: &[f64], y: &mut [f64]| {
                for i in 0..n {
                    y[i] = of_k * (1.0 + i as f64) * x[i];
                }
            };
            let mut solve = |x: &[f64], y: &mut [f64]| {
                (y.iter_mut().zip(x)).for_each(|(y, x)| *y = x / of_m);
            };
            let settings = LanczosSettings::default();
            let found = extreme_eigenvalues(n, &mut apply, Some(&mut solve), settings);
            let (low, high) = found.unwrap();
            let expected = [1.0, n as f64].map(|v| v * (of_k / of_m));
            for (found, expected) in [low, high].into_iter().zip(expected) {
                assert!(
                    (found.value / expected - 1.0).abs() < 1e-8,
                    "{found:?} {expected}"
                );
            }
        }
    }
}
