//! FSAI of a level.

use super::sweeps::SweepMatrix;
use crate::SetupError;
use crate::fsai::{Fsai, FsaiInverse};
use fracas_operators::Real;
use fracas_operators::small::Matrix3;
use fracas_operators::sparse::{Csr, SparseMatrix};

/// Steps of the adaptive pattern, one entry each. Flat cells of 1:100, ν = 0.49, RACP on 6 thousand and 46 thousand unknowns:
/// 10, 15, 20, 30 steps give 47, 43, 41, 41 and 88, 65, 54, 49 iterations; set-up and solve of the larger one take 3.6, 3.8,
/// 4.5, 5.9 s.
const STEPS: usize = 20;

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
    let mut row: Vec<(usize, &Matrix3<S>)> = Vec::new();
    for i in 0..a.rows() {
        row.clear();
        row.extend(a.row(i));
        row.sort_unstable_by_key(|entry| entry.0);
        for r in 0..3 {
            for (j, block) in &row {
                for c in 0..3 {
                    let value = block[r][c].to_f64_exact();
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
