//! Eigenvalues of symmetric matrices.

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix by cyclic Jacobi rotations.
pub fn symmetric_eigen<const K: usize>(mut a: [[f64; K]; K]) -> ([f64; K], [[f64; K]; K]) {
    let mut v: [[f64; K]; K] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    // quadratic convergence: six sweeps reach rounding for any matrix of this size
    for _ in 0..10 {
        let mut rotated = false;
        for p in 0..K {
            for q in p + 1..K {
                let size = f64::EPSILON * (a[p][p] * a[q][q]).abs().sqrt();
                if a[p][q].abs() <= size.max(f64::MIN_POSITIVE) {
                    continue;
                }
                rotated = true;
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = 1.0 / t.hypot(1.0);
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..K {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                }
                for row in &mut v {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
            }
        }
        if !rotated {
            break;
        }
    }
    (std::array::from_fn(|i| a[i][i]), v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::laws::probe;

    #[test]
    fn values_and_vectors_reproduce_the_matrix() {
        let entries = probe::<f64>(36, 7);
        let a: [[f64; 6]; 6] =
            std::array::from_fn(|i| std::array::from_fn(|j| entries[6 * i.max(j) + i.min(j)]));
        let (values, v) = symmetric_eigen(a);
        for i in 0..6 {
            for j in 0..6 {
                let found: f64 = (0..6).map(|k| v[i][k] * values[k] * v[j][k]).sum();
                let product: f64 = (0..6).map(|k| v[k][i] * v[k][j]).sum();
                assert!((found - a[i][j]).abs() < 1e-14);
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }
}
