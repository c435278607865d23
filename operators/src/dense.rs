//! The dense oracle: what every fast operator must agree with.

use crate::operator::assert_product;
use crate::{AdjointOperator, LinearOperator, Preconditioner, Real, Shape};

/// A dense matrix stored by columns. Sequential and plain: it is the reference, not the fast path.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense<R> {
    shape: Shape,
    values: Vec<R>,
}

impl<R: Real> Dense<R> {
    /// The zero matrix.
    pub fn zeros(shape: Shape) -> Self {
        Self {
            shape,
            values: vec![R::zero(); shape.rows * shape.cols],
        }
    }

    /// Takes the values, column after column.
    pub fn from_columns(shape: Shape, values: Vec<R>) -> Self {
        assert_eq!(values.len(), shape.rows * shape.cols, "values and entries");
        Self { shape, values }
    }

    /// Gives the values back, column after column.
    pub fn into_columns(self) -> Vec<R> {
        self.values
    }

    /// The matrix with entry `f(i, j)`.
    pub fn from_fn(shape: Shape, f: impl Fn(usize, usize) -> R) -> Self {
        let mut dense = Self::zeros(shape);
        for j in 0..shape.cols {
            for i in 0..shape.rows {
                *dense.entry_mut(i, j) = f(i, j);
            }
        }
        dense
    }

    /// Columns `A e_j` of an operator.
    pub fn of_operator(operator: &dyn LinearOperator<R>) -> Self {
        let mut dense = Self::zeros(operator.shape());
        let mut e = vec![R::zero(); dense.shape.cols];
        let mut work = vec![R::zero(); operator.work_len()];
        for j in 0..dense.shape.cols {
            e[j] = R::one();
            operator.apply(&e, dense.column_mut(j), &mut work);
            e[j] = R::zero();
        }
        dense
    }

    /// Columns `M⁻¹ e_j` of a preconditioner.
    pub fn of_preconditioner(preconditioner: &dyn Preconditioner<R>) -> Self {
        let n = preconditioner.size();
        let mut dense = Self::zeros(Shape::square(n));
        let mut e = vec![R::zero(); n];
        let mut work = vec![R::zero(); preconditioner.work_len()];
        for j in 0..n {
            e[j] = R::one();
            preconditioner.solve(&e, dense.column_mut(j), &mut work);
            e[j] = R::zero();
        }
        dense
    }

    /// Entry (i, j).
    pub fn entry(&self, i: usize, j: usize) -> R {
        self.values[j * self.shape.rows + i]
    }

    /// Entry (i, j), writable.
    pub fn entry_mut(&mut self, i: usize, j: usize) -> &mut R {
        &mut self.values[j * self.shape.rows + i]
    }

    /// Column j.
    pub fn column(&self, j: usize) -> &[R] {
        &self.values[j * self.shape.rows..(j + 1) * self.shape.rows]
    }

    /// Column j, writable.
    pub fn column_mut(&mut self, j: usize) -> &mut [R] {
        &mut self.values[j * self.shape.rows..(j + 1) * self.shape.rows]
    }

    /// All entries, column after column.
    pub fn values(&self) -> &[R] {
        &self.values
    }

    /// Largest |entry|.
    pub fn max_abs(&self) -> R {
        crate::vector::norm_inf(&self.values)
    }
}

impl<R: Real> LinearOperator<R> for Dense<R> {
    fn shape(&self) -> Shape {
        self.shape
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape, x, y);
        for (j, x_j) in x.iter().enumerate() {
            let scaled = alpha * *x_j;
            for (y_i, a_ij) in y.iter_mut().zip(self.column(j)) {
                *y_i += *a_ij * scaled;
            }
        }
    }

    fn flops(&self) -> u64 {
        2 * (self.shape.rows * self.shape.cols) as u64
    }
}

impl<R: Real> AdjointOperator<R> for Dense<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape.transposed(), x, y);
        for (j, y_j) in y.iter_mut().enumerate() {
            let mut sum = R::zero();
            for (a_ij, x_i) in self.column(j).iter().zip(x) {
                sum += *a_ij * *x_i;
            }
            *y_j += alpha * sum;
        }
    }

    fn adjoint_flops(&self) -> u64 {
        2 * (self.shape.rows * self.shape.cols) as u64
    }
}
