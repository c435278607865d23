//! An operator in full numbering, seen by the free unknowns.

use crate::elasticity::Constraints;
use fracas_operators::free_entries::{gather, spread};
use fracas_operators::operator::assert_product;
use fracas_operators::vector::dot;
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};
use std::sync::Arc;

/// `√(wᵀA w)`, A and w in full numbering: √2 times the root of the strain energy.
///
/// # Cost
/// One product, one vector.
pub fn strain_norm(full: &impl LinearOperator<f64>, w: &[f64]) -> f64 {
    let mut image = vec![0.0; w.len()];
    let mut work = vec![0.0; full.work_len()];
    full.apply_add(1.0, w, &mut image, &mut work);
    dot(w, &image).max(0.0).sqrt()
}

/// A over the free displacements, element by element.
pub type FreeStiffness<R> = Restricted<Box<dyn AdjointOperator<R>>>;

/// `A_ff = P A Pᵀ`: spread the free values over zeros, multiply, gather.
#[derive(Clone, Debug)]
pub struct Restricted<A> {
    full: A,
    constraints: Constraints,
    /// Places of the prescribed unknowns, ascending.
    fixed: Arc<[u32]>,
}

impl<A> Restricted<A> {
    /// The free rows and columns of `full`.
    pub fn new<R: Real>(full: A, constraints: Constraints) -> Self
    where
        A: LinearOperator<R>,
    {
        let n = constraints.full_len();
        assert_eq!(
            full.shape(),
            Shape::square(n),
            "constraints of another mesh"
        );
        let fixed = constraints.prescribed().iter().map(|(dof, _)| *dof);
        Self {
            fixed: fixed.collect(),
            full,
            constraints,
        }
    }

    /// The operator in full numbering.
    pub fn full(&self) -> &A {
        &self.full
    }

    /// [`strain_norm`] of `u` with the prescribed values in their places.
    pub fn strain_norm(&self, u: &[f64]) -> f64
    where
        A: LinearOperator<f64>,
    {
        strain_norm(&self.full, &self.constraints.expand(u))
    }

    /// True where a displacement is prescribed that is not 0.
    pub fn is_displaced(&self) -> bool {
        self.constraints.is_displaced()
    }

    /// Runs `product(x_full, y_full, work)` between spreading and gathering.
    fn between<R: Real>(
        &self,
        alpha: R,
        x: &[R],
        y: &mut [R],
        work: &mut [R],
        product: impl FnOnce(&[R], &mut [R], &mut [R]),
    ) {
        let n = self.constraints.full_len();
        let (x_full, rest) = work.split_at_mut(n);
        let (y_full, rest) = rest.split_at_mut(n);
        spread(x, 1.0, &self.fixed, x_full);
        y_full.fill(R::zero());
        product(x_full, y_full, rest);
        gather(y_full, &self.fixed, y, &|full, y| *y += alpha * full);
    }
}

impl<R: Real, A: LinearOperator<R>> LinearOperator<R> for Restricted<A> {
    fn shape(&self) -> Shape {
        Shape::square(self.constraints.free_len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(Restricted::<A>::shape(self), x, y);
        self.between(alpha, x, y, work, |x, y, work| {
            self.full.apply_add(R::one(), x, y, work)
        });
    }

    fn work_len(&self) -> usize {
        2 * self.constraints.full_len() + self.full.work_len()
    }

    fn flops(&self) -> u64 {
        self.full.flops() + 2 * self.constraints.free_len() as u64
    }

    fn sum_over_parts(&self, sums: &mut [R]) {
        self.full.sum_over_parts(sums);
    }
}

impl<R: Real, A: AdjointOperator<R>> AdjointOperator<R> for Restricted<A> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(Restricted::<A>::shape(self), x, y);
        self.between(alpha, x, y, work, |x, y, work| {
            self.full.apply_adjoint_add(R::one(), x, y, work);
        });
    }

    fn adjoint_flops(&self) -> u64 {
        self.full.adjoint_flops() + 2 * self.constraints.free_len() as u64
    }
}
