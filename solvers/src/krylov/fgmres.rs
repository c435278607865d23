//! Flexible GMRES(m).

use super::arnoldi::Arnoldi;
use super::gmres::{RESTART, steps};
use super::run::{End, Run, drive, work_len};
use super::{Breakdown, Criteria, KrylovMethod, Report, System, Watch};
use fracas_operators::Real;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;

/// GMRES for a preconditioner that changes: `x_k = x_0 + Z_k y` with `z_j = M_j⁻¹ v_j` kept and
/// `y = argmin ‖r_0 − A Z_k y‖₂`.
///
/// # Cost
/// As [`Gmres`](super::Gmres) with `2 restart + 2` vectors and no preconditioner solve at the end of a cycle.
///
/// # Source
/// Saad (1993).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fgmres {
    /// Steps before the bases are thrown away.
    pub restart: NonZeroUsize,
}

impl Default for Fgmres {
    fn default() -> Self {
        Self { restart: RESTART }
    }
}

impl<R: Real> KrylovMethod<R> for Fgmres {
    fn name(&self) -> &'static str {
        "fgmres"
    }

    fn work_len(&self, system: &System<R>, criteria: &Criteria) -> usize {
        let m = steps(self.restart, system, criteria);
        work_len(system, m) + Arnoldi::<R>::work_len(system.size(), m)
    }

    fn solve_in(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
        work: &mut [R],
    ) -> Result<Report, Breakdown> {
        let m = steps(self.restart, system, criteria);
        let cycle =
            |run: &mut Run<R>, x: &mut [R], r: &mut [R], work: &mut [R]| cycle(m, run, x, r, work);
        drive("fgmres", system, criteria, x, watch, work, cycle)
    }
}

/// At most `m` steps from `r = b − A x`.
fn cycle<R: Real>(
    m: usize,
    run: &mut Run<R>,
    x: &mut [R],
    r: &[R],
    work: &mut [R],
) -> Result<End, Breakdown> {
    let n = x.len();
    let (z, work) = work.split_at_mut(m * n);
    let mut arnoldi = Arnoldi::new(r, run.start(), m, work);
    loop {
        // z_k = M_k⁻¹ v_k,  w = A z_k
        let z_k = &mut z[arnoldi.size() * n..][..n];
        let (v, w) = arnoldi.next();
        run.solve(v, z_k);
        run.product(z_k, w);
        let grown = arnoldi.grow(&|sums| run.sum_over_parts(sums));
        let last = arnoldi.last(&grown);
        if let Some(end) = run.step(grown.residual)?.or(last) {
            run.ritz(arnoldi.ritz_nearest_to_zero());
            // x ← x + Z y
            arnoldi.combine_onto(z, x);
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
    use super::super::{Gmres, KrylovChoice};
    use super::*;
    use fracas_operators::laws::probe;
    use fracas_operators::{Identity, Preconditioner, Properties};
    use std::sync::atomic::{AtomicU64, Ordering};

    /// Divides by 1, 2, 3, 1, … from call to call.
    struct Moody {
        n: usize,
        calls: AtomicU64,
    }

    impl Preconditioner<f64> for Moody {
        fn size(&self) -> usize {
            self.n
        }
        fn solve(&self, r: &[f64], z: &mut [f64], _work: &mut [f64]) {
            let call = self.calls.fetch_add(1, Ordering::Relaxed);
            for (i, (z, r)) in z.iter_mut().zip(r).enumerate() {
                *z = r / (1.0 + ((call + i as u64) % 3) as f64);
            }
        }
        fn flops(&self) -> u64 {
            self.n as u64
        }
        fn properties(&self) -> Properties {
            Properties::NONLINEAR
        }
    }

    #[test]
    fn with_a_fixed_preconditioner_it_is_gmres() {
        let (n, b) = (40, probe(40, 1));
        let (a, m) = (unsymmetric(n, 2), Explicit(spd(n, 3)));
        let restart = Gmres::restarted(7).restart;
        let (x, report) = solve(&Fgmres { restart }, &a, &m, &b, until(1e-10, 300));
        let (y, other) = solve(&Gmres { restart }, &a, &m, &b, until(1e-10, 300));
        assert_eq!(report.unwrap().iterations, other.unwrap().iterations);
        assert!(deviation(&x, &y) < 1e-9);
        assert!(deviation(&x, &direct(&a, &b)) < 1e-8);
    }

    #[test]
    fn takes_a_preconditioner_that_changes_and_gmres_refuses_it() {
        let (n, b) = (40, probe(40, 1));
        let a = unsymmetric(n, 2);
        let moody = Moody {
            n,
            calls: AtomicU64::new(0),
        };
        let (x, report) = solve(&Fgmres::default(), &a, &moody, &b, until(1e-11, n + 1));
        assert!(report.unwrap().relative_residual <= 1e-11);
        assert!(deviation(&x, &direct(&a, &b)) < 1e-9);
        let (_, report) = solve(&Gmres::default(), &a, &moody, &b, until(1e-11, n));
        assert!(matches!(
            report,
            Err(Breakdown::NonlinearPreconditioner { .. })
        ));
        let choice = KrylovChoice::default();
        assert_eq!(
            choice
                .flexible_for(&moody as &dyn Preconditioner<f64>)
                .name(),
            "fgmres"
        );
        assert_eq!(
            choice.flexible_for(&Identity { n } as &dyn Preconditioner<f64>),
            choice
        );
    }
}
