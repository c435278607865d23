//! GMRES(m), right-preconditioned.

use super::arnoldi::Arnoldi;
use super::run::{End, Run, drive, require_linear, work_len};
use super::{Breakdown, Criteria, KrylovMethod, Report, System, Watch};
use fracas_operators::Real;
use fracas_operators::vector::axpy;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// Generalized minimal residuals: `x_k = x_0 + M⁻¹ V_k y` with `y = argmin ‖r_0 − A M⁻¹ V_k y‖₂`, restarted.
///
/// Right preconditioning, so the residual that is minimised is the true one. Never breaks down: an invariant space
/// holds the solution if A is nonsingular.
///
/// # Cost
/// Step k of a cycle: one product, one preconditioner solve, `8 k n` flops. Memory: `restart + 2` vectors, touched one
/// by one.
///
/// # Source
/// Saad & Schultz (1986); Saad, *Iterative Methods*, alg. 9.5.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gmres {
    /// Steps before the basis is thrown away.
    pub restart: NonZeroUsize,
}

/// GMRES(100), the choice of the reference code for unsymmetric Jacobians.
pub(super) const RESTART: NonZeroUsize = Gmres::restarted(100).restart;

impl Default for Gmres {
    fn default() -> Self {
        Self { restart: RESTART }
    }
}

impl Gmres {
    /// GMRES(`restart`); stops at 0.
    pub const fn restarted(restart: usize) -> Self {
        assert!(restart > 0, "GMRES(0) has no basis");
        Self {
            restart: NonZeroUsize::MIN.saturating_add(restart - 1),
        }
    }
}

/// Steps that a cycle can have.
pub(super) fn steps<R: Real>(
    restart: NonZeroUsize,
    system: &System<R>,
    criteria: &Criteria,
) -> usize {
    restart
        .get()
        .min(criteria.max_iterations)
        .min(system.whole_size())
}

impl<R: Real> KrylovMethod<R> for Gmres {
    fn name(&self) -> &'static str {
        "gmres"
    }

    fn work_len(&self, system: &System<R>, criteria: &Criteria) -> usize {
        let m = steps(self.restart, system, criteria);
        work_len(system, 0) + Arnoldi::<R>::work_len(system.size(), m)
    }

    fn solve_in(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
        work: &mut [R],
    ) -> Result<Report, Breakdown> {
        require_linear("gmres", system)?;
        let m = steps(self.restart, system, criteria);
        let cycle =
            |run: &mut Run<R>, x: &mut [R], r: &mut [R], work: &mut [R]| cycle(m, run, x, r, work);
        drive("gmres", system, criteria, x, watch, work, cycle)
    }
}

