//! Conjugate gradients.

use super::ritz::Coefficients;
use super::run::{End, Run, carve, drive, require_linear, work_len};
use super::{Breakdown, Criteria, Factor, KrylovMethod, Report, System, Watch};
use fracas_operators::Real;
use fracas_operators::vector::{axpy, copy, xpby};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Conjugate gradients for SPD A and M: `x_k` minimises `‖x − A⁻¹b‖_A` over `x_0 + K_k(M⁻¹A, M⁻¹r_0)`.
///
/// # Cost
/// One product, one preconditioner solve and `12 n` flops per iteration; four vectors.
///
/// # Errors
/// [`Breakdown::NotPositiveDefinite`] when `pᵀA p ≤ 0` or `rᵀM⁻¹r ≤ 0` shows up.
///
/// # Source
/// Hestenes & Stiefel (1952).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cg {}

impl<R: Real> KrylovMethod<R> for Cg {
    fn name(&self) -> &'static str {
        "cg"
    }

    fn work_len(&self, system: &System<R>, criteria: &Criteria) -> usize {
        work_len(system, 3) + Coefficients::<R>::work_len(criteria.max_iterations)
    }

    fn solve_in(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
        work: &mut [R],
    ) -> Result<Report, Breakdown> {
        require_linear("cg", system)?;
        drive("cg", system, criteria, x, watch, work, cycle)
    }
}

fn cycle<R: Real>(
    run: &mut Run<R>,
    x: &mut [R],
    r: &mut [R],
    mut work: &mut [R],
) -> Result<End, Breakdown> {
    let n = x.len();
    let [z, p, q] = [0; 3].map(|_| carve(&mut work, n));
    let mut coefficients = Coefficients::new(run.max_iterations(), &mut work);
    let mut norm_r = run.start();
    let indefinite = |run: &Run<R>, factor| Breakdown::NotPositiveDefinite {
        method: "cg",
        factor,
        iteration: run.iteration(),
    };
    run.solve(r, z);
    copy(z, p);
    let mut rho = run.finite(run.dot(r, z))?;
    loop {
        if rho <= R::zero() {
            return Err(indefinite(run, Factor::Preconditioner));
        }
        // α = rᵀz / pᵀA p
        run.product(p, q);
        let curvature = run.finite(run.dot(p, q))?;
        if curvature <= R::zero() {
            return Err(indefinite(run, Factor::Operator));
        }
        let alpha = rho / curvature;
        coefficients.advance(alpha, norm_r);
        axpy(alpha, p, x);
        axpy(-alpha, q, r);
        norm_r = run.norm2(r);
        if let Some(end) = run.step(norm_r)? {
            run.ritz(coefficients.ritz_nearest_to_zero());
            if run.ends(end, x) {
                return Ok(end);
            }
        }
        // z = M⁻¹r,  β = rᵀz / (rᵀz before),  p ← z + β p
        run.solve(r, z);
        let next = run.finite(run.dot(r, z))?;
        coefficients.turn(next / rho);
        xpby(z, next / rho, p);
        rho = next;
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::*;
    use super::*;
    use fracas_operators::laws::probe;
    use fracas_operators::vector::dot;
    use fracas_operators::{Dense, Identity, LinearOperator, Shape};

    #[test]
    fn ends_within_n_iterations_at_the_direct_solution() {
        for n in [1, 2, 17, 40] {
            let (a, b) = (spd(n, n as u64), probe(n, 5));
            let (x, report) = solve(&Cg {}, &a, &Identity { n }, &b, until(1e-12, n + 3));
            assert!(report.unwrap().relative_residual <= 1e-12);
            assert!(deviation(&x, &direct(&a, &b)) < 1e-11);
        }
    }

    #[test]
    fn iterates_minimise_the_energy_norm_over_the_krylov_space() {
        let (n, k) = (12, 4);
        let (a, b) = (spd(n, 3), probe::<f64>(n, 6));
        let (x, _) = solve(&Cg {}, &a, &Identity { n }, &b, until(0.0, k));
        // x = K (KᵀA K)⁻¹ Kᵀ b with K = [b, A b, …]
        let mut space = vec![b.clone()];
        for j in 1..k {
            let mut next = vec![0.0; n];
            a.apply(&space[j - 1], &mut next, &mut []);
            space.push(next);
        }
        let images: Vec<Vec<f64>> = space
            .iter()
            .map(|v| {
                let mut image = vec![0.0; n];
                a.apply(v, &mut image, &mut []);
                image
            })
            .collect();
        let small = Dense::from_fn(Shape::square(k), |i, j| dot(&space[i], &images[j]));
        let rhs: Vec<f64> = space.iter().map(|v| dot(v, &b)).collect();
        let y = direct(&small, &rhs);
        let mut best = vec![0.0; n];
        space
            .iter()
            .zip(&y)
            .for_each(|(v, y)| axpy(*y, v, &mut best));
        assert!(deviation(&x, &best) < 1e-9);
    }

    #[test]
    fn an_indefinite_operator_and_an_indefinite_preconditioner_are_told_apart() {
        let (n, b) = (20, probe(20, 7));
        let (a, m) = (spd(n, 1), indefinite(n, 2));
        let wrong = |operator: &Dense<f64>, m: Dense<f64>| {
            let (_, report) = solve(&Cg {}, operator, &Explicit(m), &b, until(1e-12, 100));
            match report.unwrap_err() {
                Breakdown::NotPositiveDefinite { factor, .. } => factor,
                other => panic!("{other}"),
            }
        };
        let identity = Dense::from_fn(Shape::square(n), |i, j| f64::from(u8::from(i == j)));
        assert_eq!(wrong(&m, identity), Factor::Operator);
        assert_eq!(wrong(&a, m), Factor::Preconditioner);
    }
}
