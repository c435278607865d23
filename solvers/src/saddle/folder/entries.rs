//! Entries of which products leave the range of f64.

use super::FolderError;
use crate::saddle::SaddleBlocks;
use fracas_operators::sparse::SparseMatrix;

/// Smallest and largest size of an entry but 0: of larger and smaller ones products leave the range of f64 (1e±308).
pub(super) const LEAST: f64 = 1e-100;
pub(super) const MOST: f64 = 1e100;

/// Stops at the first entry of a matrix that is too large, or at the largest one where that is too small: beside it small ones are zeros.
pub(super) fn matrix(file: &str, matrix: &SparseMatrix<f64>) -> Result<(), FolderError> {
    let sizes = || matrix.data().iter().map(|value| value.abs());
    let largest = sizes().fold(0.0, f64::max);
    let is_extreme = |size: f64| size > MOST || largest < LEAST && size == largest && size > 0.0;
    let Some(k) = sizes().position(is_extreme) else {
        return Ok(());
    };
    let starts = matrix.indptr();
    Err(FolderError::Extreme {
        file: file.into(),
        row: starts.raw_storage().partition_point(|start| *start <= k),
        column: matrix.indices()[k] as usize + 1,
        value: matrix.data()[k],
    })
}

/// Stops where the largest entry of all right-hand sides is too large or too small.
pub(super) fn right_hand_sides(blocks: &SaddleBlocks) -> Result<(), FolderError> {
    let sides = blocks.right_hand_sides().into_iter();
    let entries = sides.flat_map(|(name, side)| {
        let values = side.into_iter().flatten().enumerate();
        values.map(move |(row, value)| (name, row, *value))
    });
    let largest = entries.reduce(|a, b| if b.2.abs() > a.2.abs() { b } else { a });
    match largest {
        Some((name, row, value)) if value != 0.0 && !(LEAST..=MOST).contains(&value.abs()) => {
            Err(FolderError::Extreme {
                file: format!("{name}.mtx"),
                row: row + 1,
                column: 1,
                value,
            })
        }
        _ => Ok(()),
    }
}
