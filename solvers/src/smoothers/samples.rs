//! Small sparse matrices for the tests of smoothers.

use fracas_operators::sparse::{SparseMatrix, Triplets};

/// An n×n matrix from (row, column, value).
pub(super) fn sparse(n: usize, entries: &[(usize, usize, f64)]) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((n, n));
    for (i, j, value) in entries {
        triplets.add_triplet(*i, *j, *value);
    }
    triplets.to_csr()
}

/// A chain of nodes with three coupled unknowns each, held by springs: SPD, 3×3 blocks full; n divisible by 3.
pub(super) fn stiffness(n: usize) -> SparseMatrix<f64> {
    let mut entries = Vec::new();
    for i in 0..n {
        entries.push((i, i, 6.5 + (i % 3) as f64));
        for j in (i / 3 * 3..i / 3 * 3 + 3).filter(|j| *j != i) {
            entries.push((i, j, -1.0));
        }
        for j in [i.wrapping_sub(3), i + 3].into_iter().filter(|j| *j < n) {
            entries.push((i, j, -2.2));
        }
    }
    sparse(n, &entries)
}
