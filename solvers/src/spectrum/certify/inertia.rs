//! How many eigenvalues of a symmetric matrix can at most be ≥ 0 or ≤ 0, proved by one factorization.

use super::rounding::{U, above, absolute_product, gamma, largest, row_sums};
use crate::eigen::{dense, factors};
use faer::Mat;

/// A symmetric matrix that is known up to an error.
pub(super) struct Symmetric {
    /// All entries.
    pub(super) matrix: Mat<f64>,
    /// `‖error‖₂` from above.
    pub(super) error: f64,
}

impl Symmetric {
    /// Given by its entries.
    pub(super) fn exact(matrix: Mat<f64>) -> Self {
        Self { matrix, error: 0.0 }
    }

    /// At most so many eigenvalues are ≥ 0; `None` where rounding hides it.
    ///
    /// `S + τI = L D Lᵀ + E` with ‖E‖ ≤ δ, found afterwards: if τ ≥ δ an eigenvalue of S that is ≥ 0 belongs to one of `L D Lᵀ` that is > 0
    /// (Weyl), and of these D has as many (Sylvester).
    ///
    /// # Cost
    /// n³/3 flops for Bunch–Kaufman's factors and 2 n³ for E, at most three times.
    pub(super) fn most_nonnegative(&self) -> Option<usize> {
        self.most(1.0)
    }

    /// The same of those that are ≤ 0.
    pub(super) fn most_nonpositive(&self) -> Option<usize> {
        self.most(-1.0)
    }

    fn most(&self, sign: f64) -> Option<usize> {
        /// Times n u ‖S‖: as much as a good factorization is off by.
        const FIRST: f64 = 32.0;
        const TRIES: usize = 3;
        let n = self.matrix.nrows();
        let norm = largest(&row_sums(self.matrix.as_ref()));
        // also where an entry is NaN or infinite
        if !norm.is_finite() {
            return None;
        }
        let mut tau = FIRST * n as f64 * U * norm + 2.0 * self.error;
        for _ in 0..TRIES {
            let mut shifted = Mat::from_fn(n, n, |i, j| sign * self.matrix[(i, j)]);
            let mut lost: f64 = 0.0;
            for i in 0..n {
                shifted[(i, i)] += tau;
                lost = lost.max(U * shifted[(i, i)].abs());
            }
            let (positive, error) = factored(&shifted)?;
            let error = above(error + lost + self.error, 3);
            if error <= tau {
                return Some(positive);
            }
            tau = 2.0 * error;
            if tau.is_nan() || tau > 1e-3 * norm {
                return None;
            }
        }
        None
    }

    /// True only where it is positive definite.
    pub(super) fn is_positive(&self) -> bool {
        self.most_nonpositive() == Some(0)
    }
}

