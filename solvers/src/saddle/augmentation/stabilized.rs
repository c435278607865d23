//! Augmentations that dominate the stabilization H.

use super::super::SaddleBlocks;
use super::AugmentationMatrix;
use super::exact::schur_complement;
use super::local::local;
use super::support::Columns;
use crate::SetupError;
use crate::direct::DirectSolver;

/// `C = C_local + |diag H|`.
///
/// The eigenvalues with exact S_u lie in [λ_min(GᵀG), max(1, λ_max(C^{-1/2} H C^{-1/2}))]: a C that does not dominate
/// H lets the upper end grow with the contrast of the materials.
pub(super) fn local_h(
    blocks: &SaddleBlocks,
    columns: &Columns,
) -> Result<AugmentationMatrix, SetupError> {
    let mut diagonal = local(&blocks.a, columns)?.diagonal_entries();
    if let Some(h) = &blocks.h {
        for (i, c) in diagonal.iter_mut().enumerate() {
            *c += h.get(i, i).map_or(0.0, |h_ii| h_ii.abs());
        }
    }
    Ok(AugmentationMatrix::diagonal(diagonal))
}

/// `C = Bᵀ A⁻¹ B + (H + Hᵀ)/2`; an empty column of B counts as `S_ii = 1`, since H alone is singular there.
pub(super) fn exact_h(
    blocks: &SaddleBlocks,
    columns: &Columns,
    direct: &dyn DirectSolver,
) -> Result<AugmentationMatrix, SetupError> {
    let mut c = schur_complement(blocks, columns, direct)?;
    for (i, row) in blocks.h.iter().flat_map(|h| h.outer_iterator().enumerate()) {
        for (j, value) in row.iter() {
            c[(i, j)] += 0.5 * value;
            c[(j, i)] += 0.5 * value;
        }
    }
    for i in columns.empty() {
        c[(i, i)] += 1.0;
    }
    Ok(AugmentationMatrix::dense(c))
}
