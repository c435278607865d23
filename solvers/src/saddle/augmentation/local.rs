//! The local augmentation.

use super::super::SaddleBlocks;
use super::super::energy_norms::of_itself;
use super::AugmentationMatrix;
use super::support::{Columns, for_restricted};
use crate::SetupError;
use crate::eigen::{LanczosSettings, dense, extreme_eigenvalues};
use faer::Mat;
use fracas_operators::LinearOperator;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use rayon::prelude::*;

/// Supports up to this size go through a dense eigenvalue solver, larger ones through Lanczos.
const DENSE_SUPPORT: usize = 240;

/// `C_ii = ‖r(b_i)‖₂² / ‖A|_{b_i}‖₂`, b_i = column i of B, A restricted to its support; for an empty column `|H_ii|`, or 1. Where A vanishes on the
/// support, B alone holds what moves there, and the largest ‖A|_{b_j}‖₂ of other columns, or 1, stands for that norm.
///
/// # Units
/// [m⁴] / [N/m], like BᵀA⁻¹B: C scales with B² and with 1/A.
///
/// # Cost
/// One symmetric eigenvalue problem per distinct support, columns in parallel.
///
/// # Source
/// M. Ferronato, SNA'25 lecture, slide on the choice of C.
pub(super) fn local(
    blocks: &SaddleBlocks,
    columns: &Columns,
) -> Result<AugmentationMatrix, SetupError> {
    let (a, n_t) = (&blocks.a, columns.len());
    // The three columns of a face usually share their support: one norm serves them all.
    let first_of_run: Vec<usize> = (0..n_t)
        .filter(|&i| i == 0 || columns.support(i) != columns.support(i - 1))
        .collect();
    let norms = first_of_run
        .par_iter()
        .map(|&i| spectral_norm(a, columns.support(i)))
        .collect::<Result<Vec<f64>, _>>()?;
    let largest = norms.iter().copied().fold(0.0, f64::max);
    let of_none = if largest > 0.0 { largest } else { 1.0 };
    let mut run = 0;
    let diagonal = (0..n_t).map(|i| {
        while first_of_run.get(run + 1).is_some_and(|&next| next <= i) {
            run += 1;
        }
        match norms[run] {
            _ if columns.support(i).is_empty() => of_itself(blocks.h_ii(i)),
            0.0 => columns.norm_squared(i) / of_none,
            norm => columns.norm_squared(i) / norm,
        }
    });
    Ok(AugmentationMatrix::diagonal(diagonal.collect()))
}

/// ‖A|_s‖₂ of the symmetric A.
fn spectral_norm(a: &SparseMatrix<f64>, support: &[usize]) -> Result<f64, SetupError> {
    let n = support.len();
    if n == 0 {
        return Ok(0.0);
    }
    if n <= DENSE_SUPPORT {
        let mut restricted = Mat::zeros(n, n);
        for_restricted(a, support, |i, j, value| restricted[(i, j)] = value);
        let values = dense::symmetric_eigenvalues(restricted.as_ref())?;
        return Ok(values[0].abs().max(values[n - 1].abs()));
    }
    let mut triplets = Triplets::new((n, n));
    for_restricted(a, support, |i, j, value| triplets.add_triplet(i, j, value));
    let restricted = Csr::new(triplets.to_csr());
    let mut apply = |x: &[f64], y: &mut [f64]| restricted.apply(x, y, &mut []);
    let (low, high) = extreme_eigenvalues(n, &mut apply, None, LanczosSettings::one_sided())?;
    Ok(low.value.abs().max(high.value.abs()))
}
