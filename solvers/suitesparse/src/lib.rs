//! CHOLMOD and UMFPACK 7.7.0 behind a flat C interface, with orderings given by the caller.
//!
//! The build script takes the sources from the registry package `suitesparse_sys` (nothing of SuiteSparse is part of
//! this repository) and compiles 168 C files against the BLAS of `fracas-blas`. A C compiler is all it needs.
//!
//! # Licence
//! These lines are MIT OR Apache-2.0. CHOLMOD's supernodal module and UMFPACK are GPL-2.0-or-later, CHOLMOD's
//! Cholesky and Utility modules LGPL-2.1-or-later, AMD and COLAMD BSD-3-Clause: a binary that links this crate is
//! under the GPL.
//!
//! # Source
//! Y. Chen, T. A. Davis, W. W. Hager, S. Rajamanickam, ACM Trans. Math. Softw. 35 (2008) 22 (CHOLMOD);
//! T. A. Davis, ACM Trans. Math. Softw. 30 (2004) 196–199 (UMFPACK).
#![allow(unsafe_code, reason = "declarations of C functions")]

// the C code calls its symbols
use fracas_blas as _;
use std::ffi::{c_int, c_void};

/// CHOLMOD's status: out of memory.
pub const CHOLMOD_OUT_OF_MEMORY: c_int = -2;
/// CHOLMOD's status: an integer overflowed.
pub const CHOLMOD_TOO_LARGE: c_int = -3;
/// CHOLMOD's status: a pivot is not positive.
pub const CHOLMOD_NOT_POSDEF: c_int = 1;
/// UMFPACK's status: out of memory.
pub const UMFPACK_OUT_OF_MEMORY: c_int = -1;
/// UMFPACK's status: a pivot is zero.
pub const UMFPACK_SINGULAR: c_int = 1;

/// A symbolic or numeric factorization of CHOLMOD with its own settings and memory.
#[repr(C)]
#[derive(Debug)]
pub struct Cholmod {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    /// Symbolic factorization of the lower triangle in the given order.
    pub fn fracas_cholmod_analyze(
        n: i64,
        p: *const i64,
        i: *const i64,
        order: *const i64,
        out: *mut *mut Cholmod,
    ) -> c_int;

    /// Numeric factorization; `minor` is the number of pivots that succeeded.
    pub fn fracas_cholmod_factorize(
        symbolic: *const Cholmod,
        n: i64,
        p: *const i64,
        i: *const i64,
        x: *const f64,
        out: *mut *mut Cholmod,
        minor: *mut i64,
    ) -> c_int;

    /// Entries of L, and workspace entries per right-hand side.
    pub fn fracas_cholmod_sizes(h: *const Cholmod, entries: *mut i64, work: *mut i64);

    /// Order of elimination, n entries.
    pub fn fracas_cholmod_order(h: *const Cholmod, order: *mut i64);

    /// Diagonal of L in the order of elimination, n entries.
    pub fn fracas_cholmod_diagonal(h: *const Cholmod, diagonal: *mut f64);

    /// `x ← L⁻ᵀ L⁻¹ x` for permuted columns.
    pub fn fracas_cholmod_solve(
        h: *const Cholmod,
        columns: i64,
        x: *mut f64,
        work: *mut f64,
    ) -> c_int;

    /// Releases a handle; null is allowed.
    pub fn fracas_cholmod_free(h: *mut Cholmod);

    /// Symbolic factorization in the given order, which is kept if `symmetric` and may be refined otherwise.
    pub fn fracas_umfpack_analyze(
        symmetric: c_int,
        n: i64,
        p: *const i64,
        i: *const i64,
        order: *const i64,
        symbolic: *mut *mut c_void,
    ) -> c_int;

    /// Numeric factorization and the entries of L and U, or where memory runs out those that they are estimated to take.
    pub fn fracas_umfpack_factorize(
        p: *const i64,
        i: *const i64,
        x: *const f64,
        symbolic: *mut c_void,
        numeric: *mut *mut c_void,
        entries: *mut i64,
    ) -> c_int;

    /// `z ← A⁻¹ r` or `A⁻ᵀ r`; `wi` and `w` have n entries.
    pub fn fracas_umfpack_solve(
        transposed: c_int,
        p: *const i64,
        i: *const i64,
        x: *const f64,
        z: *mut f64,
        r: *const f64,
        numeric: *mut c_void,
        wi: *mut i64,
        w: *mut f64,
    ) -> c_int;

    /// `det A = mantissa · 10^exponent`.
    pub fn fracas_umfpack_determinant(
        mantissa: *mut f64,
        exponent: *mut f64,
        numeric: *mut c_void,
    ) -> c_int;

    /// Releases a symbolic factorization.
    pub fn fracas_umfpack_free_symbolic(symbolic: *mut *mut c_void);

    /// Releases a numeric factorization.
    pub fn fracas_umfpack_free_numeric(numeric: *mut *mut c_void);
}
