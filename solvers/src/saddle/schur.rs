//! The primal Schur complement `S_u = A + B C⁻¹ Bᵀ` and its exact inverse.

use super::leading::Leading;
use super::scaling::ScaledInverse;
use super::{AugmentationMatrix, SaddleBlocks};
use crate::SetupError;
use crate::direct::{DirectChoice, DirectSolver, Factorization, Kind};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;

/// `S_u = A + (BF)(BF)ᵀ` with `C⁻¹ = F Fᵀ`: symmetric to the last bit where A is.
///
/// # Cost
/// Two sparse products. A dense C couples every row of B with every other one.
pub fn primal_schur(
    a: &SparseMatrix<f64>,
    b: &SparseMatrix<f64>,
    c: &AugmentationMatrix,
) -> Result<SparseMatrix<f64>, SetupError> {
    let root = c.inverse_root()?;
    let scaled = b * &root;
    let transpose = scaled.transpose_view().to_csr();
    let augmentation = &scaled * &transpose;
    Ok(a + &augmentation)
}

/// `S̃_u⁻¹ = S_u⁻¹` by a sparse factorization.
///
/// For a C⁻¹ with a sparse root, S_u is assembled and factorized (LLᵀ). For any other C, `S_u y = x` is the first
/// row of `[A B; Bᵀ −C] [y; w] = [x; 0]`, factorized by LDLᵀ: no fill from BC⁻¹Bᵀ and no subtraction of large terms,
/// which the Woodbury formula has where BC⁻¹Bᵀ dominates A. It needs A positive definite; where A leaves blocks of rock free that fractures
/// hold, LU with pivots finds what LDLᵀ in a given order cannot.
///
/// # Errors
/// [`SetupError::NotPositiveDefinite`] or [`SetupError::Singular`] for S_u when a floating block is touched by no
/// fracture.
pub fn exact_inverse(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    direct: &dyn DirectSolver,
) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
    if !c.is_sparse() {
        let factors = augmented_factors(blocks, c, direct).map_err(about_s_u)?;
        return Ok(Box::new(Leading::new(blocks.n_u(), factors)));
    }
    let s_u = primal_schur(&blocks.a, &blocks.b1, c)?;
    let inverse = ScaledInverse::new(&s_u, direct, "S_u").map_err(about_s_u)?;
    Ok(Box::new(inverse))
}

/// Name of [`diagonal_schur`] in errors.
pub(super) const S_D: &str = "S = H + B2 diag(A)⁻¹B1";

/// `S_D = H + B2 diag(A)⁻¹ B1`, what `H + B2 A⁻¹ B1` becomes for a diagonal A.
///
/// # Errors
/// [`SetupError::BadDiagonal`] naming the row of A that has no positive diagonal entry.
pub(super) fn diagonal_schur(blocks: &SaddleBlocks) -> Result<SparseMatrix<f64>, SetupError> {
    let mut scaled = blocks.b1.clone();
    for (i, mut row) in scaled.outer_iterator_mut().enumerate() {
        let a_ii = blocks.a.get(i, i).copied().unwrap_or(0.0);
        if !(a_ii > 0.0 && a_ii.is_finite()) {
            return Err(SetupError::BadDiagonal {
                block: "A",
                row: i + 1,
                value: a_ii,
                method: S_D,
            });
        }
        row.iter_mut().for_each(|(_, b)| *b /= a_ii);
    }
    let product = &blocks.b2_rows() * &scaled;
    Ok(match &blocks.h {
        Some(h) => h + &product,
        None => product,
    })
}

/// `S_D⁻¹` by a sparse LU factorization: H, and so S_D, may be unsymmetric or indefinite.
///
/// # Errors
/// Those of [`diagonal_schur`], and [`SetupError::Singular`] naming S_D.
pub(super) fn diagonal_schur_inverse(
    blocks: &SaddleBlocks,
    direct: DirectChoice,
) -> Result<Box<dyn Factorization>, SetupError> {
    let s = diagonal_schur(blocks)?;
    let symbolic = direct.solver()?.analyze(&s, Kind::General)?;
    symbolic.factor(&s).map_err(|error| error.in_block(S_D))
}

