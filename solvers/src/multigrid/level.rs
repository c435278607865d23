//! A level: what smooths it, and its way down.

use super::smooth::Smooth;
use fracas_operators::{LinearOperator, Real};

/// P and Pᵀ between a level and the next one.
pub trait Transfer<R: Real>: Send + Sync {
    /// Unknowns of the next level.
    fn coarse_len(&self) -> usize;

    /// `b_c ← Pᵀ r`.
    fn restrict(&self, r: &[R], coarse: &mut [R]);

    /// `x ← P x_c`.
    fn prolong(&self, coarse: &[R], x: &mut [R]);

    /// `x ← x + P x_c`.
    fn prolong_add(&self, coarse: &[R], x: &mut [R]);

    /// Flops of one restriction and one prolongation.
    fn flops(&self) -> u64;

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// One level that smooths.
pub struct Level<R> {
    smoother: Box<dyn Smooth<R>>,
    transfer: Box<dyn Transfer<R>>,
    fixed: Vec<u32>,
}

impl<R: Real> Level<R> {
    /// A level with the components `fixed`, ascending, that are no unknowns: its operator may read and write these, and what it
    /// writes there is not used.
    pub fn new(
        smoother: Box<dyn Smooth<R>>,
        transfer: Box<dyn Transfer<R>>,
        fixed: Vec<u32>,
    ) -> Self {
        Self {
            smoother,
            transfer,
            fixed,
        }
    }

    /// Unknowns, fixed ones included.
    pub fn size(&self) -> usize {
        self.operator().shape().rows
    }

    /// The operator; rows and columns of fixed components are not used.
    pub fn operator(&self) -> &dyn LinearOperator<R> {
        self.smoother.operator()
    }

    /// What smooths.
    pub fn smoother(&self) -> &dyn Smooth<R> {
        &*self.smoother
    }

    /// The way to the next level.
    pub fn transfer(&self) -> &dyn Transfer<R> {
        &*self.transfer
    }

    /// Components that are no unknowns, ascending.
    pub fn fixed(&self) -> &[u32] {
        &self.fixed
    }

    /// Bytes of operator, smoother and transfer.
    pub(super) fn bytes(&self) -> usize {
        self.smoother.bytes() + self.transfer.bytes() + size_of_val(&*self.fixed)
    }

    /// Flops of both smoothings, the residual between them and both transfers.
    pub(super) fn flops(&self) -> u64 {
        self.smoother.flops() + self.transfer.flops()
    }

    /// `b_c ← Pᵀ r` without the fixed components of r, which become zero.
    pub(super) fn restrict(&self, r: &mut [R], coarse: &mut [R]) {
        clear(&self.fixed, r);
        self.transfer.restrict(r, coarse);
    }

    /// P x_c.
    pub(super) fn correction<'a>(&'a self, coarse: &'a [R]) -> Correction<'a, R> {
        Correction {
            level: self,
            coarse,
        }
    }
}

/// `P x_c` on a level, zero in its fixed components.
pub struct Correction<'a, R> {
    level: &'a Level<R>,
    coarse: &'a [R],
}

impl<R: Real> Correction<'_, R> {
    /// `d ← P x_c`.
    pub fn write(&self, d: &mut [R]) {
        self.level.transfer.prolong(self.coarse, d);
        clear(&self.level.fixed, d);
    }

    /// `x ← x + P x_c`.
    pub fn add_to(&self, x: &mut [R]) {
        self.level.transfer.prolong_add(self.coarse, x);
        clear(&self.level.fixed, x);
    }
}

/// Zero in these components.
pub(super) fn clear<R: Real>(fixed: &[u32], x: &mut [R]) {
    fixed.iter().for_each(|i| x[*i as usize] = R::zero());
}
