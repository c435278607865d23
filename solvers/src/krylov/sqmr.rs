//! Symmetric quasi-minimal residuals.

use super::ritz::Coefficients;
use super::run::{End, Run, carve, drive, require_linear, work_len};
use super::{Breakdown, Criteria, KrylovMethod, Report, System, Watch};
use fracas_operators::Real;
use fracas_operators::vector::{axpby, axpy, copy, xpby};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Simplified QMR for symmetric A with symmetric M, both possibly indefinite: GMRES-like at the price of CG.
///
/// The coupled recurrence of CG with `ρ = rᵀM⁻¹r` of either sign, smoothed by
/// `x_k = (1 − c²) x_{k−1} + c² x_k^{CG}`, `c² = 1/(1 + ϑ²)`, `ϑ = ‖r_k^{CG}‖/τ_{k−1}`, which gives
/// the same smoothing for the residual. With M = I it is MINRES.
///
/// # Cost
/// One product, one preconditioner solve and `24 n` flops per iteration; six vectors.
///
/// # Errors
/// [`Breakdown::Lanczos`] when `qᵀA q = 0` or `rᵀM⁻¹r = 0`.
///
/// # Source
/// Freund & Nachtigal (1994), without look-ahead, preconditioned from the right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sqmr {}

impl<R: Real> KrylovMethod<R> for Sqmr {
    fn name(&self) -> &'static str {
        "sqmr"
    }

    fn work_len(&self, system: &System<R>, criteria: &Criteria) -> usize {
        work_len(system, 5) + Coefficients::<R>::work_len(criteria.max_iterations)
    }

    fn solve_in(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
        work: &mut [R],
    ) -> Result<Report, Breakdown> {
        require_linear("sqmr", system)?;
        drive("sqmr", system, criteria, x, watch, work, cycle)
    }
}

fn cycle<R: Real>(
    run: &mut Run<R>,
    x: &mut [R],
    r: &mut [R],
    mut work: &mut [R],
) -> Result<End, Breakdown> {
    let n = x.len();
    let [smooth, t, u, q, d] = [0; 5].map(|_| carve(&mut work, n));
    let mut coefficients = Coefficients::new(run.max_iterations(), &mut work);
    let epsilon = R::epsilon();
    copy(r, smooth);
    d.fill(R::zero());
    run.solve(r, u);
    copy(u, q);
    let mut rho = run.finite(run.dot(r, u))?;
    let mut norm_r = run.start();
    let (mut tau, mut theta) = (norm_r, R::zero());
    loop {
        if rho.abs() <= epsilon * norm_r * run.norm2(u) {
            return run.lanczos("rᵀM⁻¹r");
        }
        // α = ρ / qᵀA q,  r ← r − α A q
        run.product(q, t);
        let sigma = run.finite(run.dot(q, t))?;
        if sigma.abs() <= epsilon * run.norm2(q) * run.norm2(t) {
            return run.lanczos("qᵀA q");
        }
        let alpha = rho / sigma;
        coefficients.advance(alpha, norm_r);
        axpy(-alpha, t, r);
        norm_r = run.finite(run.norm2(r))?;
        // d ← c²ϑ² d + c²α q,  x ← x + d
        let theta_old = theta;
        theta = norm_r / tau;
        let c_square = (R::one() + theta * theta).recip();
        tau *= theta * c_square.sqrt();
        axpby(c_square * alpha, q, c_square * theta_old * theta_old, d);
        axpy(R::one(), d, x);
        // s ← (1 − c²) s + c² r
        axpby(c_square, r, R::one() - c_square, smooth);
        if let Some(end) = run.step(run.norm2(smooth))? {
            run.ritz(coefficients.ritz_nearest_to_zero());
            if run.ends(end, x) {
                return Ok(end);
            }
        }
        // β = ρ / (ρ before),  q ← M⁻¹r + β q
        run.solve(r, u);
        let next = run.finite(run.dot(r, u))?;
        coefficients.turn(next / rho);
        xpby(u, next / rho, q);
        rho = next;
    }
}

#[cfg(test)]
mod tests {
    use super::super::Minres;
    use super::super::oracle::*;
    use super::*;
    use fracas_operators::laws::probe;
    use fracas_operators::{Dense, Identity, Shape};

    #[test]
    fn without_a_preconditioner_it_is_minres() {
        let (n, b) = (40, probe(40, 4));
        let a = indefinite(n, 8);
        for k in [1, 2, 5, 11] {
            let identity = Identity { n };
            let (x, _) = solve(&Sqmr {}, &a, &identity, &b, until(0.0, k));
            let (y, _) = solve(&Minres {}, &a, &identity, &b, until(0.0, k));
            assert!(deviation(&x, &y) < 1e-7, "{k}");
        }
    }

    #[test]
    fn with_an_spd_preconditioner_it_needs_about_as_many_iterations_as_minres() {
        let (n, b) = (50, probe(50, 4));
        let (a, m) = (indefinite(n, 8), Explicit(spd(n, 3)));
        let (x, report) = solve(&Sqmr {}, &a, &m, &b, until(1e-10, 200));
        let (y, other) = solve(&Minres {}, &a, &m, &b, until(1e-10, 200));
        assert!(
            report
                .unwrap()
                .iterations
                .abs_diff(other.unwrap().iterations)
                <= 3
        );
        assert!(deviation(&x, &y) < 1e-8);
    }

    #[test]
    fn takes_an_indefinite_preconditioner() {
        for n in [1, 2, 30] {
            let (a, b) = (indefinite(n, 1), probe(n, 7));
            let (x, report) = solve(
                &Sqmr {},
                &a,
                &Explicit(indefinite(n, 2)),
                &b,
                until(1e-10, 3 * n),
            );
            assert!(report.unwrap().relative_residual <= 1e-10);
            assert!(deviation(&x, &direct(&a, &b)) < 1e-8);
        }
    }

    #[test]
    fn a_vanishing_curvature_is_a_breakdown() {
        // A = [0 1; 1 0], b = e_1: qᵀA q = 0 at once
        let a = Dense::from_fn(Shape::square(2), |i, j| f64::from(u8::from(i != j)));
        let (_, report) = solve(
            &Sqmr {},
            &a,
            &Identity { n: 2 },
            &[1.0, 0.0],
            until(1e-8, 9),
        );
        assert!(matches!(
            report,
            Err(Breakdown::Lanczos { iteration: 1, .. })
        ));
    }
}
