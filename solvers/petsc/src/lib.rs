//! PETSc's preconditioners behind a flat C interface: GAMG, hypre's BoomerAMG, MUMPS, on one rank or over the ranks of `mpirun`.
//!
//! With the feature `system` the build script asks pkg-config for the PETSc and MPI of the system and compiles two C files
//! against them; without it this crate is empty. PETSc serves one thread at a time: whoever calls holds a lock.
//!
//! # Licence
//! These lines are MIT OR Apache-2.0. PETSc is BSD-2-Clause, hypre Apache-2.0 OR MIT, MUMPS CeCILL-C; a distribution's PETSc
//! may link SuiteSparse or FFTW, and a binary with them is under the GPL.
//!
//! # Source
//! S. Balay et al., PETSc/TAO Users Manual, ANL-21/39 Rev. 3.18 (2022); V. E. Henson & U. M. Yang, Appl. Numer. Math. 41 (2002)
//! 155–177 (BoomerAMG); P. R. Amestoy, I. S. Duff, J. Koster, J.-Y. L'Excellent, SIAM J. Matrix Anal. Appl. 23 (2001) 15–41 (MUMPS).
#![cfg(feature = "system")]
#![allow(unsafe_code, reason = "declarations of C functions")]

use std::ffi::{c_char, c_int};

/// GAMG: smoothed aggregation.
pub const GAMG: c_int = 0;
/// hypre's BoomerAMG: classical.
pub const BOOMERAMG: c_int = 1;
/// MUMPS for a positive definite matrix.
pub const MUMPS_SPD: c_int = 2;
/// MUMPS for a symmetric matrix.
pub const MUMPS_SYMMETRIC: c_int = 3;
/// MUMPS for any regular matrix.
pub const MUMPS_LU: c_int = 4;

/// Code: an option that nothing read, or that would replace the method; the text is its name.
pub const REFUSED_OPTION: c_int = -1;
/// Codes up to here are `INFOG(1) − 1000` of MUMPS.
pub const MUMPS_CODES: c_int = -1001;

/// Code: ranks cannot begin, as PETSc serves this process alone, or has been left.
pub const ALONE: c_int = -1;

/// PETSc's code: out of memory.
pub const ERR_MEM: c_int = 55;

/// A matrix and its preconditioner.
#[repr(C)]
#[derive(Debug)]
pub struct Petsc {
    _opaque: [u8; 0],
}

unsafe extern "C" {
    /// Starts MPI and PETSc, without signal handlers, once; a code that is not 0 comes with a text of `length` bytes at most. With
    /// `together` ranks are one program, and one that exits before [`fracas_ranks_leave`] ends the others.
    pub fn fracas_petsc_start(together: c_int, text: *mut c_char, length: c_int) -> c_int;

    /// A preconditioner of `kind` for compressed rows of n unknowns in blocks, with `positions` of n entries (x, y, z of every
    /// block of three) or null, and PETSc's options as on its command line.
    pub fn fracas_petsc_new(
        kind: c_int,
        n: c_int,
        block: c_int,
        offsets: *const c_int,
        columns: *const c_int,
        values: *const f64,
        positions: *const f64,
        options: *const c_char,
        out: *mut *mut Petsc,
        text: *mut c_char,
        length: c_int,
    ) -> c_int;

    /// `z ← M⁻¹ r` or `M⁻ᵀ r`, n entries each.
    pub fn fracas_petsc_apply(
        h: *mut Petsc,
        transposed: c_int,
        r: *const f64,
        z: *mut f64,
        text: *mut c_char,
        length: c_int,
    ) -> c_int;

    /// Flops that PETSc counts in one application; r and z, n entries each, are written.
    pub fn fracas_petsc_count(h: *mut Petsc, r: *mut f64, z: *mut f64, flops: *mut f64) -> c_int;

    /// An entry of MUMPS's INFOG, counted from 1.
    pub fn fracas_petsc_mumps(h: *mut Petsc, index: c_int, value: *mut f64) -> c_int;

    /// Releases a handle; null is allowed.
    pub fn fracas_petsc_free(h: *mut Petsc);
}

/// Who fills the ghosts of a part of a vector.
#[repr(C)]
#[derive(Debug)]
pub struct Ghosts {
    _opaque: [u8; 0],
}

// all ranks call each of these together; they began with `together`
unsafe extern "C" {
    /// Number of this rank, how many there are, and how many on this machine.
    pub fn fracas_ranks_begin(rank: *mut c_int, size: *mut c_int, beside: *mut c_int) -> c_int;

    /// From here on every rank may exit.
    pub fn fracas_ranks_leave();

    /// Ends all ranks with this status; called by one.
    pub fn fracas_ranks_abort(status: c_int);

    /// n sums of every rank become those of all, with the same bits everywhere; `other` has n entries, too.
    pub fn fracas_ranks_sum(sums: *mut f64, other: *mut f64, n: c_int);

    /// n numbers of every rank, rank after rank, on all of them.
    pub fn fracas_ranks_gather(own: *const f64, n: c_int, all: *mut f64);

    /// Numbers of every rank on rank 0, which says how many and where; the others' last three are not read.
    pub fn fracas_ranks_collect(
        own: *const f64,
        n: c_int,
        all: *mut f64,
        lengths: *const c_int,
        firsts: *const c_int,
    );

    /// n bytes of one rank on all of them.
    pub fn fracas_ranks_tell(from: c_int, bytes: *mut u8, n: c_int);

    /// Which ranks failed, one entry each; not 0 where this one did and some others do not ask within `patience` seconds.
    pub fn fracas_ranks_failed(failed: c_int, patience: f64, all: *mut c_int) -> c_int;

    /// Half of a message and its answer between ranks 0 and 1 [s].
    pub fn fracas_ranks_ping(numbers: *mut f64, n: c_int, times: c_int) -> f64;

    /// Ghosts that live on `owners` at `places` among the `own` entries of those.
    pub fn fracas_ghosts_new(
        own: c_int,
        ghosts: c_int,
        owners: *const c_int,
        places: *const c_int,
        out: *mut *mut Ghosts,
        text: *mut c_char,
        length: c_int,
    ) -> c_int;

    /// Fills them.
    pub fn fracas_ghosts_fill(ghosts: *mut Ghosts, own: *const f64, filled: *mut f64) -> c_int;

    /// Releases them; called by one.
    pub fn fracas_ghosts_free(ghosts: *mut Ghosts);

    /// n rows, three a node, of a matrix whose rows go from rank to rank; columns count through all of them.
    pub fn fracas_ranks_matrix(
        n: c_int,
        offsets: *const c_int,
        columns: *const c_int,
        values: *const f64,
        positions: *const f64,
        out: *mut *mut Petsc,
        text: *mut c_char,
        length: c_int,
    ) -> c_int;

    /// Its preconditioner of `kind`, for [`fracas_petsc_apply`] and the others.
    pub fn fracas_ranks_set_up(
        h: *mut Petsc,
        kind: c_int,
        options: *const c_char,
        text: *mut c_char,
        length: c_int,
    ) -> c_int;
}
