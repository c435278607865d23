//! How long did it take?

use crate::{AdjointOperator, LinearOperator, Preconditioner, Properties, Real, Shape};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Sums the wall time spent in an operator or a preconditioner.
#[derive(Debug, Default)]
pub struct Timed<A> {
    inner: A,
    nanoseconds: AtomicU64,
}

impl<A> Timed<A> {
    /// Starts at zero.
    pub fn new(inner: A) -> Self {
        Self {
            inner,
            nanoseconds: AtomicU64::new(0),
        }
    }

    /// Wall time so far (products, adjoint products and solves alike).
    pub fn elapsed(&self) -> Duration {
        Duration::from_nanos(self.nanoseconds.load(Ordering::Relaxed))
    }

    /// What is timed.
    pub fn inner(&self) -> &A {
        &self.inner
    }

    fn time(&self, run: impl FnOnce(&A)) {
        let start = Instant::now();
        run(&self.inner);
        let spent = start.elapsed().as_nanos() as u64;
        self.nanoseconds.fetch_add(spent, Ordering::Relaxed);
    }
}

impl<R: Real, A: LinearOperator<R>> LinearOperator<R> for Timed<A> {
    fn shape(&self) -> Shape {
        self.inner.shape()
    }
    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.time(|inner| inner.apply_add(alpha, x, y, work));
    }
    fn apply(&self, x: &[R], y: &mut [R], work: &mut [R]) {
        self.time(|inner| inner.apply(x, y, work));
    }
    fn work_len(&self) -> usize {
        self.inner.work_len()
    }
    fn flops(&self) -> u64 {
        self.inner.flops()
    }
}

impl<R: Real, A: AdjointOperator<R>> AdjointOperator<R> for Timed<A> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        self.time(|inner| inner.apply_adjoint_add(alpha, x, y, work));
    }

    fn adjoint_flops(&self) -> u64 {
        self.inner.adjoint_flops()
    }
}

impl<R: Real, M: Preconditioner<R>> Preconditioner<R> for Timed<M> {
    fn size(&self) -> usize {
        self.inner.size()
    }
    fn solve(&self, r: &[R], z: &mut [R], work: &mut [R]) {
        self.time(|inner| inner.solve(r, z, work));
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
