//! Matrix-matrix routines.

use crate::flags::{Trans, Uplo};
use crate::view::{Scalar, matrix, matrix_mut, op, par, scaled, stored};
use faer::linalg::matmul::{matmul_with_conj, triangular};
use faer::linalg::triangular_solve as solve;
use faer::prelude::ReborrowMut;
use faer::{Conj, MatMut, MatRef, Par};

/// `C ← α op(A) op(B) + β C`, C being m × n and the inner dimension k.
///
/// # Safety
/// As the BLAS requires: arrays of the stated sizes, C apart from A and B.
pub(crate) unsafe fn gemm<T: Scalar>(
    (trans_a, trans_b): (Trans, Trans),
    (m, n, k): (usize, usize, usize),
    alpha: &T,
    (a, lda): (*const T, i32),
    (b, ldb): (*const T, i32),
    beta: &T,
    (c, ldc): (*mut T, i32),
) {
    if m == 0 || n == 0 {
        return;
    }
    let ((rows_a, cols_a), (rows_b, cols_b)) = (stored(trans_a, m, k), stored(trans_b, k, n));
    // Safety: as for the caller.
    let (a, b, mut c) = unsafe {
        (
            matrix(a, rows_a, cols_a, lda),
            matrix(b, rows_b, cols_b, ldb),
            matrix_mut(c, m, n, ldc),
        )
    };
    let accum = scaled(c.rb_mut(), beta, |_, _| true);
    let ((a, conj_a), (b, conj_b)) = (op(a, trans_a), op(b, trans_b));
    matmul_with_conj(c, accum, a, conj_a, b, conj_b, *alpha, par(m, n, m * n * k));
}

/// `C ← α A op'(A) + β C` (`trans = N`) or `α op'(A) A + β C`, one triangle of the n × n matrix C;
/// op' is the transpose for `syrk` and the adjoint for `herk`.
///
/// # Safety
/// As the BLAS requires: arrays of the stated sizes, C apart from A.
pub(crate) unsafe fn rank_k<T: Scalar>(
    (uplo, trans, hermitian): (Uplo, Trans, bool),
    (n, k): (usize, usize),
    alpha: &T,
    (a, lda): (*const T, i32),
    beta: &T,
    (c, ldc): (*mut T, i32),
) {
    if n == 0 {
        return;
    }
    let (rows, cols) = stored(trans, n, k);
    // Safety: as for the caller.
    let (a, mut c) = unsafe { (matrix(a, rows, cols, lda), matrix_mut(c, n, n, ldc)) };
    let accum = scaled(c.rb_mut(), beta, |i, j| match uplo {
        Uplo::Lower => i >= j,
        Uplo::Upper => i <= j,
    });
    let structure = match uplo {
        Uplo::Lower => triangular::BlockStructure::TriangularLower,
        Uplo::Upper => triangular::BlockStructure::TriangularUpper,
    };
    let conj = if hermitian { Conj::Yes } else { Conj::No };
    // C = X Xᴴ with X = A, or C = Xᴴ' … with X = op(A): conjugation sits on the factor that is transposed
    let (left, conj_left, right, conj_right) = match trans {
        Trans::No => (a, Conj::No, a.transpose(), conj),
        Trans::Transpose | Trans::Adjoint => (a.transpose(), conj, a, Conj::No),
    };
    if !T::IS_REAL {
        // faer 0.24.4 writes beyond the triangle of a complex product on some processors: column by column instead
        for j in 0..n {
            let (first, last) = match uplo {
                Uplo::Lower => (j, n),
                Uplo::Upper => (0, j + 1),
            };
            matmul_with_conj(
                c.rb_mut().submatrix_mut(first, j, last - first, 1),
                accum,
                left.subrows(first, last - first),
                conj_left,
                right.subcols(j, 1),
                conj_right,
                *alpha,
                Par::Seq,
            );
        }
        return;
    }
    triangular::matmul_with_conj(
        c,
        structure,
        accum,
        left,
        triangular::BlockStructure::Rectangular,
        conj_left,
        right,
        triangular::BlockStructure::Rectangular,
        conj_right,
        *alpha,
        par(n, n, n * n * k / 2),
    );
}

/// Triangle, op and diagonal of a triangular matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Which triangle is stored.
    pub(crate) uplo: Uplo,
    /// op.
    pub(crate) trans: Trans,
    /// Unit diagonal, not stored.
    pub(crate) unit: bool,
}

/// `B ← op(A)⁻¹ B` on views.
pub(crate) fn solve_left<T: Scalar>(triangle: Triangle, a: MatRef<'_, T>, b: MatMut<'_, T>) {
    let par = par(a.nrows(), b.ncols(), a.nrows() * a.nrows() / 2 * b.ncols());
    let (a, conj) = op(a, triangle.trans);
    let lower = (triangle.uplo == Uplo::Lower) == (triangle.trans == Trans::No);
    match (lower, triangle.unit) {
        (true, false) => solve::solve_lower_triangular_in_place_with_conj(a, conj, b, par),
        (true, true) => solve::solve_unit_lower_triangular_in_place_with_conj(a, conj, b, par),
        (false, false) => solve::solve_upper_triangular_in_place_with_conj(a, conj, b, par),
        (false, true) => solve::solve_unit_upper_triangular_in_place_with_conj(a, conj, b, par),
    }
}

/// `B ← α op(A)⁻¹ B` (left) or `B ← α B op(A)⁻¹` (right), B being m × n.
///
/// # Safety
/// As the BLAS requires: arrays of the stated sizes, B apart from A.
pub(crate) unsafe fn trsm<T: Scalar>(
    left: bool,
    triangle: Triangle,
    (m, n): (usize, usize),
    alpha: &T,
    (a, lda): (*const T, i32),
    (b, ldb): (*mut T, i32),
) {
    if m == 0 || n == 0 {
        return;
    }
    let order = if left { m } else { n };
    // Safety: as for the caller.
    let (a, mut b) = unsafe { (matrix(a, order, order, lda), matrix_mut(b, m, n, ldb)) };
    if let faer::Accum::Replace = scaled(b.rb_mut(), alpha, |_, _| true) {
        b.fill(T::default());
        return;
    }
    if left {
        return solve_left(triangle, a, b);
    }
    // X op(A) = B  ⇔  op(A)ᵀ Xᵀ = Bᵀ
    match triangle.trans {
        Trans::No => {
            let trans = Trans::Transpose;
            solve_left(Triangle { trans, ..triangle }, a, b.transpose_mut());
        }
        Trans::Transpose => {
            let trans = Trans::No;
            solve_left(Triangle { trans, ..triangle }, a, b.transpose_mut());
        }
        // X Aᴴ = B  ⇔  conj(A) Xᵀ = Bᵀ
        Trans::Adjoint => {
            let (lower, b) = (triangle.uplo == Uplo::Lower, b.transpose_mut());
            let par = par(order, m, order * order / 2 * m);
            match (lower, triangle.unit) {
                (true, false) => {
                    solve::solve_lower_triangular_in_place_with_conj(a, Conj::Yes, b, par)
                }
                (true, true) => {
                    solve::solve_unit_lower_triangular_in_place_with_conj(a, Conj::Yes, b, par)
                }
                (false, false) => {
                    solve::solve_upper_triangular_in_place_with_conj(a, Conj::Yes, b, par)
                }
                (false, true) => {
                    solve::solve_unit_upper_triangular_in_place_with_conj(a, Conj::Yes, b, par)
                }
            }
        }
    }
}
