//! The exported symbols. Arguments as in the reference BLAS and LAPACK; see there for what they mean.

use crate::level3::Triangle;
use crate::view::size;
use crate::{flags, level2, level3, potrf};
use faer::{c32, c64};
use std::ffi::c_char;

macro_rules! routines {
    ($real:ty, $scalar:ty, $hermitian:literal:
     $gemm:ident $rank_k:ident $trsm:ident $gemv:ident $trsv:ident $ger:ident $potrf:ident) => {
        /// `C ← α op(A) op(B) + β C`.
        ///
        /// # Safety
        /// As the BLAS requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gemm(
            transa: *const c_char,
            transb: *const c_char,
            m: *const i32,
            n: *const i32,
            k: *const i32,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const i32,
            b: *const $scalar,
            ldb: *const i32,
            beta: *const $scalar,
            c: *mut $scalar,
            ldc: *const i32,
        ) {
            // Safety: as for the caller.
            unsafe {
                level3::gemm(
                    (flags::trans(transa), flags::trans(transb)),
                    (size(*m), size(*n), size(*k)),
                    &*alpha,
                    (a, *lda),
                    (b, *ldb),
                    &*beta,
                    (c, *ldc),
                )
            }
        }

        /// `C ← α A Aᴴ + β C` or `α Aᴴ A + β C`, one triangle.
        ///
        /// # Safety
        /// As the BLAS requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $rank_k(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const i32,
            k: *const i32,
            alpha: *const $real,
            a: *const $scalar,
            lda: *const i32,
            beta: *const $real,
            c: *mut $scalar,
            ldc: *const i32,
        ) {
            // Safety: as for the caller.
            unsafe {
                level3::rank_k(
                    (flags::uplo(uplo), flags::trans(trans), $hermitian),
                    (size(*n), size(*k)),
                    &<$scalar>::from(*alpha),
                    (a, *lda),
                    &<$scalar>::from(*beta),
                    (c, *ldc),
                )
            }
        }

        /// `B ← α op(A)⁻¹ B` or `α B op(A)⁻¹`.
        ///
        /// # Safety
        /// As the BLAS requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $trsm(
            side: *const c_char,
            uplo: *const c_char,
            transa: *const c_char,
            diag: *const c_char,
            m: *const i32,
            n: *const i32,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const i32,
            b: *mut $scalar,
            ldb: *const i32,
        ) {
            // Safety: as for the caller.
            unsafe {
                level3::trsm(
                    flags::left(side),
                    Triangle {
                        uplo: flags::uplo(uplo),
                        trans: flags::trans(transa),
                        unit: flags::unit(diag),
                    },
                    (size(*m), size(*n)),
                    &*alpha,
                    (a, *lda),
                    (b, *ldb),
                )
            }
        }

        /// `y ← α op(A) x + β y`.
        ///
        /// # Safety
        /// As the BLAS requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gemv(
            trans: *const c_char,
            m: *const i32,
            n: *const i32,
            alpha: *const $scalar,
            a: *const $scalar,
            lda: *const i32,
            x: *const $scalar,
            incx: *const i32,
            beta: *const $scalar,
            y: *mut $scalar,
            incy: *const i32,
        ) {
            // Safety: as for the caller.
            unsafe {
                level2::gemv(
                    flags::trans(trans),
                    (size(*m), size(*n)),
                    &*alpha,
                    (a, *lda),
                    (x, *incx),
                    &*beta,
                    (y, *incy),
                )
            }
        }

        /// `x ← op(A)⁻¹ x`.
        ///
        /// # Safety
        /// As the BLAS requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $trsv(
            uplo: *const c_char,
            trans: *const c_char,
            diag: *const c_char,
            n: *const i32,
            a: *const $scalar,
            lda: *const i32,
            x: *mut $scalar,
            incx: *const i32,
        ) {
            // Safety: as for the caller.
            unsafe {
                level2::trsv(
                    Triangle {
                        uplo: flags::uplo(uplo),
                        trans: flags::trans(trans),
                        unit: flags::unit(diag),
                    },
                    size(*n),
                    (a, *lda),
                    (x, *incx),
                )
            }
        }

        /// `A ← A + α x yᵀ`.
        ///
        /// # Safety
        /// As the BLAS requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $ger(
            m: *const i32,
            n: *const i32,
            alpha: *const $scalar,
            x: *const $scalar,
            incx: *const i32,
            y: *const $scalar,
            incy: *const i32,
            a: *mut $scalar,
            lda: *const i32,
        ) {
            // Safety: as for the caller.
            unsafe {
                level2::ger(
                    (size(*m), size(*n)),
                    &*alpha,
                    (x, *incx),
                    (y, *incy),
                    (a, *lda),
                )
            }
        }

        /// `A = L Lᴴ` or `Uᴴ U`, one triangle.
        ///
        /// # Safety
        /// As LAPACK requires.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $potrf(
            uplo: *const c_char,
            n: *const i32,
            a: *mut $scalar,
            lda: *const i32,
            info: *mut i32,
        ) {
            // Safety: as for the caller.
            unsafe { *info = potrf::potrf(flags::uplo(uplo), size(*n), (a, *lda)) }
        }
    };
}

routines!(f32, f32, false: sgemm_ffm_ ssyrk_ffm_ strsm_ffm_ sgemv_ffm_ strsv_ffm_ sger_ffm_ spotrf_ffm_);
routines!(f64, f64, false: dgemm_ffm_ dsyrk_ffm_ dtrsm_ffm_ dgemv_ffm_ dtrsv_ffm_ dger_ffm_ dpotrf_ffm_);
routines!(f32, c32, true: cgemm_ffm_ cherk_ffm_ ctrsm_ffm_ cgemv_ffm_ ctrsv_ffm_ cgeru_ffm_ cpotrf_ffm_);
routines!(f64, c64, true: zgemm_ffm_ zherk_ffm_ ztrsm_ffm_ zgemv_ffm_ ztrsv_ffm_ zgeru_ffm_ zpotrf_ffm_);
