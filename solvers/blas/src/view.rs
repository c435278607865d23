//! Fortran arrays as faer views, and the choice of threads.

use crate::flags::Trans;
use faer::traits::ComplexField;
use faer::{Accum, Conj, MatMut, MatRef, Par};

/// f32, f64 and the complex numbers of both.
pub(crate) trait Scalar: ComplexField + Copy + Default + std::ops::MulAssign {}
impl<T: ComplexField + Copy + Default + std::ops::MulAssign> Scalar for T {}

/// Multiply-adds below which one thread is faster than handing work over. Unit: multiply-adds; about 20 µs.
const PARALLEL: usize = 1 << 20;

/// Narrowest result that threads share. Unit: rows or columns; faer splits the sum itself over threads when the result
/// is a vector, and then the bits depend on their number.
const NARROW: usize = 16;

/// All threads of the current pool for large products with an m × n result.
pub(crate) fn par(m: usize, n: usize, multiply_adds: usize) -> Par {
    if multiply_adds < PARALLEL || m.min(n) < NARROW {
        Par::Seq
    } else {
        Par::rayon(0)
    }
}

/// A dimension; negative ones are a programming error of the caller.
pub(crate) fn size(n: i32) -> usize {
    match usize::try_from(n) {
        Ok(n) => n,
        Err(_) => panic!("BLAS dimension {n} is negative"),
    }
}

/// Columns `lda` apart.
///
/// # Safety
/// `a` points to an m × n Fortran array with leading dimension `lda` that nobody writes meanwhile.
pub(crate) unsafe fn matrix<'a, T>(a: *const T, m: usize, n: usize, lda: i32) -> MatRef<'a, T> {
    // Safety: as for the caller.
    unsafe { MatRef::from_raw_parts(a, m, n, 1, lda as isize) }
}

/// Columns `lda` apart, writable.
///
/// # Safety
/// `a` points to an m × n Fortran array with leading dimension `lda` that nobody else uses meanwhile.
pub(crate) unsafe fn matrix_mut<'a, T>(a: *mut T, m: usize, n: usize, lda: i32) -> MatMut<'a, T> {
    // Safety: as for the caller.
    unsafe { MatMut::from_raw_parts_mut(a, m, n, 1, lda as isize) }
}

/// First entry of a strided vector: with a negative increment the last one in memory.
pub(crate) fn first(n: usize, inc: i32) -> isize {
    if inc < 0 {
        (n as isize - 1) * -(inc as isize)
    } else {
        0
    }
}

/// op(A) as a view and the conjugation that a view cannot express.
pub(crate) fn op<T>(a: MatRef<'_, T>, trans: Trans) -> (MatRef<'_, T>, Conj) {
    match trans {
        Trans::No => (a, Conj::No),
        Trans::Transpose => (a.transpose(), Conj::No),
        Trans::Adjoint => (a.transpose(), Conj::Yes),
    }
}

/// Rows and columns of the stored A when op(A) is m × n.
pub(crate) fn stored(trans: Trans, m: usize, n: usize) -> (usize, usize) {
    match trans {
        Trans::No => (m, n),
        Trans::Transpose | Trans::Adjoint => (n, m),
    }
}

/// Applies β to the entries of `c` that `keep(i, j)` selects: β = 0 means they are not read.
pub(crate) fn scaled<T: Scalar>(
    mut c: MatMut<'_, T>,
    beta: &T,
    keep: impl Fn(usize, usize) -> bool,
) -> Accum {
    if *beta == T::default() {
        return Accum::Replace;
    }
    if *beta != T::one_impl() {
        for j in 0..c.ncols() {
            for i in 0..c.nrows() {
                if keep(i, j) {
                    c[(i, j)] *= *beta;
                }
            }
        }
    }
    Accum::Add
}
