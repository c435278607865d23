//! Claim: reading a matrix takes hardly more memory than the matrix.

#[path = "../../tests/counting/mod.rs"]
mod counting;

use counting::peak_bytes;
use fracas_operators::matrix_market::{Symmetry, read_sparse, write_sparse};
use fracas_operators::sparse::SparseMatrix;

/// Text and entries on their way: one block of the file, parsed and waiting.
const IN_FLIGHT: usize = 24 << 20;

#[test]
fn a_symmetric_matrix_is_read_into_its_own_memory() {
    let (n, half) = (40_000_usize, 40_usize);
    let row = |i: usize| i.saturating_sub(half)..(i + half + 1).min(n);
    let mut starts = vec![0];
    let (mut columns, mut values) = (Vec::new(), Vec::new());
    for i in 0..n {
        columns.extend(row(i).map(|j| j as u32));
        values.extend(row(i).map(|j| ((i + j) as f64).sin()));
        starts.push(columns.len());
    }
    let matrix = SparseMatrix::new((n, n), starts, columns, values);
    let path = std::env::temp_dir().join(format!("fracas-reader-{}.mtx", std::process::id()));
    write_sparse(&path, &matrix, Symmetry::Symmetric).unwrap();
    let (read, peak) = peak_bytes(|| read_sparse(&path).unwrap().matrix);
    let text = std::fs::metadata(&path).unwrap().len() as usize;
    std::fs::remove_file(&path).unwrap();
    assert!(read == matrix);
    let rows = 12 * matrix.nnz() + 12 * n;
    assert!(text > rows, "the text alone would be the larger part");
    assert!(peak <= rows + IN_FLIGHT, "{peak} bytes for {rows}");
}
