//! The character flags of the BLAS.

use std::ffi::c_char;

/// `N`, `T` or `C`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trans {
    /// op(A) = A
    No,
    /// op(A) = Aᵀ
    Transpose,
    /// op(A) = Aᴴ
    Adjoint,
}

/// Which triangle is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Uplo {
    /// `L`
    Lower,
    /// `U`
    Upper,
}

/// Upper-case letter of a flag.
unsafe fn letter(flag: *const c_char) -> u8 {
    // Safety: the caller passes a pointer to at least one character.
    unsafe { *flag.cast::<u8>() }.to_ascii_uppercase()
}

/// Decodes `trans`.
pub(crate) unsafe fn trans(flag: *const c_char) -> Trans {
    // Safety: as for the caller.
    match unsafe { letter(flag) } {
        b'N' => Trans::No,
        b'T' => Trans::Transpose,
        b'C' => Trans::Adjoint,
        other => panic!("BLAS flag trans = {:?}", other as char),
    }
}

/// Decodes `uplo`.
pub(crate) unsafe fn uplo(flag: *const c_char) -> Uplo {
    // Safety: as for the caller.
    match unsafe { letter(flag) } {
        b'L' => Uplo::Lower,
        b'U' => Uplo::Upper,
        other => panic!("BLAS flag uplo = {:?}", other as char),
    }
}

/// Decodes `diag`: true for a unit diagonal.
pub(crate) unsafe fn unit(flag: *const c_char) -> bool {
    // Safety: as for the caller.
    match unsafe { letter(flag) } {
        b'U' => true,
        b'N' => false,
        other => panic!("BLAS flag diag = {:?}", other as char),
    }
}

/// Decodes `side`: true for left.
pub(crate) unsafe fn left(flag: *const c_char) -> bool {
    // Safety: as for the caller.
    match unsafe { letter(flag) } {
        b'L' => true,
        b'R' => false,
        other => panic!("BLAS flag side = {:?}", other as char),
    }
}
