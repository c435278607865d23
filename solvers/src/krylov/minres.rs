//! Minimal residuals for symmetric systems.

use super::run::{End, Run, carve, drive, require_linear, work_len};
use super::{Breakdown, Criteria, Factor, KrylovMethod, Report, System, Watch};
use fracas_operators::Real;
use fracas_operators::vector::{axpby, axpy, copy, scale};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::mem::swap;

/// Minimal residuals for symmetric A, also indefinite, and SPD M: `x_k` minimises `‖b − A x‖_{M⁻¹}` over
/// `x_0 + K_k(M⁻¹A, M⁻¹r_0)`.
///
/// The residual itself follows `r_k = s_k² r_{k−1} + c_k η_k v_{k+1}`, so its 2-norm is known without a product.
///
/// # Cost
/// One product, one preconditioner solve and `22 n` flops per iteration; seven vectors.
///
/// # Errors
/// [`Breakdown::NotPositiveDefinite`] when `vᵀM⁻¹v < 0` shows up: take SQMR for an indefinite M.
///
/// # Source
/// Paige & Saunders (1975); Elman, Silvester & Wathen, *Finite Elements and Fast Iterative Solvers*, alg. 4.1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Minres {}

impl<R: Real> KrylovMethod<R> for Minres {
    fn name(&self) -> &'static str {
        "minres"
    }

    fn work_len(&self, system: &System<R>, _criteria: &Criteria) -> usize {
        work_len(system, 6)
    }

    fn solve_in(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
        work: &mut [R],
    ) -> Result<Report, Breakdown> {
        require_linear("minres", system)?;
        drive("minres", system, criteria, x, watch, work, cycle)
    }
}

/// `γ = √(vᵀM⁻¹v)`, 0 where rounding is all that is left of v.
fn length<R: Real>(run: &Run<R>, v: &[R], z: &[R], rounding: R) -> Result<R, Breakdown> {
    let square = run.finite(run.dot(v, z))?;
    if square > R::zero() {
        Ok(square.sqrt())
    } else if run.norm2(v) <= rounding {
        Ok(R::zero())
    } else {
        Err(Breakdown::NotPositiveDefinite {
            method: "minres",
            factor: Factor::Preconditioner,
            iteration: run.iteration(),
        })
    }
}

