//! FSAI as a smoother.

use super::matrix::NodeMatrix;
use super::sweeps::Sweeps;
use crate::SetupError;
use crate::fsai::{Fsai, FsaiInverse};
use crate::multigrid::{Correction, Hand, Smooth};
use fracas_operators::sparse::Csr;
use fracas_operators::vector::axpy;
use fracas_operators::{LinearOperator, Preconditioner, Real};

/// Steps of the adaptive pattern, one entry each. Flat cells of 1:100, ν = 0.49, RACP on 6 thousand and 46 thousand unknowns:
/// 10, 15, 20, 30 steps give 47, 43, 41, 41 and 88, 65, 54, 49 iterations; set-up and solve of the larger one take 3.6, 3.8,
/// 4.5, 5.9 s.
const STEPS: usize = 20;

/// Least gain of a step. Source: the group's published default.
const EPSILON: f64 = 1e-3;

/// `ωGᵀG` of the matrix of a level with its `ω = min(1, 1.9/λ_max(G A Gᵀ))`.
///
/// # Errors
/// As [`Fsai`], rows of the level.
pub(super) fn inverse<S: Real, R: Real>(a: &NodeMatrix<S>) -> Result<FsaiInverse<R>, SetupError> {
    // without the zeros inside blocks
    let a = a.to_csr(|v| v != 0.0);
    let m = Fsai::adaptive(STEPS, 1, EPSILON).build(&a)?;
    Ok(m.damped(&Csr::new(a))?.cast())
}

/// `x ← x + ωGᵀG (b − A x)`, so many times.
pub(super) struct FsaiSmoother<R> {
    a: Sweeps<R>,
    fsai: FsaiInverse<R>,
    steps: usize,
}

impl<R: Real> FsaiSmoother<R> {
    pub(super) fn new(a: Sweeps<R>, fsai: FsaiInverse<R>, steps: usize) -> Self {
        Self { a, fsai, steps }
    }

    /// r arrives as the residual of x and leaves one step behind it.
    fn steps(&self, b: &[R], x: &mut [R], r: &mut [R], own: &mut [R]) {
        let (z, work) = own.split_at_mut(r.len());
        for step in 0..self.steps {
            if step > 0 {
                self.a.residual(b, x, r);
            }
            self.fsai.solve(r, z, work);
            axpy(R::one(), z, x);
        }
    }
}

impl<R: Real> Smooth<R> for FsaiSmoother<R> {
    fn operator(&self) -> &dyn LinearOperator<R> {
        &self.a
    }

    fn own_len(&self) -> usize {
        6 * self.a.rows() + self.fsai.work_len()
    }

    fn before<'v>(&self, Hand { b, x, own, .. }: &'v mut Hand<'_, R>) -> &'v mut [R] {
        let (r, own) = own.split_at_mut(b.len());
        x.fill(R::zero());
        r.copy_from_slice(b);
        self.steps(b, x, r, own);
        self.a.residual(b, x, r);
        r
    }

    fn after(&self, correction: &Correction<'_, R>, hand: &mut Hand<'_, R>, residual: bool) {
        let Hand { b, x, own, .. } = hand;
        let (r, own) = own.split_at_mut(b.len());
        correction.add_to(x);
        self.a.residual(b, x, r);
        self.steps(b, x, r, own);
        if residual {
            self.a.apply_add(-R::one(), x, b, &mut []);
        }
    }

    fn divide_by_diagonal(&self, r: &[R], z: &mut [R]) {
        self.a.diagonal_solve(r, z);
    }

    fn flops(&self) -> u64 {
        let n = 3 * self.a.rows() as u64;
        2 * self.steps as u64 * (self.fsai.flops() + self.a.flops() + 2 * n)
    }

    fn bytes(&self) -> usize {
        self.a.bytes() + self.fsai.bytes()
    }
}
