//! Writing: 17 significant digits, formatted in parallel, written in order.

use super::error::MatrixMarketError;
use super::header::Symmetry;
use crate::sparse::SparseMatrix;
use crate::{Dense, LinearOperator};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Rows that one thread formats at a time.
const ROWS_PER_TASK: usize = 2048;
/// Tasks whose text is in memory at once: bounds the memory to about 100 MB for 3-D elasticity.
const TASKS_IN_FLIGHT: usize = 16;

/// Writes a sparse matrix as `coordinate real`, stored by rows, indices from 1.
///
/// With [`Symmetry::Symmetric`] (or `Skew`) the lower triangle is written and the upper one is not looked at; the
/// caller knows that it mirrors the lower.
///
/// # Errors
/// What the operating system says.
pub fn write_sparse(
    path: &Path,
    matrix: &SparseMatrix<f64>,
    symmetry: Symmetry,
) -> Result<(), MatrixMarketError> {
    let by_rows;
    let matrix = if matrix.is_csr() {
        matrix
    } else {
        by_rows = matrix.to_csr();
        &by_rows
    };
    let stored = |i: usize, j: usize| match symmetry {
        Symmetry::General => true,
        Symmetry::Symmetric => j <= i,
        Symmetry::Skew => j < i,
    };
    let offsets = matrix.indptr();
    let offsets = offsets.raw_storage();
    let row_entries = |i: usize| {
        let range = offsets[i]..offsets[i + 1];
        let columns = matrix.indices()[range.clone()].iter().map(|j| *j as usize);
        columns
            .zip(&matrix.data()[range])
            .filter(move |(j, _)| stored(i, *j))
    };
    let entries: usize = (0..matrix.rows())
        .into_par_iter()
        .map(|i| row_entries(i).count())
        .sum();
    let head = format!(
        "%%MatrixMarket matrix coordinate real {}\n{} {} {entries}\n",
        symmetry.word(),
        matrix.rows(),
        matrix.cols()
    );
    write_blocks(path, &head, matrix.rows(), &|i, text| {
        for (j, value) in row_entries(i) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{} {} {value:.16e}", i + 1, j + 1);
        }
    })
}

/// Writes a dense matrix as `array real general`, column after column.
///
/// # Errors
/// What the operating system says.
pub fn write_dense(path: &Path, matrix: &Dense<f64>) -> Result<(), MatrixMarketError> {
    let shape = matrix.shape();
    write_array(path, shape.rows, shape.cols, matrix.values())
}

/// Writes a vector as an `array real general` of one column.
///
/// # Errors
/// What the operating system says.
pub fn write_vector(path: &Path, vector: &[f64]) -> Result<(), MatrixMarketError> {
    write_array(path, vector.len(), 1, vector)
}

fn write_array(
    path: &Path,
    rows: usize,
    columns: usize,
    values: &[f64],
) -> Result<(), MatrixMarketError> {
    let head = format!("%%MatrixMarket matrix array real general\n{rows} {columns}\n");
    write_blocks(path, &head, values.len(), &|k, text| {
        let _ = writeln!(text, "{:.16e}", values[k]);
    })
}

/// Formats `n` rows in parallel blocks and writes them in order.
fn write_blocks(
    path: &Path,
    head: &str,
    n: usize,
    format: &(impl Fn(usize, &mut String) + Sync),
) -> Result<(), MatrixMarketError> {
    let io = |source| MatrixMarketError::Io {
        file: path.into(),
        source,
    };
    let mut file = BufWriter::with_capacity(1 << 20, std::fs::File::create(path).map_err(io)?);
    file.write_all(head.as_bytes()).map_err(io)?;
    let group = ROWS_PER_TASK * TASKS_IN_FLIGHT;
    for start in (0..n).step_by(group) {
        let texts: Vec<String> = (start..n.min(start + group))
            .into_par_iter()
            .step_by(ROWS_PER_TASK)
            .map(|first| {
                let mut text = String::new();
                for i in first..n.min(first + ROWS_PER_TASK) {
                    format(i, &mut text);
                }
                text
            })
            .collect();
        for text in texts {
            file.write_all(text.as_bytes()).map_err(io)?;
        }
    }
    file.flush().map_err(io)
}