fn cycle<R: Real>(
    run: &mut Run<R>,
    x: &mut [R],
    r: &mut [R],
    mut work: &mut [R],
) -> Result<End, Breakdown> {
    let n = x.len();
    let [mut v, mut v_old, mut z, mut t, mut w, mut w_old] = [0; 6].map(|_| carve(&mut work, n));
    for zero in [&mut v_old, &mut w, &mut w_old] {
        zero.fill(R::zero());
    }
    copy(r, v);
    run.solve(v, z);
    let mut gamma = length(run, v, z, R::zero())?;
    let mut gamma_old = R::one();
    let mut eta = gamma;
    let (mut c, mut c_old, mut s, mut s_old) = (R::one(), R::one(), R::zero(), R::zero());
    loop {
        // Lanczos: v_{k+1} = A z − (δ/γ_k) v_k − (γ_k/γ_{k−1}) v_{k−1}  with z = M⁻¹v_k/γ_k
        scale(gamma.recip(), z);
        run.product(z, t);
        let delta = run.finite(run.dot(t, z))?;
        let rounding = R::of(10.0) * R::epsilon() * run.norm2(t);
        axpby(R::one(), t, -gamma / gamma_old, v_old);
        axpy(-delta / gamma, v, v_old);
        swap(&mut v, &mut v_old);
        run.solve(v, t);
        let gamma_next = length(run, v, t, rounding)?;

        // QR of the tridiagonal matrix by rotations
        let below = c * delta - c_old * s * gamma;
        let diagonal = below.hypot(gamma_next);
        if diagonal <= R::epsilon() * (delta.abs() + gamma) {
            // A is singular on an invariant space: nothing left to minimise
            run.step(run.norm2(r))?;
            return Ok(End::Believed);
        }
        let above = s * delta + c_old * c * gamma;
        let above_twice = s_old * gamma;
        (c_old, s_old) = (c, s);
        (c, s) = (below / diagonal, gamma_next / diagonal);

        // w_{k+1} = (z − α₃ w_{k−1} − α₂ w_k)/α₁,  x ← x + c η w
        axpby(diagonal.recip(), z, -above_twice / diagonal, w_old);
        axpy(-above / diagonal, w, w_old);
        swap(&mut w, &mut w_old);
        axpy(c * eta, w, x);

        // r_k = s² r_{k−1} + c η_k v_{k+1}/γ_{k+1}
        eta = -s * eta;
        let share = if gamma_next > R::zero() {
            c * eta / gamma_next
        } else {
            R::zero()
        };
        axpby(share, v, s * s, r);
        if let Some(end) = run.step(run.norm2(r))?
            && run.ends(end, x)
        {
            return Ok(end);
        }
        if gamma_next == R::zero() {
            return Ok(End::Believed);
        }
        swap(&mut z, &mut t);
        (gamma_old, gamma) = (gamma, gamma_next);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Gmres;
    use super::super::oracle::*;
    use super::*;
    use crate::{Silent, Step};
    use fracas_operators::laws::probe;
    use fracas_operators::{Dense, Identity, Shape};
    use std::ops::ControlFlow;

    #[test]
    fn ends_after_about_n_iterations_at_the_direct_solution() {
        for n in [1, 2, 17, 40] {
            let (a, b) = (indefinite(n, n as u64), probe(n, 5));
            for m in [
                spd(n, 9),
                Dense::from_fn(Shape::square(n), |i, j| f64::from(u8::from(i == j))),
            ] {
                let (x, report) = solve(
                    &Minres {},
                    &a,
                    &Explicit(m),
                    &b,
                    until(1e-11, n + n / 4 + 1),
                );
                assert!(report.unwrap().relative_residual <= 1e-11);
                assert!(deviation(&x, &direct(&a, &b)) < 1e-9);
            }
        }
    }

    #[test]
    fn residuals_never_grow_and_are_the_true_ones() {
        let (n, b) = (60, probe(60, 4));
        let a = indefinite(n, 8);
        let mut history = Vec::new();
        let system = System {
            operator: &a,
            preconditioner: &Identity { n },
            rhs: &b,
        };
        let mut watch = |step: &Step| {
            if let Step::Krylov {
                relative_residual, ..
            } = step
            {
                history.push(*relative_residual);
            }
            ControlFlow::Continue(())
        };
        let mut x = vec![0.0; n];
        let report = Minres {}.solve(&system, &until(1e-10, 200), &mut x, &mut watch);
        assert!(report.unwrap().iterations <= n + n / 4);
        assert!(history.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-12)));
        for k in [1, 5, 20] {
            let mut x = vec![0.0; n];
            let report = Minres {}
                .solve(&system, &until(0.0, k), &mut x, &mut Silent)
                .unwrap();
            assert!((report.relative_residual - history[k]).abs() < 1e-12);
        }
    }

    #[test]
    fn without_a_preconditioner_its_iterates_are_those_of_gmres() {
        let (n, b) = (40, probe(40, 4));
        let a = indefinite(n, 8);
        for k in [1, 2, 5, 11] {
            let (x, _) = solve(&Minres {}, &a, &Identity { n }, &b, until(0.0, k));
            let (y, _) = solve(&Gmres::default(), &a, &Identity { n }, &b, until(0.0, k));
            assert!(deviation(&x, &y) < 1e-9, "{k}");
        }
    }

    #[test]
    fn an_indefinite_preconditioner_is_refused() {
        let (n, b) = (30, probe(30, 7));
        let m = Explicit(indefinite(n, 2));
        let (_, report) = solve(&Minres {}, &indefinite(n, 1), &m, &b, until(1e-12, 100));
        assert!(matches!(
            report,
            Err(Breakdown::NotPositiveDefinite {
                factor: Factor::Preconditioner,
                ..
            })
        ));
    }
}
