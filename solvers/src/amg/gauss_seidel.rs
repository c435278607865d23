//! Gauss–Seidel as a smoother: forward sweeps before the coarse correction, backward ones after it.

use super::sweeps::{Forward, Sweeps};
use crate::multigrid::{Correction, Hand, Smooth};
use fracas_operators::{LinearOperator, Real};

/// Sweeps by nodes.
pub(super) struct GaussSeidel<R> {
    a: Sweeps<R>,
    sweeps: usize,
}

impl<R: Real> GaussSeidel<R> {
    /// So many sweeps, at least one, on either side.
    pub(super) fn new(a: Sweeps<R>, sweeps: usize) -> Self {
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
        for sweep in 0..self.sweeps {
            let settings = Forward {
                from_zero: sweep == 0,
                residual: sweep + 1 == self.sweeps,
            };
            self.a.forward(b, x, own, settings);
        }
        own
    }

    fn after(&self, correction: &Correction<'_, R>, hand: &mut Hand<'_, R>, residual: bool) {
        let Hand { b, x, own, .. } = hand;
        correction.add_to(x);
        (0..self.sweeps).for_each(|_| self.a.backward(b, x, own));
        if residual {
            self.a.apply_add(-R::one(), x, b, &mut []);
        }
    }

    fn divide_by_diagonal(&self, r: &[R], z: &mut [R]) {
        self.a.diagonal_solve(r, z);
    }

    fn flops(&self) -> u64 {
        2 * self.sweeps as u64 * self.a.sweep_flops()
    }

    fn bytes(&self) -> usize {
        self.a.bytes()
    }
}
