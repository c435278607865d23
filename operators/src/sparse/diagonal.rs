//! A diagonal matrix.

use crate::operator::assert_product;
use crate::{AdjointOperator, LinearOperator, Real, Shape};

/// `D = diag(d)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagonal<R> {
    values: Vec<R>,
}

impl<R: Real> Diagonal<R> {
    /// The diagonal matrix of `values`.
    pub fn new(values: Vec<R>) -> Self {
        Self { values }
    }

    /// The diagonal entries.
    pub fn values(&self) -> &[R] {
        &self.values
    }
}

impl<R: Real> LinearOperator<R> for Diagonal<R> {
    fn shape(&self) -> Shape {
        Shape::square(self.values.len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape(), x, y);
        for ((y, x), d) in y.iter_mut().zip(x).zip(&self.values) {
            *y += alpha * *d * *x;
        }
    }

    fn flops(&self) -> u64 {
        3 * self.values.len() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Diagonal<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.apply_add(alpha, x, y, work);
    }

    fn adjoint_flops(&self) -> u64 {
        LinearOperator::<R>::flops(self)
    }
}
