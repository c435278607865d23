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
    /// (ranks of MPI); inner products of those are sums of this kind. In one memory there is nothing to add; an operator around another
    /// one passes this on.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Adjoint, BlockOperator, Counted, Field, Layout};
    use std::sync::Arc;

    /// One of two equal parts of a vector.
    struct Half;

    impl LinearOperator<f64> for Half {
        fn shape(&self) -> Shape {
            Shape::square(1)
        }
        fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], _: &mut [f64]) {
            y[0] += alpha * x[0];
        }
        fn flops(&self) -> u64 {
            2
        }
        fn sum_over_parts(&self, sums: &mut [f64]) {
            sums.iter_mut().for_each(|sum| *sum *= 2.0);
        }
    }

    impl AdjointOperator<f64> for Half {
        fn apply_adjoint_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
            self.apply_add(alpha, x, y, work);
        }
        fn adjoint_flops(&self) -> u64 {
            2
        }
    }

    #[test]
    fn an_operator_around_another_one_adds_up_the_same_parts() {
        const U: Field = Field {
            letter: "u",
            name: "displacements",
        };
        let block = BlockOperator::new(Layout::new([(U, 1)])).with([U; 2], 1.0, Half);
        let around: [(&str, Box<dyn LinearOperator<f64>>); 6] = [
            ("&", Box::new(&Half)),
            (
                "Box",
                Box::new(Box::new(Half) as Box<dyn LinearOperator<f64>>),
            ),
            ("Arc", Box::new(Arc::new(Half))),
            ("Counted", Box::new(Counted::new(Half))),
            ("Adjoint", Box::new(Adjoint(Half))),
            ("BlockOperator", Box::new(block)),
        ];
        for (name, operator) in around {
            let mut sums = [1.0, 3.0];
            operator.sum_over_parts(&mut sums);
            assert_eq!(sums, [2.0, 6.0], "{name}");
        }
    }
}
