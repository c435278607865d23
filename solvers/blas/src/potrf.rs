//! Cholesky factorization of a dense block.

use crate::flags::Uplo;
use crate::view::{Scalar, matrix_mut, par};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, cholesky_in_place, cholesky_in_place_scratch};

/// `A = L Lᴴ` or `Uᴴ U` in the stored triangle; returns 0, or the order of the first leading block that is not
/// positive definite.
///
/// # Safety
/// `a` is an n × n Fortran array with leading dimension `lda` that nobody else uses meanwhile.
pub(crate) unsafe fn potrf<T: Scalar>(uplo: Uplo, n: usize, (a, lda): (*mut T, i32)) -> i32 {
    if n == 0 {
        return 0;
    }
    // Safety: as for the caller.
    let a = unsafe { matrix_mut(a, n, n, lda) };
    // the upper triangle of A is the lower one of conj(A), whose factor is conj(Uᴴ) = Uᵀ
    let a = match uplo {
        Uplo::Lower => a,
        Uplo::Upper => a.transpose_mut(),
    };
    let par = par(n, n, n * n * n / 6);
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<T>(n, par, Default::default()));
    match cholesky_in_place(
        a,
        Default::default(),
        par,
        MemStack::new(&mut memory),
        Default::default(),
    ) {
        Ok(_) => 0,
        Err(LltError::NonPositivePivot { index }) => index as i32 + 1,
    }
}
