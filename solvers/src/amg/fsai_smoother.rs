//! FSAI of a level.

use super::sweeps::SweepMatrix;
use crate::SetupError;
use crate::fsai::{Fsai, FsaiInverse};
use fracas_operators::Real;
use fracas_operators::sparse::{Csr, SparseMatrix};

/// Steps of the adaptive pattern, one entry each: a smoother gains little from more. Clamped cube of 104 544 unknowns: 5,
/// 10, 30 steps take 0.6, 1.5, 1.8 s to set up.
const STEPS: usize = 10;

/// Least gain of a step. Source: the group's published default.
const EPSILON: f64 = 1e-3;

/// `ωGᵀG` of the matrix of a level with its `ω = min(1, 1.9/λ_max(G A Gᵀ))`.
///
/// # Errors
/// As [`Fsai`], rows of the level.
pub(super) fn smoother<S: Real, R: Real>(a: &SweepMatrix<S>) -> Result<FsaiInverse<R>, SetupError> {
    let a = scalar(a);
    let m = Fsai::adaptive(STEPS, 1, EPSILON).build(&a)?;
    Ok(m.damped(&Csr::new(a))?.cast())
}

/// Entry by entry in f64, without the zeros inside blocks.
fn scalar<S: Real>(a: &SweepMatrix<S>) -> SparseMatrix<f64> {
    let n = 3 * a.rows();
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    let mut row: Vec<(usize, &[S; 9])> = Vec::new();
    for i in 0..a.rows() {
        row.clear();
        row.extend(a.row(i));
        row.sort_unstable_by_key(|entry| entry.0);
        for r in 0..3 {
            for (j, block) in &row {
                for c in 0..3 {
                    let value = block[3 * r + c].to_f64_exact();
                    if value != 0.0 {
                        columns.push((3 * j + c) as u32);
                        values.push(value);
                    }
                }
            }
            offsets.push(columns.len());
        }
    }
    SparseMatrix::new((n, n), offsets, columns, values)
}
