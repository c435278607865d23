//! A level: its operator, its smoother, its way down.

use super::block_jacobi::{BlockJacobi, NoInverse};
use crate::amg::lambda::largest_generalized;
use fracas_operators::small::Symmetric;
use fracas_operators::sparse::Block3;
use fracas_operators::vector::axpy;
use fracas_operators::{LinearOperator, Real};

/// A Chebyshev polynomial in D⁻¹A, D the 3×3 diagonal blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chebyshev {
    /// Products with D⁻¹ per smoothing, at least 1.
    pub degree: usize,
    /// Smallest over largest eigenvalue of the interval on which it smooths. Unit: 1.
    pub share: f64,
}

/// P and Pᵀ between a level and the next one.
pub trait Transfer<R: Real>: Send + Sync {
    /// Unknowns of the next level.
    fn coarse_len(&self) -> usize;

    /// `b_c ← Pᵀ r`.
    fn restrict(&self, r: &[R], coarse: &mut [R]);

    /// `x ← P x_c`.
    fn prolong(&self, coarse: &[R], x: &mut [R]);

    /// Flops of one restriction and one prolongation.
    fn flops(&self) -> u64;

    /// Bytes held.
    fn bytes(&self) -> usize;
}

/// One level that smooths.
pub struct Level<R> {
    pub(super) operator: Box<dyn LinearOperator<R>>,
    pub(super) transfer: Box<dyn Transfer<R>>,
    pub(super) bytes: usize,
    jacobi: BlockJacobi<R>,
    /// Upper estimate of `λ_max(D⁻¹A)`.
    lambda_max: f64,
    /// Components that are no unknowns, ascending.
    pub(super) fixed: Vec<u32>,
}

impl<R: Real> Level<R> {
    /// A level from its operator (whose memory is `bytes`), the operator's diagonal blocks, those beside the diagonal that may
    /// tie nodes together, where it has any, and the components `fixed`, ascending, that are no unknowns: the operator may read
    /// and write these, and what it writes there is not used. Blocks come in f64 and are inverted in f64, whatever R is.
    ///
    /// # Cost
    /// Ten products for λ_max.
    ///
    /// # Errors
    /// [`NoInverse`] for a diagonal block without an inverse.
    pub fn new(
        operator: Box<dyn LinearOperator<R>>,
        bytes: usize,
        diagonal: Vec<Symmetric<f64>>,
        couplings: Option<&Block3<f64>>,
        fixed: Vec<u32>,
        transfer: Box<dyn Transfer<R>>,
    ) -> Result<Self, NoInverse> {
        let jacobi = match couplings {
            Some(couplings) => BlockJacobi::with_couplings(&diagonal, couplings, &fixed)?,
            None => BlockJacobi::new(&diagonal, &fixed)?,
        };
        drop(diagonal);
        let n = 3 * jacobi.nodes();
        assert_eq!(operator.shape().rows, n, "diagonal blocks of another level");
        let mut work = vec![R::zero(); operator.work_len()];
        let lambda_max = largest_generalized(
            n,
            |x, y| operator.apply(x, y, &mut work),
            |r, z| jacobi.solve(r, z),
        );
        Ok(Self {
            operator,
            transfer,
            bytes,
            jacobi,
            lambda_max,
            fixed,
        })
    }

    /// Unknowns, fixed ones included.
    pub fn size(&self) -> usize {
        3 * self.jacobi.nodes()
    }

    /// The operator; rows and columns of fixed components are not used.
    pub fn operator(&self) -> &dyn LinearOperator<R> {
        &*self.operator
    }

    /// The way to the next level.
    pub fn transfer(&self) -> &dyn Transfer<R> {
        &*self.transfer
    }

    /// Components that are no unknowns, ascending.
    pub fn fixed(&self) -> &[u32] {
        &self.fixed
    }

    /// Upper estimate of `λ_max(D⁻¹A)`.
    pub fn lambda_max(&self) -> f64 {
        self.lambda_max
    }

    /// `z ← D⁻¹ r`, zero in fixed components.
    pub(super) fn divide_by_diagonal(&self, r: &[R], z: &mut [R]) {
        self.jacobi.solve(r, z);
    }

    /// Bytes of operator, smoother and transfer.
    pub(super) fn total_bytes(&self) -> usize {
        self.bytes + self.jacobi.bytes() + self.transfer.bytes() + size_of_val(&*self.fixed)
    }

    /// Zero in the fixed components.
    pub(super) fn clear_fixed(&self, x: &mut [R]) {
        self.fixed.iter().for_each(|i| x[*i as usize] = R::zero());
    }

    /// `r ← r − A d`.
    pub(super) fn subtract_product(&self, d: &[R], r: &mut [R], work: &mut [R]) {
        self.operator.apply_add(-R::one(), d, r, work);
    }

    /// `x ← x + d`, `r ← r − A d`.
    pub(super) fn correct(&self, d: &[R], x: &mut [R], r: &mut [R], work: &mut [R]) {
        axpy(R::one(), d, x);
        self.subtract_product(d, r, work);
    }

    /// `x ← x + p(D⁻¹A) D⁻¹ r`, p of degree `degree − 1` by the three-term recurrence on `[share·λ_max, λ_max]`; from
    /// x = 0 if `FROM_ZERO`. r arrives as the residual of x and leaves as it was before the last step, which is d:
    /// `b − A x = r − A d`.
    ///
    /// # Source
    /// Adams, Brezina, Hu, Tuminaro, J. Comput. Phys. 188 (2003).
    pub(super) fn smooth<const FROM_ZERO: bool>(
        &self,
        polynomial: Chebyshev,
        x: &mut [R],
        r: &mut [R],
        d: &mut [R],
        work: &mut [R],
    ) {
        let (high, low) = (self.lambda_max, polynomial.share * self.lambda_max);
        let (centre, radius) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / radius;
        let mut rho = 1.0 / sigma;
        let first = R::of(1.0 / centre);
        if FROM_ZERO {
            self.jacobi.start(first, r, d, x);
        } else {
            self.jacobi.restart(first, r, d, x);
        }
        for _ in 1..polynomial.degree {
            self.subtract_product(d, r, work);
            let next = 1.0 / (2.0 * sigma - rho);
            // d ← ρ' ρ d + 2 ρ'/δ D⁻¹ r
            let (a, c) = (R::of(next * rho), R::of(2.0 * next / radius));
            self.jacobi.step(a, c, r, d, x);
            rho = next;
        }
    }

    /// Flops of both smoothings, the residuals between them and the correction.
    pub(super) fn flops(&self, degree: usize) -> u64 {
        let step = self.operator.flops() + self.jacobi.flops();
        2 * degree as u64 * step + self.transfer.flops()
    }
}
