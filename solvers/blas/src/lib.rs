//! The BLAS and LAPACK routines that CHOLMOD and UMFPACK link, with the Fortran ABI, on faer's kernels.
//!
//! Symbols end in `_ffm_` (`dgemm_ffm_`), so that nothing collides with a BLAS that another library brings; integers
//! have 32 bits; character flags come without hidden lengths. `s`, `d`, `c` and `z` share one generic routine each.
//! Large products run on all threads of the current rayon pool, with the same bits for any number of them.
//!
//! A panic aborts the process: no unwinding crosses the C frames (`extern "C"` functions abort by definition).
//!
//! # Source
//! J. Dongarra et al., ACM Trans. Math. Softw. 16 (1990) 1–17; E. Anderson et al., LAPACK Users' Guide (1999).
#![allow(unsafe_code, reason = "C calls these routines")]

mod flags;
mod level2;
mod level3;
mod potrf;
pub mod symbols;
mod view;
