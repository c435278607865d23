//! The report: keys of its JSON, lines for people.

use super::{RightHandSide, explain, output};
use crate::report::format_real;
use fracas_solvers::krylov::{Breakdown, Outcome, Report};
use fracas_solvers::multigrid::Summary;
use fracas_solvers::saddle::Measure;
use fracas_solvers::spectrum::Explanation;
use serde::Serialize;
use std::io::Write;

/// Keys of the JSON report; infinite or undefined = null.
#[derive(Serialize)]
pub(super) struct SolveReport {
    pub(super) outcome: &'static str,
    pub(super) iterations: usize,
    pub(super) relative_residual: Option<f64>,
    /// What the tolerance is for.
    pub(super) measure: Measure,
    /// Error of u in the norm of energy, relative to u; of M⁻¹r, so that it is an estimate.
    pub(super) error_u: Option<f64>,
    /// Error of t in the norm of C_0 + H, relative to t.
    pub(super) error_t: Option<f64>,
    /// Ritz value of 𝒜M⁻¹ nearest to zero.
    pub(super) smallest_ritz: Option<f64>,
    /// `‖b − 𝒜x‖_∞ / (‖𝒜‖_∞ ‖x‖_∞ + ‖b‖_∞)`: 1e-16 means that f64 cannot do better.
    pub(super) backward_error: Option<f64>,
    /// `‖r_t‖_∞ / ‖|B1|ᵀ|u| + |b_t|‖_∞`: what the norm over all rows hides where forces and jumps have distant units.
    pub(super) contact_residual: Option<f64>,
    pub(super) method: String,
    pub(super) augmentation: Option<String>,
    pub(super) inner: Option<String>,
    /// γ of the relaxation of H as applied; 0 = none.
    pub(super) relaxation: f64,
    /// Degree of the relaxation in C⁻¹H; 0 = none.
    pub(super) relaxation_degree: usize,
    pub(super) krylov: String,
    pub(super) rhs: RightHandSide,
    pub(super) tolerance: f64,
    /// Tractions were counted in units of this while iterating (residuals too); the solution is in the units of the system.
    pub(super) traction_unit: f64,
    pub(super) n_u: usize,
    pub(super) n_t: usize,
    pub(super) n_p: usize,
    pub(super) c_app: f64,
    #[serde(rename = "C_s")]
    pub(super) c_s: Option<f64>,
    pub(super) cost_convention: &'static str,
    pub(super) products: Option<u64>,
    pub(super) setup_s: f64,
    pub(super) solve_s: f64,
    pub(super) peak_memory_bytes: Option<u64>,
    pub(super) amg: Option<Summary>,
    pub(super) reason: Option<String>,
    pub(super) findings: Vec<String>,
    /// Times that a preconditioner in f32 gave way to one in f64; why is among the findings.
    pub(super) precision_fallbacks: usize,
    /// Times that an inner solver could not be set up and another took its place; why is among the findings.
    pub(super) inner_fallbacks: usize,
    /// Null unless asked for.
    pub(super) explain: Option<Explanation>,
}

/// A contact residual above this multiple of the tolerance means that the norm of b does not see the contact rows.
const UNSEEN: f64 = 100.0;

/// A backward error below this is rounding: a few hundred units in the last place.
const ROUNDING: f64 = 1e-13;

impl SolveReport {
    /// How the iteration ended, after iterations and products around another preconditioner (products are not known of one that broke down).
    pub(super) fn record(
        &mut self,
        result: &Result<Report, Breakdown>,
        (before, products): (usize, Option<u64>),
        c_s: impl Fn(usize) -> f64,
    ) {
        match result {
            Ok(report) => {
                self.outcome = match report.outcome {
                    Outcome::Converged => "converged",
                    Outcome::IterationLimit => "iteration_limit",
                    Outcome::Stopped => "stopped",
                };
                self.iterations = before + report.iterations;
                self.products = products.map(|before| before + report.products);
                self.c_s = (report.outcome == Outcome::Converged).then(|| c_s(self.iterations));
                self.reason = self
                    .contact_residual
                    .filter(|r| self.c_s.is_some() && *r > UNSEEN * self.tolerance)
                    .map(|r| {
                        format!(
                            "converged in the norm of b, where forces hide the jumps: the contact rows hold to {r:.1e} of \
                             the jumps only; lower --tolerance by that ratio or take --method direct"
                        )
                    });
            }
            Err(breakdown) => {
                self.iterations = before + breakdown.iteration();
                let rounding = self.backward_error.is_some_and(|e| e < ROUNDING);
                self.reason = Some(match breakdown {
                    Breakdown::Stagnation { .. } if rounding => format!(
                        "{breakdown}. The backward error is at rounding: b asks for more digits than f64 holds in these units; \
                         scale the system or raise the tolerance"
                    ),
                    _ => breakdown.to_string(),
                });
            }
        }
    }

    /// The method and its parts.
    fn parts(&self) -> String {
        let mut parts = self.method.clone();
        if let Some(c) = &self.augmentation {
            parts += &format!(", C = {c}");
        }
        if self.relaxation > 0.0 {
            parts += &format!(", γ = {}", format_real(self.relaxation));
        }
        if self.relaxation_degree > 1 {
            parts += &format!(", degree {}", self.relaxation_degree);
        }
        if let Some(inner) = &self.inner {
            parts += &format!(", inner {inner}");
        }
        parts
    }

    pub(super) fn print(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let optional =
            |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
        let mut rows = vec![
            ("outcome", self.outcome.to_owned()),
            ("method", self.parts()),
            ("krylov", self.krylov.clone()),
            ("n_it", self.iterations.to_string()),
            (
                "relative residual",
                self.relative_residual
                    .map_or_else(|| "–".to_owned(), |r| format!("{r:.3e}")),
            ),
            (
                "error of u",
                self.error_u
                    .map_or_else(|| "–".to_owned(), |r| format!("{r:.3e}")),
            ),
            (
                "error of t",
                self.error_t
                    .map_or_else(|| "–".to_owned(), |r| format!("{r:.3e}")),
            ),
            (
                "backward error",
                self.backward_error
                    .map_or_else(|| "–".to_owned(), |r| format!("{r:.3e}")),
            ),
            (
                "contact residual",
                self.contact_residual
                    .map_or_else(|| "–".to_owned(), |r| format!("{r:.3e}")),
            ),
            ("c_app", format!("{:.2}", self.c_app)),
            ("C_s", optional(self.c_s)),
            ("set-up", format!("{:.2} s", self.setup_s)),
            ("solve", format!("{:.2} s", self.solve_s)),
        ];
        if let Some(amg) = &self.amg {
            rows.push(("multigrid", amg.smoothing.to_string()));
        }
        if let Some(bytes) = self.peak_memory_bytes {
            rows.push((
                "peak memory",
                format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20)),
            ));
        }
        rows.extend(self.findings.iter().map(|f| ("note", f.clone())));
        if let Some(reason) = &self.reason {
            rows.push(("reason", reason.clone()));
        }
        if let Some(facts) = &self.explain {
            rows.extend(explain::rows(facts));
        }
        output::pairs(out, &rows)
    }
}
