//! Aᵀ as an operator of its own.

use crate::{AdjointOperator, LinearOperator, Real, Shape};

/// `Aᵀ`, applied through [`AdjointOperator::apply_adjoint_add`].
#[derive(Clone, Copy, Debug)]
pub struct Adjoint<A>(pub A);

impl<R: Real, A: AdjointOperator<R>> LinearOperator<R> for Adjoint<A> {
    fn shape(&self) -> Shape {
        self.0.shape().transposed()
    }
    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.0.apply_adjoint_add(alpha, x, y, work);
    }
    fn work_len(&self) -> usize {
        self.0.work_len()
    }
    fn flops(&self) -> u64 {
        self.0.adjoint_flops()
    }
    fn sum_over_parts(&self, sums: &mut [R]) {
        self.0.sum_over_parts(sums);
    }
}

impl<R: Real, A: AdjointOperator<R>> AdjointOperator<R> for Adjoint<A> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.0.apply_add(alpha, x, y, work);
    }

    fn adjoint_flops(&self) -> u64 {
        self.0.flops()
    }
}
