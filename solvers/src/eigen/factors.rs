//! Dense factorizations whose factors are wanted themselves.

use super::dense::{buffer, not_converged};
use crate::SetupError;
use faer::diag::Diag;
use faer::dyn_stack::MemStack;
use faer::linalg::cholesky::lblt::factor as lblt;
use faer::linalg::evd::ComputeEigenvectors;
use faer::linalg::evd::hessenberg::{hessenberg_in_place, hessenberg_in_place_scratch};
use faer::linalg::gevd::GeneralizedSchurParams;
use faer::linalg::gevd::qz_real::{hessenberg_to_qz, hessenberg_to_qz_scratch};
use faer::linalg::lu::partial_pivoting::{factor as lu, inverse as lu_inverse};
use faer::linalg::qr::no_pivoting::factor::recommended_block_size;
use faer::{Auto, Col, Mat, MatRef, Par};

/// A real Schur form: an upper quasi-triangular matrix that is orthogonally similar to a square one, with blocks of one or two rows on its
/// diagonal and zeros below them.
///
/// QZ of the pencil (H, I), H a Hessenberg matrix, gives `S = QᵀHZ` and `QᵀZ = diag(±1)`, so that `QᵀHQ = S diag(±1)`, to n roundings.
/// Without blocks of sweeps: with them, version 0.24.4 of faer did not end at 600 rows.
///
/// # Cost
/// 10 n³/3 flops for H and some 30 n³ for S.
///
/// # Errors
/// NaN or infinity, and where QZ does not converge.
pub fn schur(a: Mat<f64>) -> Result<Mat<f64>, SetupError> {
    let n = a.nrows();
    let mut s = hessenberg(a)?;
    let mut identity = Mat::<f64>::identity(n, n);
    let params = GeneralizedSchurParams {
        blocking_threshold: usize::MAX,
        ..Auto::<f64>::auto()
    };
    let mut memory = buffer(hessenberg_to_qz_scratch::<f64>(n, Par::Seq, params));
    let mut values = [(); 3].map(|()| Col::zeros(n));
    let [re, im, scale] = values.each_mut().map(Col::as_mut);
    hessenberg_to_qz(
        s.as_mut(),
        identity.as_mut(),
        None,
        None,
        re,
        im,
        scale,
        ComputeEigenvectors::Yes,
        Par::Seq,
        params,
        MemStack::new(&mut memory),
    );
    for j in 0..n {
        let sign = 1f64.copysign(identity[(j, j)]);
        (0..n).for_each(|i| s[(i, j)] *= sign);
    }
    let pairs: Vec<bool> = (1..n).map(|j| s[(j, j - 1)] != 0.0).collect();
    let is_split = pairs.windows(2).all(|pair| !(pair[0] && pair[1]));
    let is_zero = (0..n).all(|j| (j + 2..n).all(|i| s[(i, j)] == 0.0));
    if is_split && is_zero && s.is_all_finite() {
        Ok(s)
    } else {
        Err(not_converged(()))
    }
}

