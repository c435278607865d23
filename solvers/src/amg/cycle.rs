//! V, W and K cycles.

use super::hierarchy::{Hierarchy, Level};
use super::step_length::step;
use super::{Amg, Cycle, Smoother};
use fracas_operators::vector::{axpy, dot, xpby};
use fracas_operators::{Preconditioner, Real};

/// Smallest over largest eigenvalue of the interval on which a Chebyshev polynomial smooths. Unit: 1.
const SMOOTHED_SHARE: f64 = 1.0 / 20.0;

/// What of the settings a cycle needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    pub(super) cycle: Cycle,
    /// Never [`Smoother::Auto`].
    pub(super) smoother: Smoother,
    pub(super) sweeps: usize,
}

impl From<&Amg> for Shape {
    fn from(settings: &Amg) -> Self {
        Self {
            cycle: settings.cycle,
            smoother: settings.smoother,
            sweeps: settings.sweeps.max(1),
        }
    }
}

/// Vectors of its own length that a level works with, besides b and x: r and two for the polynomial.
const OWN: usize = 3;

/// Vectors of the next level's length: its b and x, and what a second visit needs.
fn visiting(cycle: Cycle) -> usize {
    match cycle {
        Cycle::V => 2,
        Cycle::W => 4,
        Cycle::K => 7,
    }
}

impl<R: Real> Hierarchy<R> {
    /// Unknowns of level `k`, the coarsest included.
    fn size(&self, k: usize) -> usize {
        self.levels
            .get(k)
            .map_or(self.coarsest.size(), |level| 3 * level.matrix.rows())
    }

    /// Scratch entries of a cycle.
    pub(super) fn work_len(&self, shape: Shape) -> usize {
        (0..self.levels.len())
            .map(|k| OWN * self.size(k) + visiting(shape.cycle) * self.size(k + 1))
            .sum::<usize>()
            + self.coarsest.work_len()
    }

    /// `x ← M⁻¹ b` from level k down.
    pub(super) fn cycle(&self, shape: Shape, k: usize, b: &[R], x: &mut [R], work: &mut [R]) {
        let Some(level) = self.levels.get(k) else {
            return self.coarsest.solve(b, x, work);
        };
        let n = b.len();
        let (r, work) = work.split_at_mut(n);
        let (own, work) = work.split_at_mut((OWN - 1) * n);
        let m = self.size(k + 1);
        let (b_c, work) = work.split_at_mut(m);
        let (x_c, work) = work.split_at_mut(m);
        // x ← S(0, b),  r ← b − A x
        level.smooth_first(shape, b, x, r, own);
        // x_c ≈ A_c⁻¹ Pᵀ r
        level.transfer.restrict(r, b_c);
        self.visit(shape, k + 1, b_c, x_c, work);
        // x ← x + P x_c
        level.transfer.prolong_add(x_c, x);
        // x ← S*(x, b)
        level.smooth_last(shape, b, x, r, own);
    }

    /// `x ≈ A⁻¹ b` on level k by one or two cycles; destroys b.
    fn visit(&self, shape: Shape, k: usize, b: &mut [R], x: &mut [R], work: &mut [R]) {
        let n = b.len();
        match shape.cycle {
            _ if k >= self.levels.len() => self.cycle(shape, k, b, x, work),
            Cycle::V => self.cycle(shape, k, b, x, work),
            Cycle::W => {
                let (r, work) = work.split_at_mut(n);
                let (d, work) = work.split_at_mut(n);
                self.cycle(shape, k, b, x, work);
                // x ← x + M⁻¹ (b − A x)
                self.levels[k].matrix.residual(b, x, r);
                self.cycle(shape, k, r, d, work);
                axpy(R::one(), d, x);
            }
            Cycle::K => self.two_steps(shape, k, b, x, work),
        }
    }

    /// Two steps of flexible conjugate gradients from x = 0.
    ///
    /// # Source
    /// Notay & Vassilevski, Numer. Linear Algebra Appl. 15 (2008); the bound on [`step`] is ours.
    fn two_steps(&self, shape: Shape, k: usize, b: &mut [R], x: &mut [R], work: &mut [R]) {
        let n = b.len();
        let matrix = &self.levels[k].matrix;
        let mut rest = work;
        let [p, q, d, w, _] = [0; 5].map(|_| {
            let (part, tail) = std::mem::take(&mut rest).split_at_mut(n);
            rest = tail;
            part
        });
        self.cycle(shape, k, b, p, rest);
        matrix.product(p, q);
        let (rho, curvature) = (dot(b, p), dot(p, q));
        let Some(alpha) = step(rho, curvature) else {
            // b = 0, or beyond the range of R: the cycle as it is
            return x.copy_from_slice(p);
        };
        // x = α p,  b ← b − α A p
        x.fill(R::zero());
        axpy(alpha, p, x);
        axpy(-alpha, q, b);
        self.cycle(shape, k, b, d, rest);
        // d ← d − (qᵀd / pᵀq) p
        let beta = dot(q, d) / curvature;
        xpby(d, -beta, p);
        matrix.product(p, w);
        if let Some(step) = step(dot(b, p), dot(p, w)) {
            axpy(step, p, x);
        }
    }

