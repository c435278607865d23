//! S_u on the levels.

use super::faces::FractureTerm;
use crate::elasticity::Bricks;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::Block3;
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// `S_u = A + B C⁻¹Bᵀ` over all displacements, nothing assembled.
pub(super) struct Finest<R> {
    pub(super) stiffness: Box<dyn AdjointOperator<R>>,
    pub(super) fractures: FractureTerm<R>,
}

impl<R: Real> LinearOperator<R> for Finest<R> {
    fn shape(&self) -> Shape {
        self.stiffness.shape()
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(self.shape(), x, y);
        self.stiffness.apply_add(alpha, x, y, work);
        self.fractures.add(alpha, x, y, work);
    }

    fn work_len(&self) -> usize {
        self.stiffness.work_len().max(self.fractures.work_len())
    }

    fn flops(&self) -> u64 {
        self.stiffness.flops() + self.fractures.flops()
    }
}

/// Bricks where a coarse cell is whole and of one material, an assembled matrix elsewhere.
pub(super) struct Coarse<R> {
    pub(super) bricks: Option<Bricks<R>>,
    pub(super) remainder: Block3<R>,
}

impl<R: Real> LinearOperator<R> for Coarse<R> {
    fn shape(&self) -> Shape {
        LinearOperator::<R>::shape(&self.remainder)
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(self.shape(), x, y);
        if let Some(bricks) = &self.bricks {
            bricks.apply_add(alpha, x, y, work);
        }
        self.remainder.apply_add(alpha, x, y, work);
    }

    fn flops(&self) -> u64 {
        let bricks = self.bricks.as_ref().map_or(0, |bricks| bricks.flops());
        bricks + self.remainder.flops()
    }
}
