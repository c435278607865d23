//! One 3×3 block per face.

use super::super::SaddleBlocks;
use super::AugmentationMatrix;
use super::block::Block;
use super::matrix::ZERO_PIVOT;
use super::support::{Columns, for_restricted};
use crate::SetupError;
use crate::eigen::dense;
use faer::Mat;
use fracas_operators::small::{cholesky, diagonal};
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

/// What rounding may do to a block, relative to its largest diagonal entry. Unit: 1.
pub(super) const ROUNDING: f64 = 1e-12;

/// `C_f = r(B_f)ᵀ (A|_f)⁻¹ r(B_f) + |H_ff|`, B_f = the three columns of face f, A restricted to their support.
///
/// A principal submatrix of A is the stiffness with everything else held, so `C_f ≤ (BᵀA⁻¹B)_ff`. Where A|_f is
/// singular (a support that is a whole floating body) its inverse is 1/‖A|_f‖₂, as in the local augmentation; where
/// the three columns are linearly dependent, only the diagonal of C_f is kept. H_ff is taken as it is when
/// it is symmetric positive semi-definite, and by the absolute values of its diagonal otherwise.
pub(super) fn face_block(
    blocks: &SaddleBlocks,
    columns: &Columns,
) -> Result<AugmentationMatrix, SetupError> {
    if !columns.len().is_multiple_of(3) {
        return Err(SetupError::NotApplicable {
            method: "augmentation face_block",
            reason: format!(
                "it needs three traction unknowns (normal, t1, t2) per face, and n_t = {} is not a multiple of 3; take \
                 local or local_h",
                columns.len()
            ),
        });
    }
    let faces = (0..columns.len() / 3)
        .into_par_iter()
        .map(|face| {
            let mut block = coupling(&blocks.a, columns, face)?;
            if let Some(h) = &blocks.h {
                add_stabilization(&mut block, h, face, 1.0);
            }
            Ok(block)
        })
        .collect::<Result<Vec<Block>, SetupError>>()?;
    Ok(AugmentationMatrix::face_blocks(faces))
}

/// `r(B_f)ᵀ (A|_f)⁻¹ r(B_f)`.
fn coupling(a: &SparseMatrix<f64>, columns: &Columns, face: usize) -> Result<Block, SetupError> {
    let mut support: Vec<usize> = (0..3)
        .flat_map(|k| columns.support(3 * face + k).iter().copied())
        .collect();
    support.sort_unstable();
    support.dedup();
    let n = support.len();
    let mut restricted = Mat::zeros(n, n);
    for_restricted(a, &support, |i, j, value| restricted[(i, j)] = value);
    let mut b = Mat::<f64>::zeros(n, 3);
    for k in 0..3 {
        let entries = columns
            .support(3 * face + k)
            .iter()
            .zip(columns.values(3 * face + k));
        for (row, value) in entries {
            b[(support.partition_point(|s| s < row), k)] = *value;
        }
    }
    // G = L⁻¹ r(B_f), C_f = GᵀG
    match well_conditioned_factor(&restricted) {
        Some(l) => dense::solve_lower(l.as_ref(), &mut b),
        None => {
            let values = dense::symmetric_eigenvalues(restricted.as_ref())?;
            let norm = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            if n > 0 && norm == 0.0 {
                return Err(SetupError::BadDiagonal {
                    block: "A",
                    row: support[0] + 1,
                    value: 0.0,
                    method: "the face-block augmentation (norm of A on the support of a face)",
                });
            }
            let scale = 1.0 / norm.sqrt();
            b *= faer::Scale(scale);
        }
    }
    let gram = b.transpose() * &b;
    let mut block = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            block[i][j] = gram[(i.max(j), i.min(j))];
        }
        if columns.support(3 * face + i).is_empty() {
            block[i][i] = 1.0;
        }
    }
    Ok(if cholesky(&block, ZERO_PIVOT).is_ok() {
        block
    } else {
        diagonal([block[0][0], block[1][1], block[2][2]])
    })
}

/// Cholesky factor if no pivot loses more than twelve digits.
pub(in crate::saddle) fn well_conditioned_factor(a: &Mat<f64>) -> Option<Mat<f64>> {
    const KEPT: f64 = 1e-12;
    let l = dense::cholesky(a.clone()).ok()?;
    (0..a.nrows())
        .all(|i| l[(i, i)] * l[(i, i)] > KEPT * a[(i, i)])
        .then_some(l)
}

/// `C_f ← C_f + θ |H_ff|`.
pub(super) fn add_stabilization(block: &mut Block, h: &SparseMatrix<f64>, face: usize, theta: f64) {
    let entry = |i: usize, j: usize| h.get(3 * face + i, 3 * face + j).copied().unwrap_or(0.0);
    let size = (0..3).fold(0.0f64, |m, i| m.max(entry(i, i).abs()));
    // sums over edges may differ in their last digit between the two triangles
    let skew = |i: usize, j: usize| (entry(i, j) - entry(j, i)).abs();
    let symmetric = (0..3).all(|i| (0..i).all(|j| skew(i, j) <= ROUNDING * size));
    let mean = |i: usize, j: usize| 0.5 * (entry(i, j) + entry(j, i));
    let h_ff: Block = std::array::from_fn(|i| std::array::from_fn(|j| mean(i, j)));
    let semi_definite = symmetric && is_semi_definite(&h_ff);
    for i in 0..3 {
        if semi_definite {
            (0..3).for_each(|j| block[i][j] += theta * h_ff[i][j]);
        } else {
            block[i][i] += theta * h_ff[i][i].abs();
        }
    }
}

/// All principal minors of a symmetric block are ≥ 0, up to rounding.
fn is_semi_definite(b: &Block) -> bool {
    let size = (0..3).fold(0.0f64, |m, i| m.max(b[i][i].abs()));
    let minor = |i: usize, j: usize| b[i][i] * b[j][j] - b[i][j] * b[i][j];
    let determinant = b[0][0] * minor(1, 2) - b[0][1] * (b[0][1] * b[2][2] - b[1][2] * b[0][2])
        + b[0][2] * (b[0][1] * b[1][2] - b[1][1] * b[0][2]);
    (0..3).all(|i| b[i][i] >= 0.0)
        && [(0, 1), (0, 2), (1, 2)]
            .into_iter()
            .all(|(i, j)| minor(i, j) >= -ROUNDING * size * size)
        && determinant >= -ROUNDING * size.powi(3)
}
