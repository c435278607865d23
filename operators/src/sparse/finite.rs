//! The first entry that is no number.

use super::SparseMatrix;
use rayon::prelude::*;

/// Entries that one task looks at.
const CHUNK: usize = 1 << 16;

/// `(i, j, value)` of the first stored entry that is NaN or infinite; outer index first: row and column of a matrix
/// stored by rows.
///
/// # Cost
/// Reads every value once, on all threads.
pub fn first_not_finite(matrix: &SparseMatrix<f64>) -> Option<(usize, usize, f64)> {
    let chunks = matrix.data().par_chunks(CHUNK).enumerate();
    let k = chunks.find_map_first(|(chunk, values)| {
        // a sum of products with zero is zero or NaN: no branch per entry
        let clean = values.iter().map(|v| v * 0.0).sum::<f64>() == 0.0;
        let bad = values.iter().position(|v| !clean && !v.is_finite());
        bad.map(|k| chunk * CHUNK + k)
    })?;
    let starts = matrix.indptr();
    let i = starts.raw_storage().partition_point(|start| *start <= k) - 1;
    Some((i, matrix.indices()[k] as usize, matrix.data()[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::Triplets;

    #[test]
    fn the_first_bad_entry_is_found_behind_empty_rows_and_in_any_chunk() {
        let n = 3 * CHUNK;
        let build = |bad: &[(usize, f64)]| {
            let mut triplets = Triplets::new((2 * n, 5));
            for i in 0..n {
                let value = bad.iter().find(|(k, _)| *k == i).map_or(1e300, |b| b.1);
                triplets.add_triplet(2 * i + 1, i % 5, value);
            }
            triplets.to_csr()
        };
        assert_eq!(first_not_finite(&build(&[])), None);
        for k in [0, 7, CHUNK - 1, CHUNK, 2 * CHUNK + 3, n - 1] {
            let found = first_not_finite(&build(&[(k, f64::INFINITY), (n - 1, f64::NAN)]));
            let (i, j, _) = found.unwrap();
            assert_eq!((i, j), (2 * k + 1, k % 5));
        }
    }
}
