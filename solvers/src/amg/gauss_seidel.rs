//! Gauss–Seidel as a smoother: forward sweeps before the coarse correction, backward ones after it.

use super::sweeps::SweepMatrix;
use crate::multigrid::{Correction, Hand, Smooth};
use fracas_operators::{LinearOperator, Real};

/// Sweeps by nodes over a matrix of 3×3 blocks.
pub(super) struct GaussSeidel<R> {
    a: SweepMatrix<R>,
    sweeps: usize,
}

impl<R: Real> GaussSeidel<R> {
    /// So many sweeps, at least one, on either side.
    pub(super) fn new(a: SweepMatrix<R>, sweeps: usize) -> Self {
        Self { a, sweeps }
    }
}

impl<R: Real> Smooth<R> for GaussSeidel<R> {
    fn operator(&self) -> &dyn LinearOperator<R> {
        &self.a
    }

    fn own_len(&self) -> usize {
        3 * self.a.rows()
    }

    fn before<'v>(&self, Hand { b, x, own, .. }: &'v mut Hand<'_, R>) -> &'v mut [R] {
        // (D + L) x = b, so b − A x = −U x: two half products
        self.a.forward_from_zero(b, x);
        (1..self.sweeps).for_each(|_| self.a.forward(b, x));
        match self.sweeps {
            1 => self.a.residual_after_forward(x, own),
            _ => self.a.residual(b, x, own),
        }
        own
    }

    fn after(&self, correction: &Correction<'_, R>, hand: &mut Hand<'_, R>, residual: bool) {
        let Hand { b, x, .. } = hand;
        correction.add_to(x);
        (0..self.sweeps).for_each(|_| self.a.backward(b, x));
        if residual {
            self.a.apply_add(-R::one(), x, b, &mut []);
        }
    }

    fn divide_by_diagonal(&self, r: &[R], z: &mut [R]) {
        self.a.diagonal_solve(r, z);
    }

    fn flops(&self) -> u64 {
        let (n, product, sweep) = (self.own_len() as u64, self.a.flops(), self.a.sweep_flops());
        match self.sweeps as u64 {
            // the first forward sweep and its residual read each half of the matrix once
            1 => 2 * sweep,
            sweeps => sweep / 2 + (2 * sweeps - 1) * sweep + product + n,
        }
    }

    fn bytes(&self) -> usize {
        self.a.bytes()
    }
}
