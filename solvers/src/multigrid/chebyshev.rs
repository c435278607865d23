//! Chebyshev polynomials in D⁻¹A, D the 3×3 diagonal blocks.

use super::block_jacobi::BlockJacobi;
use super::lambda::{STEPS, largest_generalized};
use super::level::Correction;
use super::smooth::{Hand, Smooth};
use fracas_operators::vector::axpy;
use fracas_operators::{LinearOperator, Real};

/// Which polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chebyshev {
    /// Products with D⁻¹ per smoothing, at least 1.
    pub degree: usize,
    /// Smallest over largest eigenvalue of the interval on which it smooths. Unit: 1.
    pub share: f64,
}

/// D⁻¹A of a level and its largest eigenvalue.
pub struct Scaled<R> {
    operator: Box<dyn LinearOperator<R>>,
    /// Of the operator.
    bytes: usize,
    jacobi: BlockJacobi<R>,
    /// Upper estimate of `λ_max(D⁻¹A)`.
    lambda_max: f64,
}

impl<R: Real> Scaled<R> {
    /// Of an operator, whose memory is `bytes`, and its D⁻¹, with a λ_max that is known.
    pub fn new(
        operator: Box<dyn LinearOperator<R>>,
        bytes: usize,
        jacobi: BlockJacobi<R>,
        lambda_max: f64,
    ) -> Self {
        let n = 3 * jacobi.nodes();
        assert_eq!(operator.shape().rows, n, "diagonal blocks of another level");
        Self {
            operator,
            bytes,
            jacobi,
            lambda_max,
        }
    }

    /// The same with an estimate of λ_max that is close enough for polynomials of this degree. Beyond its interval one of degree d grows by
    /// e within `λ_max/d²`, and of a spectrum that is dense there Lanczos misses some `λ_max/k²` in k steps: with ν = 0.4999, degree 48, the cycle
    /// of a bar was indefinite after ten steps.
    ///
    /// # Cost
    /// Ten products, or as many as the degree.
    pub fn estimated(
        operator: Box<dyn LinearOperator<R>>,
        bytes: usize,
        jacobi: BlockJacobi<R>,
        degree: usize,
    ) -> Self {
        let mut work = vec![R::zero(); operator.work_len()];
        let lambda_max = largest_generalized(
            (operator.shape().rows, degree.max(STEPS)),
            |x, y| operator.apply(x, y, &mut work),
            |r, z| jacobi.solve(r, z),
        );
        Self::new(operator, bytes, jacobi, lambda_max)
    }

    /// Upper estimate of `λ_max(D⁻¹A)`.
    pub fn lambda_max(&self) -> f64 {
        self.lambda_max
    }

    /// `r ← r − A d`.
    fn subtract_product(&self, d: &[R], r: &mut [R], work: &mut [R]) {
        self.operator.apply_add(-R::one(), d, r, work);
    }
}

/// `x ← x + p(D⁻¹A) D⁻¹(b − A x)`, p of degree `degree − 1` by the three-term recurrence on `[share·λ_max, λ_max]`.
///
/// # Source
/// Adams, Brezina, Hu, Tuminaro, J. Comput. Phys. 188 (2003).
pub struct BlockChebyshev<R> {
    level: Scaled<R>,
    polynomial: Chebyshev,
}

impl<R: Real> BlockChebyshev<R> {
    /// By this polynomial.
    pub fn new(level: Scaled<R>, polynomial: Chebyshev) -> Self {
        assert!(polynomial.degree > 0, "a smoother smooths");
        Self { level, polynomial }
    }

    /// One smoothing, from x = 0 if `FROM_ZERO`. r arrives as the residual of x and leaves as it was before the last step, which
    /// is d: `b − A x = r − A d`.
    fn smooth<const FROM_ZERO: bool>(&self, x: &mut [R], r: &mut [R], d: &mut [R], work: &mut [R]) {
        let (high, low) = (
            self.level.lambda_max,
            self.polynomial.share * self.level.lambda_max,
        );
        let (centre, radius) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / radius;
        let mut rho = 1.0 / sigma;
        let first = R::of(1.0 / centre);
        if FROM_ZERO {
            self.level.jacobi.start(first, r, d, x);
        } else {
            self.level.jacobi.restart(first, r, d, x);
        }
        for _ in 1..self.polynomial.degree {
            self.level.subtract_product(d, r, work);
            let next = 1.0 / (2.0 * sigma - rho);
            // d ← ρ' ρ d + 2 ρ'/δ D⁻¹ r
            let (a, c) = (R::of(next * rho), R::of(2.0 * next / radius));
            self.level.jacobi.step(a, c, r, d, x);
            rho = next;
        }
    }
}

impl<R: Real> Smooth<R> for BlockChebyshev<R> {
    fn operator(&self) -> &dyn LinearOperator<R> {
        &*self.level.operator
    }

    fn own_len(&self) -> usize {
        3 * self.level.jacobi.nodes()
    }

    fn before<'v>(&self, Hand { b, x, own, work }: &'v mut Hand<'_, R>) -> &'v mut [R] {
        self.smooth::<true>(x, b, own, work);
        self.level.subtract_product(own, b, work);
        b
    }

    fn after(&self, correction: &Correction<'_, R>, hand: &mut Hand<'_, R>, residual: bool) {
        let Hand { b, x, own, work } = hand;
        correction.write(own);
        axpy(R::one(), own, x);
        self.level.subtract_product(own, b, work);
        self.smooth::<false>(x, b, own, work);
        if residual {
            self.level.subtract_product(own, b, work);
        }
    }

    fn divide_by_diagonal(&self, r: &[R], z: &mut [R]) {
        self.level.jacobi.solve(r, z);
    }

    fn flops(&self) -> u64 {
        2 * self.polynomial.degree as u64
            * (self.level.operator.flops() + self.level.jacobi.flops())
    }

    fn bytes(&self) -> usize {
        self.level.bytes + self.level.jacobi.bytes()
    }
}
