//! Matrix-vector routines.

use crate::flags::Trans;
use crate::level3::{Triangle, solve_left};
use crate::view::{Scalar, first, matrix, matrix_mut, op, scaled, stored};
use faer::linalg::matmul::matmul_with_conj;
use faer::prelude::ReborrowMut;
use faer::{Accum, Conj, MatMut, MatRef, Par};

/// A strided vector as a one-column view.
///
/// # Safety
/// `x` points to n entries `inc` apart, in the sense of the BLAS.
unsafe fn column<'a, T>(x: *const T, n: usize, inc: i32) -> MatRef<'a, T> {
    // Safety: as for the caller.
    unsafe { MatRef::from_raw_parts(x.offset(first(n, inc)), n, 1, inc as isize, 1) }
}

/// The same, writable.
///
/// # Safety
/// As for [`column`], and nobody else uses it meanwhile.
unsafe fn column_mut<'a, T>(x: *mut T, n: usize, inc: i32) -> MatMut<'a, T> {
    // Safety: as for the caller.
    unsafe { MatMut::from_raw_parts_mut(x.offset(first(n, inc)), n, 1, inc as isize, 1) }
}

/// `y ← α op(A) x + β y`, A being m × n as stored.
///
/// # Safety
/// As the BLAS requires: arrays of the stated sizes, y apart from A and x.
pub(crate) unsafe fn gemv<T: Scalar>(
    trans: Trans,
    (m, n): (usize, usize),
    alpha: &T,
    (a, lda): (*const T, i32),
    (x, incx): (*const T, i32),
    beta: &T,
    (y, incy): (*mut T, i32),
) {
    let (len_y, len_x) = stored(trans, m, n);
    if len_y == 0 {
        return;
    }
    // Safety: as for the caller; with no entries of x nothing is read through its pointer.
    let (a, x, mut y) = unsafe {
        (
            matrix(a, m, n, lda),
            column(x, len_x, if len_x == 0 { 1 } else { incx }),
            column_mut(y, len_y, incy),
        )
    };
    let accum = scaled(y.rb_mut(), beta, |_, _| true);
    let (a, conj) = op(a, trans);
    matmul_with_conj(y, accum, a, conj, x, Conj::No, *alpha, Par::Seq);
}

/// `x ← op(A)⁻¹ x` with an n × n triangle.
///
/// # Safety
/// As the BLAS requires: arrays of the stated sizes, x apart from A.
pub(crate) unsafe fn trsv<T: Scalar>(
    triangle: Triangle,
    n: usize,
    (a, lda): (*const T, i32),
    (x, incx): (*mut T, i32),
) {
    if n > 0 {
        // Safety: as for the caller.
        let (a, x) = unsafe { (matrix(a, n, n, lda), column_mut(x, n, incx)) };
        solve_left(triangle, a, x);
    }
}

/// `A ← A + α x yᵀ`, A being m × n.
///
/// # Safety
/// As the BLAS requires: arrays of the stated sizes, A apart from x and y.
pub(crate) unsafe fn ger<T: Scalar>(
    (m, n): (usize, usize),
    alpha: &T,
    (x, incx): (*const T, i32),
    (y, incy): (*const T, i32),
    (a, lda): (*mut T, i32),
) {
    if m == 0 || n == 0 {
        return;
    }
    // Safety: as for the caller.
    let (x, y, a) = unsafe {
        (
            column(x, m, incx),
            column(y, n, incy),
            matrix_mut(a, m, n, lda),
        )
    };
    matmul_with_conj(
        a,
        Accum::Add,
        x,
        Conj::No,
        y.transpose(),
        Conj::No,
        *alpha,
        Par::Seq,
    );
}
