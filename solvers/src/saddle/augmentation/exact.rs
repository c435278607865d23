//! The exact augmentation.

use super::super::SaddleBlocks;
use super::super::energy_norms::of_itself;
use super::AugmentationMatrix;
use super::support::Columns;
use crate::SetupError;
use crate::direct::DirectSolver;
use crate::eigen::dense::symmetrize;
use crate::eigen::{LanczosSettings, extreme_eigenvalues};
use crate::saddle::scaling::ScaledInverse;
use faer::Mat;
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

/// Right-hand sides solved at once: bounds the memory at this many vectors of length n_u.
const COLUMNS_AT_ONCE: usize = 128;

/// Least eigenvalue over the largest one, both after scaling, below which A is indefinite and not only singular to rounding. Unit: 1.
const INDEFINITE: f64 = 1e-10;

/// `C = Bᵀ A⁻¹ B`; an empty column gets `C_ii = |H_ii|`, or 1.
///
/// # Cost
/// One sparse Cholesky factorization of A and n_t solves; the products use only the rows of A⁻¹B where B has entries.
///
/// # Errors
/// [`SetupError::NotApplicable`] when A is not positive definite: singular (a block held by fractures only) or indefinite.
pub(super) fn exact(
    blocks: &SaddleBlocks,
    columns: &Columns,
    direct: &dyn DirectSolver,
) -> Result<AugmentationMatrix, SetupError> {
    let mut c = match blocks.b1.data().iter().all(|b| *b == 0.0) {
        // nothing is asked of A
        true => Mat::zeros(columns.len(), columns.len()),
        false => schur_complement(blocks, columns, direct)?,
    };
    for i in columns.empty() {
        c[(i, i)] = of_itself(blocks.h_ii(i));
    }
    Ok(AugmentationMatrix::dense(c))
}

/// The dual Schur complement `S = Bᵀ A⁻¹ B` of B = B1, symmetric to the last bit, also where it is singular: n_t × n_t.
///
/// # Cost
/// That of the exact augmentation: one sparse Cholesky factorization of A and n_t solves.
///
/// # Errors
/// [`SetupError::NotApplicable`] where A is singular or indefinite, [`SetupError::NotFinite`] for NaN.
pub fn dual_schur(
    blocks: &SaddleBlocks,
    direct: &dyn DirectSolver,
) -> Result<Mat<f64>, SetupError> {
    blocks.check()?;
    schur_complement(blocks, &Columns::new(&blocks.b1), direct)
}

/// The same, of columns at hand.
pub(super) fn schur_complement(
    blocks: &SaddleBlocks,
    columns: &Columns,
    direct: &dyn DirectSolver,
) -> Result<Mat<f64>, SetupError> {
    let (n_u, n_t) = (blocks.n_u(), columns.len());
    // A = D Â D with diag Â = 1: S = (D⁻¹B)ᵀ Â⁻¹ (D⁻¹B)
    let ScaledInverse {
        factors,
        inverse_scale,
    } = ScaledInverse::new(&blocks.a, direct, "A").map_err(|error| match error {
        SetupError::NotPositiveDefinite { .. }
        | SetupError::Singular { .. }
        | SetupError::BadDiagonal { .. } => not_definite(&blocks.a),
        other => other,
    })?;
    let mut s = Mat::zeros(n_t, n_t);
    let mut x = vec![0.0; n_u * COLUMNS_AT_ONCE.min(n_t)];
    for first in (0..n_t).step_by(COLUMNS_AT_ONCE) {
        let count = COLUMNS_AT_ONCE.min(n_t - first);
        let x = &mut x[..n_u * count];
        x.fill(0.0);
        for j in 0..count {
            for (row, value) in columns
                .support(first + j)
                .iter()
                .zip(columns.values(first + j))
            {
                x[j * n_u + row] = value * inverse_scale[*row];
            }
        }
        factors.solve_many(count, x);
        // s_ij = b_iᵀ D⁻¹ x_j
        let part: Vec<Vec<f64>> = x
            .par_chunks(n_u)
            .map(|x_j| {
                (0..n_t)
                    .map(|i| {
                        let entries = columns.support(i).iter().zip(columns.values(i));
                        entries
                            .map(|(row, value)| value * inverse_scale[*row] * x_j[*row])
                            .sum()
                    })
                    .collect()
            })
            .collect();
        for (j, column) in part.iter().enumerate() {
            for (i, value) in column.iter().enumerate() {
                s[(i, first + j)] = *value;
            }
        }
    }
    symmetrize(&mut s);
    Ok(s)
}

/// Why A has no Cholesky factors: the least eigenvalue of `D⁻¹AD⁻¹`, `D² = |diag A|`, tells a singular A from an indefinite one.
fn not_definite(a: &SparseMatrix<f64>) -> SetupError {
    let scale = |i: usize| match a.get(i, i).map_or(0.0, |a| a.abs()) {
        0.0 => 1.0,
        entry => 1.0 / entry.sqrt(),
    };
    let scale: Vec<f64> = (0..a.rows()).map(scale).collect();
    let mut apply = |x: &[f64], y: &mut [f64]| {
        for ((y, row), s) in y.iter_mut().zip(a.outer_iterator()).zip(&scale) {
            let entries = row.iter().map(|(j, a)| a * scale[j] * x[j]);
            *y = s * entries.sum::<f64>();
        }
    };
    let ends = extreme_eigenvalues(a.rows(), &mut apply, None, LanczosSettings::default());
    let why = match ends {
        Ok((low, high)) if low.value < -INDEFINITE * high.value.abs() => {
            "indefinite: no stiffness is (rows that determine their own traction are eliminated first, and may make it so)"
        }
        _ => {
            "singular to working precision (a block held by fractures only, or a missing boundary condition)"
        }
    };
    SetupError::NotApplicable {
        method: "augmentation exact or exact_h",
        reason: format!(
            "C = BᵀA⁻¹B needs a positive definite A, and this A is {why}; take local, local_h or face_block"
        ),
    }
}
