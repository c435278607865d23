//! Rank of small dense Gram matrices.

/// Rank of a symmetric positive semi-definite n×n matrix by Cholesky with diagonal pivoting; pivots below
/// `tolerance` · (largest diagonal entry) count as zero. The matrix is overwritten.
///
/// # Cost
/// O(n² rank).
pub(super) fn gram_rank(a: &mut [f64], n: usize, tolerance: f64) -> usize {
    assert_eq!(a.len(), n * n, "gram_rank: {} entries for n = {n}", a.len());
    let largest = (0..n).fold(0.0f64, |m, i| m.max(a[i * n + i]));
    for k in 0..n {
        let mut p = k;
        for i in k + 1..n {
            if a[i * n + i] > a[p * n + p] {
                p = i;
            }
        }
        if a[p * n + p] <= tolerance * largest || a[p * n + p].is_nan() {
            return k;
        }
        if p != k {
            for j in 0..n {
                a.swap(k * n + j, p * n + j);
            }
            for i in 0..n {
                a.swap(i * n + k, i * n + p);
            }
        }
        let (head, tail) = a.split_at_mut((k + 1) * n);
        let pivot = &head[k * n..];
        for row in tail.chunks_exact_mut(n) {
            let factor = row[k] / pivot[k];
            if factor != 0.0 {
                for j in k + 1..n {
                    row[j] -= factor * pivot[j];
                }
            }
        }
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_of_products() {
        let (n, r) = (12, 5);
        let x: Vec<f64> = (0..n * r)
            .map(|i| ((i * i * 7 + 3 * i) as f64).sin())
            .collect();
        let mut gram = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                gram[i * n + j] = (0..r).map(|k| x[i * r + k] * x[j * r + k]).sum();
            }
        }
        assert_eq!(gram_rank(&mut gram, n, 1e-10), r);
        assert_eq!(gram_rank(&mut [0.0; 9], 3, 1e-10), 0);
        assert_eq!(gram_rank(&mut [2.0, 0.0, 0.0, 3.0], 2, 1e-10), 2);
    }
}
