//! Stabilized bi-conjugate gradients.

use super::run::{End, Run, carve, drive, require_linear, work_len};
use super::{Breakdown, Criteria, KrylovMethod, Report, System, Watch};
use fracas_operators::Real;
use fracas_operators::vector::{axpy, copy, xpby};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// BiCGStab, right-preconditioned: the residual of BiCG times `Π (1 − ω_k A M⁻¹)`, each ω minimising its residual.
///
/// Short recurrences for unsymmetric A; nothing is minimised over the whole space.
///
/// # Cost
/// **Two** products, two preconditioner solves and `24 n` flops per iteration; eight vectors. An iteration may end
/// after its first half.
///
/// # Errors
/// [`Breakdown::Lanczos`] when `r̂ᵀr`, `r̂ᵀA M⁻¹p` or `tᵀs` vanishes.
///
/// # Source
/// van der Vorst (1992).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bicgstab {}

impl<R: Real> KrylovMethod<R> for Bicgstab {
    fn name(&self) -> &'static str {
        "bicgstab"
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
        require_linear("bicgstab", system)?;
        drive("bicgstab", system, criteria, x, watch, work, cycle)
    }
}

fn cycle<R: Real>(
    run: &mut Run<R>,
    x: &mut [R],
    r: &mut [R],
    mut work: &mut [R],
) -> Result<End, Breakdown> {
    let n = x.len();
    let [shadow, p, p_hat, v, s_hat, t] = [0; 6].map(|_| carve(&mut work, n));
    let epsilon = R::epsilon();
    copy(r, shadow);
    copy(r, p);
    let norm_shadow = run.start();
    let mut rho = norm_shadow * norm_shadow;
    loop {
        // α = ρ / r̂ᵀA M⁻¹p,  s = r − α v
        run.solve(p, p_hat);
        run.product(p_hat, v);
        let sigma = run.finite(run.dot(shadow, v))?;
        if sigma.abs() <= epsilon * norm_shadow * run.norm2(v) {
            return run.lanczos("r̂ᵀA M⁻¹p");
        }
        let alpha = rho / sigma;
        axpy(alpha, p_hat, x);
        axpy(-alpha, v, r);
        let norm_s = run.finite(run.norm2(r))?;
        // where a judge lets half an iteration go on, the whole one is counted already
        let is_counted = run.is_small(norm_s);
        if is_counted {
            let end = run.step(norm_s)?.unwrap_or(End::Believed);
            if run.ends(end, x) {
                return Ok(end);
            }
        }
        // ω = tᵀs / tᵀt with t = A M⁻¹s,  r = s − ω t
        run.solve(r, s_hat);
        run.product(s_hat, t);
        let (ts, tt) = (run.finite(run.dot(t, r))?, run.finite(run.dot(t, t))?);
        if ts.abs() <= epsilon * norm_s * tt.sqrt() {
            return match run.step(norm_s)? {
                Some(end) => Ok(end),
                None => run.lanczos("tᵀs"),
            };
        }
        let omega = ts / tt;
        axpy(omega, s_hat, x);
        axpy(-omega, t, r);
        let norm_r = run.norm2(r);
        if !is_counted
            && let Some(end) = run.step(norm_r)?
            && run.ends(end, x)
        {
            return Ok(end);
        }
        // β = (ρ/ρ_before)(α/ω),  p ← r + β (p − ω v)
        let next = run.finite(run.dot(shadow, r))?;
        if next.abs() <= epsilon * norm_shadow * norm_r {
            return run.lanczos("r̂ᵀr");
        }
        axpy(-omega, v, p);
        xpby(r, (next / rho) * (alpha / omega), p);
        rho = next;
    }
}

#[cfg(test)]
mod tests {
    use super::super::oracle::*;
    use super::*;
    use fracas_operators::Identity;
    use fracas_operators::laws::probe;

    #[test]
    fn reaches_the_direct_solution() {
        for n in [1, 2, 17, 60] {
            let (a, b) = (unsymmetric(n, n as u64), probe(n, 5));
            let (x, report) = solve(
                &Bicgstab {},
                &a,
                &Identity { n },
                &b,
                until(1e-11, 2 * n + 5),
            );
            assert!(report.unwrap().relative_residual <= 1e-11);
            assert!(deviation(&x, &direct(&a, &b)) < 1e-9);
        }
    }

    #[test]
    fn an_iteration_costs_two_products() {
        let (n, k) = (60, 5);
        let (a, b) = (unsymmetric(n, 3), probe(n, 5));
        let (_, report) = solve(&Bicgstab {}, &a, &Identity { n }, &b, until(0.0, k));
        let report = report.unwrap();
        assert_eq!(report.iterations, k);
        // and one for the true residual at exit
        assert_eq!(report.products, 2 * k as u64 + 1);
        assert_eq!(report.preconditioner_solves, 2 * k as u64);
    }
}