/// Names S_u in the failure of a factorization and says what makes it singular.
fn about_s_u(error: SetupError) -> SetupError {
    let mut error = error.in_block("S_u");
    if let SetupError::NotPositiveDefinite { advice, .. } | SetupError::Singular { advice, .. } =
        &mut error
    {
        "a block of rock is held neither by boundary conditions nor by a fracture, or A is indefinite"
            .clone_into(advice);
    }
    error
}

/// Of `[A B; Bᵀ −C]`, whose A is positive semidefinite.
fn augmented_factors(
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    direct: &dyn DirectSolver,
) -> Result<Box<dyn Factorization>, SetupError> {
    let matrix = augmented(blocks, c);
    let factors = |kind| direct.analyze(&matrix, kind)?.factor(&matrix);
    // a pivot of 0
    factors(Kind::QuasiDefinite).or_else(|_| factors(Kind::General))
}

/// `[A B; Bᵀ −C]`.
fn augmented(blocks: &SaddleBlocks, c: &AugmentationMatrix) -> SparseMatrix<f64> {
    let augmented = SaddleBlocks {
        b2: None,
        h: Some(c.entries()),
        flow: None,
        ..blocks.clone()
    };
    augmented.assembled()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eigen::dense::to_dense;
    use crate::eigen::factors::inverse;
    use crate::saddle::samples::two_chains;
    use faer::Mat;
    use fracas_operators::laws::probe;
    use fracas_operators::sparse::Triplets;

    /// `RRᵀ/n + I/10`.
    fn dense_c(n: usize, seed: u64) -> AugmentationMatrix {
        let r: Vec<f64> = probe(n * n, seed);
        let r = Mat::from_fn(n, n, |i, j| r[i * n + j]);
        let identity = Mat::<f64>::identity(n, n);
        let c = &r * r.transpose() * faer::Scale(1.0 / n as f64) + identity * faer::Scale(0.1);
        AugmentationMatrix::from_dense(c).unwrap()
    }

    #[test]
    fn a_dense_c_goes_with_blocks_that_only_fractures_hold() {
        let direct = DirectChoice::Faer.solver().unwrap();
        for seed in 0..60u64 {
            let (n, m) = (3 + (seed % 9) as usize, 2 + (seed % 2) as usize);
            let contrast = 10f64.powi((seed % 13) as i32 - 6);
            let blocks = two_chains(n, m, contrast, !seed.is_multiple_of(4));
            let c = dense_c(m, seed);
            let s_u = exact_inverse(&blocks, &c, direct.as_ref()).unwrap();
            let b = to_dense(&blocks.b1);
            let by_c = &b * inverse(c.to_dense().as_ref()).unwrap() * b.transpose();
            let expected = inverse((to_dense(&blocks.a) + by_c).as_ref()).unwrap();
            let r: Vec<f64> = probe(2 * n, seed + 500);
            let mut z = vec![0.0; 2 * n];
            s_u.solve(&r, &mut z, &mut vec![0.0; s_u.work_len()]);
            let of_row = |i: usize| (0..2 * n).map(|j| expected[(i, j)] * r[j]).sum::<f64>();
            let size = (0..2 * n).fold(0.0f64, |size, i| size.max(of_row(i).abs()));
            for (i, z) in z.iter().enumerate() {
                assert!(
                    (z - of_row(i)).abs() < 1e-7 * size,
                    "{seed}: {z} {}",
                    of_row(i)
                );
            }
        }
    }

    #[test]
    fn a_dense_c_does_not_go_with_a_block_that_nothing_holds() {
        let direct = DirectChoice::Faer.solver().unwrap();
        let mut loose = two_chains(6, 3, 1.0, true);
        let nothing = Triplets::new((12, 3));
        loose.b1 = nothing.to_csr();
        assert!(exact_inverse(&loose, &dense_c(3, 3), direct.as_ref()).is_err());
    }
}
