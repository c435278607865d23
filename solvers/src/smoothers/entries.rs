//! What a method that works on entries asks of a matrix: square, rows, finite entries, a positive diagonal, an admissible ω.

use crate::SetupError;
use fracas_operators::Shape;
use fracas_operators::sparse::{SparseMatrix, first_not_finite};
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;

/// The matrix in messages.
pub(crate) const BLOCK: &str = "A";

/// `a` by rows, checked to be square and finite.
pub(crate) fn rows(a: &SparseMatrix<f64>) -> Result<Cow<'_, SparseMatrix<f64>>, SetupError> {
    let found = Shape::new(a.rows(), a.cols());
    if !found.is_square() {
        return Err(SetupError::Shape {
            block: BLOCK,
            found,
            expected: Shape::square(found.rows),
            reason: "the method needs a square matrix",
        });
    }
    let a = if a.is_csr() {
        Cow::Borrowed(a)
    } else {
        Cow::Owned(a.to_csr())
    };
    finite_entries(BLOCK, &a)?;
    Ok(a)
}

/// Checks that every entry of a matrix by rows is a number.
pub(crate) fn finite_entries(block: &'static str, a: &SparseMatrix<f64>) -> Result<(), SetupError> {
    match first_not_finite(a) {
        Some((row, column, value)) => Err(SetupError::NotFinite {
            block,
            row: row + 1,
            column: column + 1,
            value,
        }),
        None => Ok(()),
    }
}

/// The diagonal, checked to be positive; a missing entry is 0.
pub(crate) fn positive_diagonal(
    a: &SparseMatrix<f64>,
    method: &'static str,
) -> Result<Vec<f64>, SetupError> {
    let entry = |i: usize| {
        let value = a.get(i, i).copied().unwrap_or(0.0);
        if value > 0.0 {
            Ok(value)
        } else {
            Err(SetupError::BadDiagonal {
                block: BLOCK,
                row: i + 1,
                value,
                method,
            })
        }
    };
    (0..a.rows()).map(entry).collect()
}

/// Reads ω in (0, 2).
///
/// # Errors
/// A number outside.
pub(crate) fn omega<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let omega = f64::deserialize(deserializer)?;
    match omega > 0.0 && omega < 2.0 {
        true => Ok(omega),
        false => Err(D::Error::custom(format!(
            "relaxation omega = {omega}: expected a number between 0 and 2"
        ))),
    }
}

/// Checks `0 < ω < limit`.
pub(crate) fn relaxation(omega: f64, limit: f64, method: &'static str) -> Result<(), SetupError> {
    if omega > 0.0 && omega < limit {
        return Ok(());
    }
    Err(SetupError::NotApplicable {
        method,
        reason: format!("its relaxation omega = {omega} must lie between 0 and {limit}"),
    })
}
