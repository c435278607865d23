//! How often was it applied?

use crate::{AdjointOperator, LinearOperator, Preconditioner, Properties, Real, Shape};
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts the applications of an operator or a preconditioner.
#[derive(Debug, Default)]
pub struct Counted<A> {
    inner: A,
    applications: AtomicU64,
}

impl<A> Counted<A> {
    /// Starts counting at zero.
    pub fn new(inner: A) -> Self {
        Self {
            inner,
            applications: AtomicU64::new(0),
        }
    }

    /// Applications so far (products, adjoint products and solves alike).
    pub fn applications(&self) -> u64 {
        self.applications.load(Ordering::Relaxed)
    }

    /// What is counted.
    pub fn inner(&self) -> &A {
        &self.inner
    }

    fn count(&self) -> &A {
        self.applications.fetch_add(1, Ordering::Relaxed);
        &self.inner
    }
}

impl<R: Real, A: LinearOperator<R>> LinearOperator<R> for Counted<A> {
    fn shape(&self) -> Shape {
        self.inner.shape()
    }
    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.count().apply_add(alpha, x, y, work);
    }
    fn apply(&self, x: &[R], y: &mut [R], work: &mut [R]) {
        self.count().apply(x, y, work);
    }
    fn work_len(&self) -> usize {
        self.inner.work_len()
    }
    fn flops(&self) -> u64 {
        self.inner.flops()
    }
    fn sum_over_parts(&self, sums: &mut [R]) {
        self.inner.sum_over_parts(sums);
    }
}

impl<R: Real, A: AdjointOperator<R>> AdjointOperator<R> for Counted<A> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.count().apply_adjoint_add(alpha, x, y, work);
    }

    fn adjoint_flops(&self) -> u64 {
        self.inner.adjoint_flops()
    }
}

impl<R: Real, M: Preconditioner<R>> Preconditioner<R> for Counted<M> {
    fn size(&self) -> usize {
        self.inner.size()
    }
    fn solve(&self, r: &[R], z: &mut [R], work: &mut [R]) {
        self.count().solve(r, z, work);
    }
    fn work_len(&self) -> usize {
        self.inner.work_len()
    }
    fn flops(&self) -> u64 {
        self.inner.flops()
    }
    fn properties(&self) -> Properties {
        self.inner.properties()
    }
}