    /// Flops of a cycle from level k down.
    pub(super) fn flops(&self, shape: Shape, k: usize) -> u64 {
        let Some(level) = self.levels.get(k) else {
            return self.coarsest.flops();
        };
        let own = level.flops(shape) + level.transfer.flops();
        let below = self.flops(shape, k + 1);
        let Some(next) = self.levels.get(k + 1) else {
            return own + below;
        };
        let (n, product) = (3 * next.matrix.rows() as u64, next.matrix.product_flops());
        own + match shape.cycle {
            Cycle::V => below,
            Cycle::W => 2 * below + product + 2 * n,
            Cycle::K => 2 * below + 2 * product + 16 * n,
        }
    }
}

impl<R: Real> Level<R> {
    /// `x ← S(0, b)` and `r ← b − A x`.
    fn smooth_first(&self, shape: Shape, b: &[R], x: &mut [R], r: &mut [R], own: &mut [R]) {
        let matrix = &self.matrix;
        match shape.smoother {
            Smoother::GaussSeidel | Smoother::Auto => {
                // (D + L) x = b, so b − A x = −U x: two half products
                matrix.forward_from_zero(b, x);
                for _ in 1..shape.sweeps {
                    matrix.forward(b, x);
                }
                if shape.sweeps == 1 {
                    matrix.residual_after_forward(x, r);
                } else {
                    matrix.residual(b, x, r);
                }
            }
            Smoother::Chebyshev => {
                x.fill(R::zero());
                r.copy_from_slice(b);
                self.chebyshev(shape.sweeps, x, r, own);
            }
            Smoother::Fsai => {
                x.fill(R::zero());
                r.copy_from_slice(b);
                self.richardson(shape.sweeps, b, x, r, own);
                matrix.residual(b, x, r);
            }
        }
    }

    /// `x ← S*(x, b)`, the adjoint of the first smoothing.
    fn smooth_last(&self, shape: Shape, b: &[R], x: &mut [R], r: &mut [R], own: &mut [R]) {
        match shape.smoother {
            Smoother::GaussSeidel | Smoother::Auto => {
                (0..shape.sweeps).for_each(|_| self.matrix.backward(b, x));
            }
            Smoother::Chebyshev => {
                self.matrix.residual(b, x, r);
                self.chebyshev(shape.sweeps, x, r, own);
            }
            Smoother::Fsai => {
                self.matrix.residual(b, x, r);
                self.richardson(shape.sweeps, b, x, r, own);
            }
        }
    }

    /// `x ← x + ωGᵀG r` and `r ← b − A x` in turn; r arrives as the residual of x and leaves one step behind it.
    fn richardson(&self, steps: usize, b: &[R], x: &mut [R], r: &mut [R], own: &mut [R]) {
        let Some(fsai) = &self.fsai else { return };
        let (z, work) = own.split_at_mut(r.len());
        for step in 0..steps {
            if step > 0 {
                self.matrix.residual(b, x, r);
            }
            fsai.solve(r, z, work);
            axpy(R::one(), z, x);
        }
    }

    /// `x ← x + p(D⁻¹A) D⁻¹ r` and `r ← b − A x`, p of degree `steps − 1` by the three-term recurrence on
    /// `[λ_max/20, λ_max]`.
    ///
    /// # Source
    /// Adams, Brezina, Hu, Tuminaro, J. Comput. Phys. 188 (2003).
    fn chebyshev(&self, steps: usize, x: &mut [R], r: &mut [R], own: &mut [R]) {
        let (d, z) = own.split_at_mut(r.len());
        let (high, low) = (self.lambda_max, SMOOTHED_SHARE * self.lambda_max);
        let (centre, radius) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = centre / radius;
        let mut rho = 1.0 / sigma;
        // d ← D⁻¹ r / θ
        self.matrix.diagonal_solve(r, z);
        d.fill(R::zero());
        axpy(R::of(1.0 / centre), z, d);
        for step in 0..steps {
            axpy(R::one(), d, x);
            self.matrix.product(d, z);
            axpy(-R::one(), z, r);
            if step + 1 < steps {
                // d ← ρ' ρ d + 2 ρ'/δ D⁻¹ r
                let next = 1.0 / (2.0 * sigma - rho);
                self.matrix.diagonal_solve(r, z);
                fracas_operators::vector::axpby(
                    R::of(2.0 * next / radius),
                    z,
                    R::of(next * rho),
                    d,
                );
                rho = next;
            }
        }
    }

    /// Flops of both smoothings and the residual between them.
    fn flops(&self, shape: Shape) -> u64 {
        let (n, product) = (3 * self.matrix.rows() as u64, self.matrix.product_flops());
        let sweep = self.matrix.sweep_flops();
        let steps = shape.sweeps as u64;
        match shape.smoother {
            // the first forward sweep and its residual read each half of the matrix once
            Smoother::GaussSeidel | Smoother::Auto if steps == 1 => 2 * sweep,
            Smoother::GaussSeidel | Smoother::Auto => {
                sweep / 2 + (2 * steps - 1) * sweep + product + n
            }
            Smoother::Fsai => {
                let fsai = self.fsai.as_ref().map_or(0, |m| m.flops());
                2 * steps * (fsai + product + 2 * n)
            }
            Smoother::Chebyshev => 2 * (steps * (product + 12 * n)) + product + n,
        }
    }
}