/// Positive eigenvalues of D of `L D Lᵀ`, and ‖S − L D Lᵀ‖ from above; `None` where a pivot has no sign.
fn factored(s: &Mat<f64>) -> Option<(usize, f64)> {
    let n = s.nrows();
    let factors = factors::bunch_kaufman(s.clone());
    let (l, diagonal, below) = (&factors.l, &factors.diagonal, &factors.below);
    let mut positive = 0;
    // D Lᵀ and |D|
    let mut right = Mat::zeros(n, n);
    let mut size = l.as_ref().transpose().to_owned();
    let mut j = 0;
    while j < n {
        if below[j] == 0.0 {
            let d = diagonal[j];
            if d.is_nan() || d == 0.0 {
                return None;
            }
            positive += usize::from(d > 0.0);
            for i in 0..n {
                right[(j, i)] = d * l[(i, j)];
                size[(j, i)] = right[(j, i)].abs();
            }
            j += 1;
            continue;
        }
        let (a, b, c) = (diagonal[j], below[j], diagonal[j + 1]);
        let (determinant, rounding) = (
            a * c - b * b,
            4.0 * U * ((a * c).abs() + b * b) + f64::MIN_POSITIVE,
        );
        if determinant.is_nan() || determinant.abs() <= rounding {
            return None;
        }
        positive += match determinant < 0.0 {
            true => 1,
            false => 2 * usize::from(a > 0.0),
        };
        for i in 0..n {
            let (p, q) = (l[(i, j)], l[(i, j + 1)]);
            (right[(j, i)], right[(j + 1, i)]) = (a * p + b * q, b * p + c * q);
            size[(j, i)] = (a * p).abs() + (b * q).abs();
            size[(j + 1, i)] = (b * p).abs() + (c * q).abs();
        }
        j += 2;
    }
    let product = dense::multiply(l.as_ref(), right.as_ref());
    let permutation = &factors.permutation;
    let difference = Mat::from_fn(n, n, |i, j| {
        s[(permutation[i], permutation[j])] - product[(i, j)]
    });
    // of D Lᵀ, of L (D Lᵀ) and of the difference
    let of_size = row_sums(size.as_ref());
    let rounding = absolute_product(l.as_ref(), &of_size);
    let found = row_sums(difference.as_ref());
    let rows: Vec<f64> = (found.iter().zip(&rounding))
        .map(|(found, rounding)| above(found * (1.0 + 2.0 * U) + gamma(n + 4) * rounding, 4))
        .collect();
    Some((positive, largest(&rows)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    /// Q diag(values) Qᵀ with integers alone, so that it has these eigenvalues exactly: Q a Householder reflection of powers of two.
    fn with_eigenvalues(values: &[f64]) -> Mat<f64> {
        let n = values.len();
        assert!(n.is_power_of_two());
        // Hadamard: H Hᵀ = n I, and n is a power of two
        let h = Mat::from_fn(n, n, |i, j| match (i & j).count_ones() % 2 {
            0 => 1.0,
            _ => -1.0,
        });
        let scaled = Mat::from_fn(n, n, |i, j| h[(i, j)] * values[j] / n as f64);
        &scaled * h.transpose()
    }

    #[test]
    fn signs_of_matrices_with_known_eigenvalues_are_counted_and_never_too_low() {
        let mut decided = 0;
        for seed in 0..200 {
            let dice = &mut Random::new(seed);
            let n = 1 << (1 + dice.below(5));
            // whole numbers times a power of two: every sum above is exact
            let values: Vec<f64> = (0..n)
                .map(|_| f64::from(dice.whole(0, 40)) - 20.0)
                .collect();
            let s = Symmetric::exact(with_eigenvalues(&values));
            let nonnegative = values.iter().filter(|v| **v >= 0.0).count();
            let nonpositive = values.iter().filter(|v| **v <= 0.0).count();
            for (found, exact) in [
                (s.most_nonnegative(), nonnegative),
                (s.most_nonpositive(), nonpositive),
            ] {
                assert!(found.is_none_or(|found| found >= exact), "{seed}");
                decided += usize::from(found == Some(exact));
            }
        }
        assert!(decided > 390, "{decided}");
    }

    #[test]
    fn what_rounding_could_have_made_is_never_called_definite() {
        for seed in 0..100 {
            let dice = &mut Random::new(seed);
            let n = 4 + dice.below(30);
            let rank = 1 + dice.below(n - 1);
            // integers: G Gᵀ is exact, singular, and clustered at zero
            let g = Mat::from_fn(n, rank, |_, _| f64::from(dice.whole(0, 6)) - 3.0);
            let gram = Symmetric::exact(&g * g.transpose());
            assert!(!gram.is_positive(), "{seed}");
            let mut lifted = gram.matrix.clone();
            (0..n).for_each(|i| lifted[(i, i)] += 1e-6);
            assert!(Symmetric::exact(lifted).is_positive(), "{seed}");
        }
        // an entry that is not known may be anything
        let known = Symmetric {
            matrix: Mat::identity(3, 3),
            error: 2.0,
        };
        assert!(!known.is_positive());
        assert!(!Symmetric::exact(Mat::from_fn(2, 2, |_, _| f64::NAN)).is_positive());
    }
}
