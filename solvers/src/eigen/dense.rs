//! Dense factorizations and spectra on faer's kernels.

use super::tridiagonal::tridiagonal;
use crate::SetupError;
use faer::diag::{Diag, DiagRef};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt::factor as ldlt, llt::factor as llt};
use faer::linalg::evd::{self, ComputeEigenvectors};
use faer::linalg::svd::{self, ComputeSvdVectors};
use faer::linalg::{matmul, temp_mat_scratch, triangular_solve};
use faer::{Accum, Mat, MatMut, MatRef, Par, c64};
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

/// Columns that one task handles: depends on nothing, so the bits do not depend on the number of threads.
const COLUMNS_PER_TASK: usize = 64;

/// The failure of an iteration inside faer: only NaN or infinity in the matrix brings it about.
pub(super) fn not_converged<E>(_: E) -> SetupError {
    SetupError::NotApplicable {
        method: "dense eigenvalues",
        reason: "the iteration did not converge; the matrix holds NaN, infinity or entries that overflow when squared"
            .to_owned(),
    }
}

pub(super) fn buffer(request: faer::dyn_stack::StackReq) -> MemBuffer {
    MemBuffer::new(request)
}

/// A sparse matrix with all its zeros.
pub fn to_dense(a: &SparseMatrix<f64>) -> Mat<f64> {
    let mut dense = Mat::zeros(a.rows(), a.cols());
    for (outer, vector) in a.outer_iterator().enumerate() {
        for (inner, value) in vector.iter() {
            let (i, j) = if a.is_csr() {
                (outer, inner)
            } else {
                (inner, outer)
            };
            dense[(i, j)] += *value;
        }
    }
    dense
}

