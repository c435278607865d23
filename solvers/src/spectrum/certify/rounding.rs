//! Bounds that hold in spite of rounding: products and sums in f64 with what they can be off by.
//!
//! `|fl(xᵀy) − xᵀy| ≤ γ_n |x|ᵀ|y|`, `γ_n = nu/(1 − nu)`, u = 2⁻⁵³, in whatever order and with or without fused operations; sums of what is
//! not negative are enlarged by what they can have lost. The products are those of a classical algorithm, which faer's are.
//!
//! # Source
//! N. J. Higham, *Accuracy and Stability of Numerical Algorithms* (2002), §3.1; S. M. Rump, Acta Numerica 19 (2010) 287–449.

use faer::{Mat, MatRef};

/// Unit roundoff of f64.
pub(super) const U: f64 = 0.5 * f64::EPSILON;

/// γ_n from above.
pub(super) fn gamma(n: usize) -> f64 {
    let nu = n as f64 * U;
    assert!(nu < 1e-3, "{n} operations");
    // 1/(1 − nu) ≤ 1 + 2nu, and its own rounding
    nu * (1.0 + 4.0 * nu + 8.0 * U)
}

/// What a sum of `terms` numbers ≥ 0, each of a few products, is at most, underflow included.
pub(super) fn above(sum: f64, terms: usize) -> f64 {
    let underflow = (terms + 16) as f64 * f64::MIN_POSITIVE;
    (sum * (1.0 + 2.0 * gamma(terms + 16)) + underflow).next_up()
}

/// `|A| v`, v ≥ 0, from above.
pub(super) fn absolute_product(a: MatRef<'_, f64>, v: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; a.nrows()];
    for (j, v) in v.iter().enumerate() {
        let column = a.col(j);
        for (sum, a) in sums.iter_mut().zip(column.iter()) {
            *sum += a.abs() * v;
        }
    }
    sums.iter().map(|sum| above(*sum, a.ncols())).collect()
}

/// Entry by entry `|A|`.
pub(super) fn absolute(a: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs())
}

/// Row sums of `|A|`, from above.
pub(super) fn row_sums(a: MatRef<'_, f64>) -> Vec<f64> {
    absolute_product(a, &vec![1.0; a.ncols()])
}

/// The largest; NaN counts as infinite.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| match v.is_nan() {
        true => f64::INFINITY,
        false => m.max(*v),
    })
}

/// The largest of each column; NaN counts as infinite.
pub(super) fn column_maxima(a: MatRef<'_, f64>) -> Vec<f64> {
    (0..a.ncols())
        .map(|j| largest(&a.col(j).iter().copied().collect::<Vec<_>>()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_to_be_above_is() {
        // 1 + n tiny numbers that rounding loses one by one
        let n = 1000;
        let row = Mat::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.5 * U });
        let exact = 1.0 + (n - 1) as f64 * 0.5 * U;
        assert_eq!((0..n).map(|j| row[(0, j)]).sum::<f64>(), 1.0);
        assert!(row_sums(row.as_ref())[0] >= exact);
        assert!(gamma(10) >= 10.0 * U && gamma(10) < 10.1 * U);
        assert_eq!(largest(&[1.0, f64::NAN]), f64::INFINITY);
        let overflown = Mat::from_fn(2, 2, |i, j| [[0.5, f64::NAN], [2.0, 1.0]][i][j]);
        assert_eq!(column_maxima(overflown.as_ref()), [2.0, f64::INFINITY]);
    }
}