/// An upper Hessenberg matrix that is orthogonally similar to a square one.
fn hessenberg(mut a: Mat<f64>) -> Result<Mat<f64>, SetupError> {
    let n = a.nrows();
    if !a.is_all_finite() {
        return Err(not_converged(()));
    }
    if n < 3 {
        return Ok(a);
    }
    let block = recommended_block_size::<f64>(n - 1, n - 1);
    let mut householder = Mat::zeros(block, n - 1);
    let mut memory = buffer(hessenberg_in_place_scratch::<f64>(
        n,
        block,
        Par::Seq,
        Default::default(),
    ));
    hessenberg_in_place(
        a.as_mut(),
        householder.as_mut(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    );
    for j in 0..n {
        for i in j + 2..n {
            a[(i, j)] = 0.0;
        }
    }
    Ok(a)
}

/// `P S Pᵀ = L D Lᵀ` of a symmetric S.
pub struct BunchKaufman {
    /// Unit lower triangle.
    pub l: Mat<f64>,
    /// Diagonal of D.
    pub diagonal: Vec<f64>,
    /// Entry (j + 1, j) of D; 0 but in a 2 × 2 block that begins with j.
    pub below: Vec<f64>,
    /// Row i of P S Pᵀ is row `permutation[i]` of S.
    pub permutation: Vec<usize>,
}

/// Bunch–Kaufman factors of a symmetric matrix (its lower triangle).
///
/// # Cost
/// n³/3 flops.
pub fn bunch_kaufman(mut s: Mat<f64>) -> BunchKaufman {
    let n = s.nrows();
    let mut below = Diag::<f64>::zeros(n);
    let (mut permutation, mut back) = (vec![0_usize; n], vec![0_usize; n]);
    let mut memory = buffer(lblt::cholesky_in_place_scratch::<usize, f64>(
        n,
        Par::Seq,
        Default::default(),
    ));
    lblt::cholesky_in_place(
        s.as_mut(),
        below.as_mut(),
        &mut permutation,
        &mut back,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    );
    let diagonal = (0..n).map(|j| s[(j, j)]).collect();
    for j in 0..n {
        (0..j).for_each(|i| s[(i, j)] = 0.0);
        s[(j, j)] = 1.0;
    }
    BunchKaufman {
        l: s,
        diagonal,
        below: below.column_vector().iter().copied().collect(),
        permutation,
    }
}

/// A⁻¹ by Gaussian elimination with row exchanges; `None` where a pivot vanishes or overflows.
pub fn inverse(a: MatRef<'_, f64>) -> Option<Mat<f64>> {
    let n = a.nrows();
    let mut factors = a.to_owned();
    let (mut permutation, mut back) = (vec![0_usize; n], vec![0_usize; n]);
    let request = lu::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default());
    let mut memory = buffer(request);
    let (_, permutation) = lu::lu_in_place(
        factors.as_mut(),
        &mut permutation,
        &mut back,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    );
    let mut inverse = Mat::zeros(n, n);
    let mut memory = buffer(lu_inverse::inverse_scratch::<usize, f64>(n, Par::Seq));
    lu_inverse::inverse(
        inverse.as_mut(),
        factors.as_ref(),
        factors.as_ref(),
        permutation,
        Par::Seq,
        MemStack::new(&mut memory),
    );
    inverse.is_all_finite().then_some(inverse)
}

#[cfg(test)]
mod tests {
    use super::super::dense;
    use super::*;
    use fracas_operators::laws::probe;

    fn random(n: usize, seed: u64) -> Mat<f64> {
        let values: Vec<f64> = probe(n * n, seed);
        Mat::from_fn(n, n, |i, j| values[j * n + i])
    }

    #[test]
    fn factors_reproduce_the_matrix() {
        for (n, seed) in [(1, 1), (2, 2), (7, 3), (90, 4), (300, 5)] {
            let a = random(n, seed);
            let unit = &a * inverse(a.as_ref()).unwrap();
            assert!((unit - Mat::<f64>::identity(n, n)).norm_max() < 1e-8);
            let mut s = a.clone();
            dense::symmetrize(&mut s);
            let f = bunch_kaufman(s.clone());
            let d = Mat::from_fn(n, n, |i, j| match (i, j) {
                _ if i == j => f.diagonal[i],
                _ if i == j + 1 => f.below[j],
                _ if j == i + 1 => f.below[i],
                _ => 0.0,
            });
            let product = &f.l * d * f.l.transpose();
            let p = &f.permutation;
            let permuted = Mat::from_fn(n, n, |i, j| s[(p[i], p[j])]);
            assert!((product - permuted).norm_max() < 1e-11);
            // the singular values of a shifted Schur form are those of the shifted matrix
            let t = schur(a.clone()).unwrap();
            let shifted = |m: &Mat<f64>| m - Mat::<f64>::identity(n, n) * 0.3;
            let of = |m: &Mat<f64>| dense::singular_values(shifted(m).as_ref()).unwrap();
            for (found, expected) in of(&t).iter().zip(of(&a)) {
                assert!((found - expected).abs() < 1e-11 * a.norm_l2(), "{n}");
            }
        }
        assert!(inverse(Mat::zeros(3, 3).as_ref()).is_none());
    }
}
