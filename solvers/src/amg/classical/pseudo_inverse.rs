//! Pseudo-inverses of Gram matrices of modes.

use fracas_operators::small::symmetric_eigen;

/// Eigenvalue of a Gram matrix, relative to the largest, below which it is taken for zero. Unit: 1.
const RANK: f64 = 1e-11;

/// The pseudo-inverse of a symmetric positive semidefinite matrix.
pub(super) fn pseudo_inverse<const K: usize>(n: [[f64; K]; K]) -> [[f64; K]; K] {
    let (values, vectors) = symmetric_eigen(n);
    let largest = values.iter().copied().fold(0.0, f64::max);
    let inverse = values.map(|v| if v > RANK * largest { 1.0 / v } else { 0.0 });
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            (0..K)
                .map(|k| vectors[i][k] * inverse[k] * vectors[j][k])
                .sum()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::laws::probe;

    /// `BᵀB` of random rows.
    fn gram(rows: usize) -> [[f64; 6]; 6] {
        let values: Vec<f64> = probe(6 * rows, 3);
        let b = values.as_chunks::<6>().0;
        std::array::from_fn(|i| std::array::from_fn(|j| b.iter().map(|r| r[i] * r[j]).sum()))
    }

    fn product(a: &[[f64; 6]; 6], b: &[[f64; 6]; 6]) -> [[f64; 6]; 6] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..6).map(|k| a[i][k] * b[k][j]).sum()))
    }

    #[test]
    fn the_pseudo_inverse_obeys_penrose() {
        for rows in [2, 5, 9, 30] {
            let n = gram(rows);
            let x = pseudo_inverse(n);
            for (left, right) in [
                (product(&product(&n, &x), &n), n),
                (product(&product(&x, &n), &x), x),
            ] {
                let size = right.iter().flatten().fold(0.0f64, |m, v| m.max(v.abs()));
                for (l, r) in left.iter().flatten().zip(right.iter().flatten()) {
                    assert!((l - r).abs() < 1e-9 * size);
                }
            }
        }
    }
}
