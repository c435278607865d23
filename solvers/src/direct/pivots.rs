//! What the pivots of a symmetric factorization say about the matrix.

use super::Kind;
use super::pattern::BLOCK;
use crate::SetupError;
use fracas_operators::sparse::SparseMatrix;

/// A pivot below `PIVOT_LOSS √n ε |a_jj|` is rounding error and nothing else. Unit: 1; the growth with √n is that of
/// a sum of n random errors, the factor leaves room for the levers of rigid rotations.
const PIVOT_LOSS: f64 = 8.0;

/// Rejects pivots that are rounding error, and signs that contradict the kind; `row(k)` is the row, from 0, of the
/// k-th pivot.
pub(super) fn check(
    pivots: &[f64],
    row: impl Fn(usize) -> usize,
    a: &SparseMatrix<f64>,
    kind: Kind,
) -> Result<(), SetupError> {
    let loss = PIVOT_LOSS * (pivots.len() as f64).sqrt() * f64::EPSILON;
    for (k, &pivot) in pivots.iter().enumerate() {
        let row = row(k);
        let a_jj = a.get(row, row).copied().unwrap_or(0.0);
        if !(pivot.abs() > loss * a_jj.abs() && pivot.is_finite()) {
            return Err(SetupError::Singular {
                block: BLOCK,
                row: Some(row + 1),
                advice: format!(
                    "the pivot is {pivot:.1e} where the diagonal entry is {a_jj:.1e}: unconstrained bodies, dependent constraints, or sides of cells or moduli so far apart that double precision does not tell"
                ),
            });
        }
        if pivot * a_jj < 0.0 {
            return Err(indefinite(row, kind));
        }
    }
    Ok(())
}

/// The typed error for a pivot of the wrong sign in a row counted from 0.
pub(super) fn indefinite(row: usize, kind: Kind) -> SetupError {
    SetupError::NotPositiveDefinite {
        block: BLOCK,
        row: row + 1,
        advice: match kind {
            Kind::Spd => "check constraints and material, or factorize it as a general matrix",
            _ => "it is not quasi-definite: factorize it as a general matrix",
        }
        .to_owned(),
    }
}
