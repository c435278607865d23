//! Augmentations that dominate the stabilization H.

use super::super::SaddleBlocks;
use super::super::energy_norms::of_itself;
use super::exact::schur_complement;
use super::face_block::{ROUNDING, add_stabilization};
use super::local::local;
use super::support::Columns;
use super::{AugmentationMatrix, Block};
use crate::SetupError;
use crate::direct::DirectSolver;
use fracas_operators::small::diagonal;
use fracas_operators::sparse::SparseMatrix;

/// Share of H in `half_h`, and the largest in `fitted_h`. Unit: 1. `H ≤ 2 blkdiag H`: the relaxation of H is of degree one.
pub(super) const HALF: f64 = 0.5;

/// `C = C_local + |diag H|`.
///
/// The eigenvalues with exact S_u lie in [λ_min(GᵀG), max(1, λ_max(C^{-1/2} H C^{-1/2}))]: a C that does not dominate
/// H lets the upper end grow with the contrast of the materials.
pub(super) fn local_h(
    blocks: &SaddleBlocks,
    columns: &Columns,
) -> Result<AugmentationMatrix, SetupError> {
    let local = local(blocks, columns)?.diagonal_entries();
    Ok(match &blocks.h {
        Some(h) => row_by_row(local, h, |_| 1.0),
        None => AugmentationMatrix::diagonal(local),
    })
}

/// `C = C_local + |blkdiag H|/2`, blkdiag the 3×3 blocks of faces; by its diagonal where n_t is no multiple of three.
///
/// `H ≤ 2 blkdiag H`, so that `λ_max(C⁻¹H) ≤ 4` whatever the frames of the faces and the contrast of the rock.
pub(super) fn half_h(
    blocks: &SaddleBlocks,
    columns: &Columns,
) -> Result<AugmentationMatrix, SetupError> {
    let local = local(blocks, columns)?.diagonal_entries();
    Ok(with_share(local, blocks.h.as_ref(), |_| HALF))
}

/// `C = C_local + θ |blkdiag H|`, θ a number for every face; row by row where n_t is no multiple of three.
pub(super) fn with_share(
    local: Vec<f64>,
    h: Option<&SparseMatrix<f64>>,
    theta: impl Fn(usize) -> f64,
) -> AugmentationMatrix {
    let Some(h) = h else {
        return AugmentationMatrix::diagonal(local);
    };
    if group(local.len()) == 1 {
        return row_by_row(local, h, theta);
    }
    let block = |(face, local): (usize, &[f64])| {
        let mut block = diagonal([local[0], local[1], local[2]]);
        add_stabilization(&mut block, h, face, theta(face));
        block
    };
    let faces: Vec<Block> = local.chunks_exact(3).enumerate().map(block).collect();
    // frames along the axes of bricks: nothing beside the diagonal, and a sixth of the memory
    match faces.iter().all(is_diagonal) {
        true => AugmentationMatrix::diagonal(
            faces
                .iter()
                .flat_map(|b| [b[0][0], b[1][1], b[2][2]])
                .collect(),
        ),
        false => AugmentationMatrix::face_blocks(faces),
    }
}

/// `C_ii = C_local,ii + θ_i |H_ii|`.
fn row_by_row(
    mut local: Vec<f64>,
    h: &SparseMatrix<f64>,
    theta: impl Fn(usize) -> f64,
) -> AugmentationMatrix {
    for (i, c) in local.iter_mut().enumerate() {
        *c += h.get(i, i).map_or(0.0, |h_ii| theta(i) * h_ii.abs());
    }
    AugmentationMatrix::diagonal(local)
}

/// Rows that share a θ: those of a face, or single ones where n_t is no multiple of three.
pub(super) fn group(n_t: usize) -> usize {
    if n_t.is_multiple_of(3) { 3 } else { 1 }
}

/// Nothing but rounding beside the diagonal.
fn is_diagonal(block: &Block) -> bool {
    let size = (0..3).fold(0.0f64, |m, i| m.max(block[i][i]));
    (0..3).all(|i| (0..3).all(|j| i == j || block[i][j].abs() <= ROUNDING * size))
}

/// `C = Bᵀ A⁻¹ B + (H + Hᵀ)/2`; an empty column of B counts as `S_ii = |H_ii|`, or 1, since H alone is singular there.
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
        c[(i, i)] += of_itself(blocks.h_ii(i));
    }
    Ok(AugmentationMatrix::dense(c))
}