/// At most `m` steps from `r = b − A x`.
fn cycle<R: Real>(
    m: usize,
    run: &mut Run<R>,
    x: &mut [R],
    r: &mut [R],
    work: &mut [R],
) -> Result<End, Breakdown> {
    let mut arnoldi = Arnoldi::new(r, run.start(), m, work);
    let z = r; // its direction is v_0 now
    loop {
        // w = A M⁻¹ v_k
        let (v, w) = arnoldi.next();
        run.solve(v, z);
        run.product(z, w);
        let grown = arnoldi.grow(&|sums| run.sum_over_parts(sums));
        let last = arnoldi.last(&grown);
        if let Some(end) = run.step(grown.residual)?.or(last) {
            run.ritz(arnoldi.ritz_nearest_to_zero());
            // x ← x + M⁻¹ V y
            run.solve(arnoldi.combine(), z);
            axpy(R::one(), z, x);
            if run.ends(end, x) {
                return Ok(end);
            }
            if let Some(end) = last {
                return Ok(end);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::*;
    use super::*;
    use crate::{Silent, Step};
    use fracas_operators::laws::probe;
    use fracas_operators::{Dense, Identity, LinearOperator, Shape};
    use std::ops::ControlFlow;

    #[test]
    fn ends_within_n_iterations_at_the_direct_solution() {
        for n in [1, 2, 17, 60] {
            let (a, b) = (unsymmetric(n, n as u64), probe(n, 5));
            let m = Explicit(spd(n, 3));
            let (x, report) = solve(&Gmres::default(), &a, &m, &b, until(1e-12, n + 1));
            assert!(report.unwrap().relative_residual <= 1e-12);
            assert!(deviation(&x, &direct(&a, &b)) < 1e-10);
        }
    }

    #[test]
    fn needs_as_many_iterations_as_there_are_distinct_eigenvalues() {
        let values: Vec<f64> = (0..30).map(|k| [1.0, 2.0, -3.0, 7.0][k % 4]).collect();
        let a = with_eigenvalues(&values, 1);
        let b = probe(30, 2);
        let (_, report) = solve(
            &Gmres::default(),
            &a,
            &Identity { n: 30 },
            &b,
            until(1e-10, 90),
        );
        assert_eq!(report.unwrap().iterations, 4);
    }

    #[test]
    fn residuals_never_grow_and_meet_the_true_one_across_restarts() {
        let n = 80;
        let (a, b) = (unsymmetric(n, 1), probe(n, 2));
        let system = System {
            operator: &a,
            preconditioner: &Identity { n },
            rhs: &b,
        };
        let mut history: Vec<f64> = Vec::new();
        let mut watch = |step: &Step| {
            if let Step::Krylov {
                relative_residual, ..
            } = step
            {
                history.push(*relative_residual);
            }
            ControlFlow::Continue(())
        };
        let (mut x, criteria) = (vec![0.0; n], until(1e-9, 500));
        let report = Gmres::restarted(6).solve(&system, &criteria, &mut x, &mut watch);
        assert_eq!(report.unwrap().iterations + 1, history.len());
        assert!(history.len() > 7, "no restart was needed");
        assert!(history.windows(2).all(|w| w[1] <= w[0] * (1.0 + 1e-10)));
        for k in [3, 6, 8] {
            let mut x = vec![0.0; n];
            let report = Gmres::restarted(6).solve(&system, &until(0.0, k), &mut x, &mut Silent);
            let report = report.unwrap();
            assert!((report.relative_residual - history[k]).abs() < 1e-13);
        }
    }

    #[test]
    fn the_cyclic_shift_makes_no_progress_before_its_last_step() {
        let n = 8;
        let shift = Dense::from_fn(Shape::square(n), |i, j| {
            f64::from(u8::from(i == (j + 1) % n))
        });
        let mut b = vec![0.0; n];
        b[0] = 1.0;
        let identity = Identity { n };
        let (_, full) = solve(&Gmres::default(), &shift, &identity, &b, until(1e-10, 50));
        assert_eq!(full.unwrap().iterations, n);
        let (_, short) = solve(
            &Gmres::restarted(n - 1),
            &shift,
            &identity,
            &b,
            until(1e-10, 50),
        );
        let short = short.unwrap();
        assert_eq!(short.outcome, super::super::Outcome::IterationLimit);
        assert!((short.relative_residual - 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_singular_operator_is_solved_where_it_can_be_and_reported_where_not() {
        // A = diag(1, 2, 0)
        let a = Dense::from_fn(Shape::square(3), |i, j| {
            if i == j { [1.0, 2.0, 0.0][i] } else { 0.0 }
        });
        let run = |b: &[f64]| {
            solve(
                &Gmres::default(),
                &a,
                &Identity { n: 3 },
                b,
                until(1e-12, 30),
            )
        };
        let (x, report) = run(&[1.0, 1.0, 0.0]);
        assert!(report.is_ok());
        assert!(deviation(&x, &[1.0, 0.5, 0.0]) < 1e-14);
        let (x, report) = run(&[1.0, 1.0, 1.0]);
        assert!(
            matches!(report, Err(Breakdown::Stagnation { .. })),
            "{report:?}"
        );
        let mut image = vec![0.0; 3];
        a.apply(&x, &mut image, &mut []);
        assert!(image.iter().all(|v| v.is_finite()));
        let zero = Dense::zeros(Shape::square(2));
        let (x, report) = solve(
            &Gmres::default(),
            &zero,
            &Identity { n: 2 },
            &[1.0, 1.0],
            until(1e-8, 9),
        );
        assert!(matches!(report, Err(Breakdown::Stagnation { .. })));
        assert_eq!(x, [0.0, 0.0]);
    }
}
