//! Operators multiply: `y ← y + α A x`.

use crate::{Real, Shape};

/// A linear map given by what it does to a vector.
///
/// The primitive is the accumulation `y ← y + α A x`; a `β` does not exist. `work` is the caller's scratch memory of at
/// least [`work_len`](Self::work_len) entries with arbitrary content (LAPACK's `lwork`), so hot loops never allocate.
///
/// Slices longer or shorter than the shape are a programmer's error and panic with both numbers.
pub trait LinearOperator<R: Real>: Send + Sync {
    /// Rows × columns.
    fn shape(&self) -> Shape;

    /// `y ← y + α A x`.
    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]);

    /// `y ← A x`.
    fn apply(&self, x: &[R], y: &mut [R], work: &mut [R]) {
        y.fill(R::zero());
        self.apply_add(R::one(), x, y, work);
    }

    /// Scratch entries that one product needs.
    fn work_len(&self) -> usize {
        0
    }

    /// Floating-point operations of one product (a multiply-add counts two).
    fn flops(&self) -> u64;

    /// Adds up sums that every part of a vector has for itself, where x and y are parts of vectors that several memories share
    /// (ranks of MPI); inner products of those are sums of this kind. In one memory there is nothing to add.
    fn sum_over_parts(&self, _sums: &mut [R]) {}
}

/// An operator that also knows its adjoint.
pub trait AdjointOperator<R: Real>: LinearOperator<R> {
    /// `y ← y + α Aᵀ x`, with the same scratch length as the product.
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]);

    /// Floating-point operations of that.
    fn adjoint_flops(&self) -> u64;
}

/// Stops with both numbers when `x` or `y` does not fit `shape`. One comparison per product.
#[inline]
#[track_caller]
pub fn assert_product<R>(shape: Shape, x: &[R], y: &[R]) {
    assert!(
        x.len() == shape.cols && y.len() == shape.rows,
        "product of a {shape} operator with x of length {} and y of length {}",
        x.len(),
        y.len()
    );
}

macro_rules! forward_operator {
    ($($pointer:ty),*) => {$(
        impl<R: Real, A: LinearOperator<R> + ?Sized> LinearOperator<R> for $pointer {
            fn shape(&self) -> Shape {
                (**self).shape()
            }
            fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
                (**self).apply_add(alpha, x, y, work);
            }
            fn apply(&self, x: &[R], y: &mut [R], work: &mut [R]) {
                (**self).apply(x, y, work);
            }
            fn work_len(&self) -> usize {
                (**self).work_len()
            }
            fn flops(&self) -> u64 {
                (**self).flops()
            }
            fn sum_over_parts(&self, sums: &mut [R]) {
                (**self).sum_over_parts(sums);
            }
        }

        impl<R: Real, A: AdjointOperator<R> + ?Sized> AdjointOperator<R> for $pointer {
            fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
                (**self).apply_adjoint_add(alpha, x, y, work);
            }
            fn adjoint_flops(&self) -> u64 {
                (**self).adjoint_flops()
            }
        }
    )*};
}
forward_operator!(&A, Box<A>, std::sync::Arc<A>);
