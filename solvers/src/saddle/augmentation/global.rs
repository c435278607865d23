//! The global augmentation.

use super::super::SaddleBlocks;
use super::AugmentationMatrix;
use crate::SetupError;
use crate::eigen::{LanczosSettings, extreme_eigenvalues};
use fracas_operators::sparse::Csr;
use fracas_operators::{AdjointOperator, LinearOperator};

/// `C = s γ I`, `γ = ‖B‖₂² / ‖A‖₂`, both norms by Lanczos to 1e-12; 1 where B has no entries.
///
/// # Source
/// M. Ferronato, SNA'25 lecture: the classical choice of augmented Lagrangians.
pub(super) fn global(blocks: &SaddleBlocks, factor: f64) -> Result<AugmentationMatrix, SetupError> {
    let a = Csr::new(blocks.a.clone());
    let b = Csr::with_transpose(blocks.b1.clone());
    let mut middle = vec![0.0; blocks.n_u()];
    let mut gram = |x: &[f64], y: &mut [f64]| {
        // y = Bᵀ B x
        b.apply(x, &mut middle, &mut []);
        y.fill(0.0);
        b.apply_adjoint_add(1.0, &middle, y, &mut []);
    };
    // every row determines its own traction and was eliminated, say: an empty column counts as 1, as elsewhere
    if blocks.b1.data().iter().all(|b| *b == 0.0) {
        return Ok(AugmentationMatrix::diagonal(vec![1.0; blocks.n_t()]));
    }
    let settings = LanczosSettings::one_sided();
    let (_, b_squared) = extreme_eigenvalues(blocks.n_t(), &mut gram, None, settings)?;
    let mut apply = |x: &[f64], y: &mut [f64]| a.apply(x, y, &mut []);
    let (low, high) = extreme_eigenvalues(blocks.n_u(), &mut apply, None, settings)?;
    let norm_a = if -low.value > high.value {
        // an indefinite A whose largest eigenvalue in modulus is negative
        let mut negative = |x: &[f64], y: &mut [f64]| {
            y.fill(0.0);
            a.apply_add(-1.0, x, y, &mut []);
        };
        extreme_eigenvalues(blocks.n_u(), &mut negative, None, settings)?.1
    } else {
        high
    };
    let gamma = factor * b_squared.value / norm_a.value;
    if !(gamma > 0.0 && gamma.is_finite()) {
        return Err(SetupError::NotApplicable {
            method: "augmentation global",
            reason: format!(
                "γ = ‖B‖²/‖A‖ is {gamma:e}: A has no entries, or those of A and B have distant units"
            ),
        });
    }
    Ok(AugmentationMatrix::diagonal(vec![gamma; blocks.n_t()]))
}