/// Eigenvalues of a symmetric matrix (its lower triangle), ascending.
pub fn symmetric_eigenvalues(a: MatRef<'_, f64>) -> Result<Vec<f64>, SetupError> {
    let n = a.nrows();
    let largest = (0..n).flat_map(|j| (j..n).map(move |i| a[(i, j)].abs()));
    // a power of two keeps squares in range and changes no digit
    let scale = match largest.fold(0.0, |m: f64, v| if v > m || v.is_nan() { v } else { m }) {
        0.0 => return Ok(vec![0.0; n]),
        largest if largest.is_finite() => largest.log2().floor().exp2(),
        _ => return Err(not_converged(())),
    };
    let mut entries = vec![0.0; n * n];
    for j in 0..n {
        for i in j..n {
            entries[j * n + i] = a[(i, j)] / scale;
        }
    }
    let (diagonal, below) = tridiagonal(&mut entries, n);
    drop(entries);
    let mut s = Diag::<f64>::zeros(n);
    let mut memory = buffer(temp_mat_scratch::<f64>(n, 1).array(2));
    evd::tridiagonal_self_adjoint_evd(
        DiagRef::from_slice(&diagonal),
        DiagRef::from_slice(&below),
        s.as_mut(),
        None,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(not_converged)?;
    Ok(s.column_vector().iter().map(|v| scale * v).collect())
}

/// Eigenvalues (ascending) and orthonormal eigenvectors of a symmetric matrix (its lower triangle).
pub fn symmetric_eigen(a: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), SetupError> {
    let n = a.nrows();
    let (mut s, mut u) = (Diag::<f64>::zeros(n), Mat::zeros(n, n));
    let request = evd::self_adjoint_evd_scratch::<f64>(
        n,
        ComputeEigenvectors::Yes,
        Par::Seq,
        Default::default(),
    );
    let mut memory = buffer(request);
    evd::self_adjoint_evd(
        a,
        s.as_mut(),
        Some(u.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(not_converged)?;
    Ok((s.column_vector().iter().copied().collect(), u))
}

/// Eigenvalues of a square matrix, in the order in which the Schur form gives them.
pub fn general_eigenvalues(a: MatRef<'_, f64>) -> Result<Vec<c64>, SetupError> {
    let n = a.nrows();
    let (mut re, mut im) = (Diag::<f64>::zeros(n), Diag::<f64>::zeros(n));
    let no = ComputeEigenvectors::No;
    let mut memory = buffer(evd::evd_scratch::<f64>(
        n,
        no,
        no,
        Par::Seq,
        Default::default(),
    ));
    evd::evd_real(
        a,
        re.as_mut(),
        im.as_mut(),
        None,
        None,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(not_converged)?;
    let pairs = re.column_vector().iter().zip(im.column_vector().iter());
    Ok(pairs.map(|(re, im)| c64::new(*re, *im)).collect())
}

/// Eigenvalues and right eigenvectors of a square matrix, columns of Euclidean length 1.
pub fn general_eigen(a: MatRef<'_, f64>) -> Result<(Vec<c64>, Mat<c64>), SetupError> {
    let n = a.nrows();
    let (mut re, mut im) = (Diag::<f64>::zeros(n), Diag::<f64>::zeros(n));
    let mut packed = Mat::<f64>::zeros(n, n);
    let (no, yes) = (ComputeEigenvectors::No, ComputeEigenvectors::Yes);
    let mut memory = buffer(evd::evd_scratch::<f64>(
        n,
        no,
        yes,
        Par::Seq,
        Default::default(),
    ));
    evd::evd_real(
        a,
        re.as_mut(),
        im.as_mut(),
        None,
        Some(packed.as_mut()),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(not_converged)?;
    let pairs = re.column_vector().iter().zip(im.column_vector().iter());
    let values: Vec<c64> = pairs.map(|(re, im)| c64::new(*re, *im)).collect();
    // A pair of conjugate eigenvalues shares two columns: real and imaginary part of the first one's vector.
    let mut vectors = Mat::<c64>::zeros(n, n);
    let mut j = 0;
    while j < n {
        let width = if values[j].im == 0.0 { 1 } else { 2 };
        let part = |i: usize| if width == 2 { packed[(i, j + 1)] } else { 0.0 };
        let norm = (0..n)
            .map(|i| packed[(i, j)].powi(2) + part(i).powi(2))
            .sum::<f64>()
            .sqrt();
        for i in 0..n {
            let entry = c64::new(packed[(i, j)] / norm, part(i) / norm);
            vectors[(i, j)] = entry;
            if width == 2 {
                vectors[(i, j + 1)] = entry.conj();
            }
        }
        j += width;
    }
    Ok((values, vectors))
}

/// Singular values, descending: min(rows, columns) of them.
pub fn singular_values(a: MatRef<'_, f64>) -> Result<Vec<f64>, SetupError> {
    let (m, n) = a.shape();
    let mut s = Diag::<f64>::zeros(m.min(n));
    let no = ComputeSvdVectors::No;
    let mut memory = buffer(svd::svd_scratch::<f64>(
        m,
        n,
        no,
        no,
        Par::Seq,
        Default::default(),
    ));
    svd::svd(
        a,
        s.as_mut(),
        None,
        None,
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(not_converged)?;
    Ok(s.column_vector().iter().copied().collect())
}

/// `A = L Lᵀ` from the lower triangle, or the first pivot (from 0) that is not positive.
pub fn cholesky(a: Mat<f64>) -> Result<Mat<f64>, usize> {
    let n = a.nrows();
    let mut a = a;
    let mut memory = buffer(llt::cholesky_in_place_scratch::<f64>(
        n,
        Par::Seq,
        Default::default(),
    ));
    llt::cholesky_in_place(
        a.as_mut(),
        Default::default(),
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|llt::LltError::NonPositivePivot { index }| index)?;
    zero_above(&mut a);
    Ok(a)
}

/// L of `A = L Lᵀ` for a positive semidefinite matrix with a unit diagonal: a row with a pivot of `least` or less depends on
/// those before it and gets the pivot `left_out`, which makes its column of L zero to rounding.
///
/// # Errors
/// The row that holds what is no number.
pub fn independent_cholesky(mut a: Mat<f64>, least: f64, left_out: f64) -> Result<Mat<f64>, usize> {
    let n = a.nrows();
    let mut memory = buffer(ldlt::cholesky_in_place_scratch::<f64>(
        n,
        Par::Seq,
        Default::default(),
    ));
    // faer 0.24.4: a replaced pivot of LLᵀ never gets to the diagonal of L, one of LDLᵀ gets to that of D
    ldlt::cholesky_in_place(
        a.as_mut(),
        ldlt::LdltRegularization {
            dynamic_regularization_signs: Some(&vec![1; n]),
            dynamic_regularization_delta: left_out,
            dynamic_regularization_epsilon: least,
        },
        Par::Seq,
        MemStack::new(&mut memory),
        Default::default(),
    )
    .map_err(|ldlt::LdltError::ZeroPivot { index }| index)?;
    // L √D
    for j in 0..n {
        let root = a[(j, j)].sqrt();
        a[(j, j)] = root;
        for i in j + 1..n {
            a[(i, j)] *= root;
        }
    }
    zero_above(&mut a);
    Ok(a)
}

fn zero_above(l: &mut Mat<f64>) {
    for j in 1..l.nrows() {
        for i in 0..j {
            l[(i, j)] = 0.0;
        }
    }
}

/// Splits the columns of `b` at fixed places and works on the parts in parallel.
pub(super) fn for_column_blocks(
    b: MatMut<'_, f64>,
    first: usize,
    work: &(impl Fn(usize, MatMut<'_, f64>) + Sync),
) {
    let n = b.ncols();
    if n <= COLUMNS_PER_TASK {
        work(first, b);
        return;
    }
    let middle = (n / COLUMNS_PER_TASK).div_ceil(2) * COLUMNS_PER_TASK;
    let (left, right) = b.split_at_col_mut(middle);
    rayon::join(
        || for_column_blocks(left, first, work),
        || for_column_blocks(right, first + middle, work),
    );
}

/// `A B`.
pub fn multiply(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    for_column_blocks(c.as_mut(), 0, &|first, part| {
        let b = b.subcols(first, part.ncols());
        matmul::matmul(part, Accum::Replace, a, b, 1.0, Par::Seq);
    });
    c
}

/// `B ← L⁻¹ B` for a lower triangle `L`.
pub fn solve_lower(l: MatRef<'_, f64>, b: &mut Mat<f64>) {
    for_column_blocks(b.as_mut(), 0, &|_, part| {
        triangular_solve::solve_lower_triangular_in_place(l, part, Par::Seq);
    });
}

/// `B ← L⁻ᵀ B` for a lower triangle `L`.
pub fn solve_lower_adjoint(l: MatRef<'_, f64>, b: &mut Mat<f64>) {
    for_column_blocks(b.as_mut(), 0, &|_, part| {
        triangular_solve::solve_upper_triangular_in_place(l.transpose(), part, Par::Seq);
    });
}

/// `S B` with a sparse `S` stored by rows.
pub fn sparse_multiply(s: &SparseMatrix<f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let columns: Vec<Vec<f64>> = (0..b.ncols())
        .into_par_iter()
        .map(|j| {
            s.outer_iterator()
                .map(|row| row.iter().map(|(k, v)| *v * b[(k, j)]).sum())
                .collect()
        })
        .collect();
    Mat::from_fn(s.rows(), b.ncols(), |i, j| columns[j][i])
}

/// `A ← (A + Aᵀ)/2`.
pub fn symmetrize(a: &mut Mat<f64>) {
    for j in 0..a.ncols() {
        for i in 0..j {
            let mean = 0.5 * (a[(i, j)] + a[(j, i)]);
            a[(i, j)] = mean;
            a[(j, i)] = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::laws::probe;

    fn random(n: usize, m: usize, seed: u64) -> Mat<f64> {
        let values: Vec<f64> = probe(n * m, seed);
        Mat::from_fn(n, m, |i, j| values[j * n + i])
    }

    #[test]
    fn factors_and_spectra_reproduce_the_matrix() {
        let a = random(150, 150, 1);
        let mut gram = multiply(a.as_ref(), a.transpose());
        symmetrize(&mut gram);
        let l = cholesky(gram.clone()).unwrap();
        assert!((multiply(l.as_ref(), l.transpose()) - &gram).norm_max() < 1e-12);
        let mut x = gram.clone();
        solve_lower(l.as_ref(), &mut x);
        solve_lower_adjoint(l.as_ref(), &mut x);
        assert!((x - Mat::<f64>::identity(150, 150)).norm_max() < 1e-5);

        let values = symmetric_eigenvalues(gram.as_ref()).unwrap();
        let (again, v) = symmetric_eigen(gram.as_ref()).unwrap();
        let singular = singular_values(a.as_ref()).unwrap();
        for k in 0..150 {
            assert!((values[k] - again[k]).abs() < 1e-12);
            assert!((singular[149 - k].powi(2) - values[k]).abs() < 1e-11);
        }
        let image = multiply(gram.as_ref(), v.as_ref());
        let scaled = Mat::from_fn(150, 150, |i, j| v[(i, j)] * values[j]);
        assert!((image - scaled).norm_max() < 1e-11);
    }

    #[test]
    fn general_eigenvalues_match_trace_and_determinant_of_a_rotation() {
        let (c, s) = (0.6, 0.8);
        let a = Mat::from_fn(2, 2, |i, j| [[c, -s], [s, c]][i][j]);
        let mut values = general_eigenvalues(a.as_ref()).unwrap();
        values.sort_by(|a, b| a.im.total_cmp(&b.im));
        assert!((values[0] - c64::new(0.6, -0.8)).norm() < 1e-15);
        assert!((values[1] - c64::new(0.6, 0.8)).norm() < 1e-15);
    }

    #[test]
    fn general_eigenvectors_satisfy_their_equation() {
        let a = random(40, 40, 5);
        let (values, v) = general_eigen(a.as_ref()).unwrap();
        assert!(values.iter().any(|l| l.im != 0.0));
        for j in 0..40 {
            for i in 0..40 {
                let image: c64 = (0..40)
                    .map(|k| v[(k, j)] * a[(i, k)])
                    .fold(c64::new(0.0, 0.0), |s, x| s + x);
                assert!((image - values[j] * v[(i, j)]).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn an_indefinite_matrix_names_its_pivot() {
        let a = Mat::from_fn(3, 3, |i, j| if i != j { 0.0 } else { [2.0, 1.0, -1.0][i] });
        assert_eq!(cholesky(a).unwrap_err(), 2);
    }
}
