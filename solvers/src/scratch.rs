//! Scratch of another precision.
#![allow(
    unsafe_code,
    reason = "scratch memory of one scalar as that of another"
)]

use fracas_operators::Real;

/// Entries of f64 scratch that hold `len` scalars of type R.
pub(crate) fn doubles<R: Real>(len: usize) -> usize {
    (len * size_of::<R>()).div_ceil(size_of::<f64>())
}

/// The f64 that fit into scratch of type R, at most one fewer than its bytes hold.
pub(crate) fn doubles_of<R: Real>(work: &mut [R]) -> &mut [f64] {
    // SAFETY: R is f64 or f32: every bit pattern is an f64, nothing to drop; `align_to_mut` keeps the alignment.
    unsafe { work.align_to_mut::<f64>().1 }
}

/// The same memory as scalars of type R.
pub(crate) fn cast<R: Real>(work: &mut [f64]) -> &mut [R] {
    // SAFETY: R is f64 or f32 (a sealed trait): no stricter alignment, every bit pattern is a number, nothing to drop.
    let (before, cast, _) = unsafe { work.align_to_mut::<R>() };
    assert!(before.is_empty());
    cast
}
