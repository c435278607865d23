//! How well a system was solved, and what that took.

use super::{Finding, RightHandSide};
use fracas_solvers::krylov::{Breakdown, KrylovChoice, Outcome, Report};
use fracas_solvers::multigrid::Summary;
use fracas_solvers::saddle::Measure;
use fracas_solvers::spectrum::Explanation;
use serde::{Serialize, Serializer};

/// How an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The tolerance is met.
    Converged,
    /// Not within the limit of iterations.
    IterationLimit,
    /// The observer wanted so.
    Stopped,
    /// Arithmetic gave up.
    Breakdown,
}

/// Ranks that solved a system together; lists have an entry for each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OverRanks {
    /// `petsc`.
    pub name: &'static str,
    /// How many.
    pub ranks: usize,
    /// Displacements of each.
    pub n_u: Vec<usize>,
    /// Entries of u of other ranks that each reads.
    pub ghosts: Vec<usize>,
    /// High-water mark of each [bytes]; 0 where the system does not tell.
    pub peak_memory_bytes: Vec<u64>,
    /// Wall time of mesh, fractures and partition, the same work on every rank [s].
    pub partition_s: f64,
    /// Wall time of assembling the rows of A [s].
    pub assembly_s: f64,
    /// What the parts of an iteration take, where an explanation was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<Times>,
}

/// Parts of an iteration over ranks, the quickest of some rounds of the slowest rank.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Times {
    /// A product with 𝒜 [s].
    pub product_s: f64,
    /// An M⁻¹ [s].
    pub application_s: f64,
    /// A sum over all ranks [s].
    pub sum_s: f64,
    /// A message of one number between the first two ranks [s]; 0 for one rank.
    pub message_s: f64,
    /// What a byte of a message of 1 MiB adds [s].
    pub per_byte_s: f64,
}

/// A system that was solved, or not; as JSON infinite or undefined numbers are null.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Solved {
    /// How it ended.
    pub outcome: End,
    /// n_it.
    pub iterations: usize,
    /// `‖b − 𝒜x‖₂ / ‖b‖₂`, recomputed at the end.
    pub relative_residual: Option<f64>,
    /// What the tolerance is for.
    pub measure: Measure,
    /// Error of u in the norm of energy, relative to u; of M⁻¹r, so that it is an estimate.
    pub error_u: Option<f64>,
    /// Error of t in the norm of C_0 + H, relative to t.
    pub error_t: Option<f64>,
    /// Error of p in the norm of `Q1ᵀ diag(A)⁻¹ Q1`, relative to p; none without flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_p: Option<f64>,
    /// Ritz value of 𝒜M⁻¹ nearest to zero.
    pub smallest_ritz: Option<f64>,
    /// `‖b − 𝒜x‖_∞ / (‖𝒜‖_∞ ‖x‖_∞ + ‖b‖_∞)`: 1e-16 means that f64 cannot do better.
    pub backward_error: Option<f64>,
    /// `‖r_t‖_∞ / ‖|B1|ᵀ|u| + |b_t|‖_∞`: what the norm over all rows hides where forces and jumps have distant units.
    pub contact_residual: Option<f64>,
    /// Name of the method that ran.
    pub method: String,
    /// C, where it has one.
    pub augmentation: Option<String>,
    /// Its inner solver, where it has one.
    pub inner: Option<String>,
    /// γ of the relaxation of H as applied; 0 = none.
    pub relaxation: f64,
    /// Degree of the relaxation in C⁻¹H; 0 = none.
    pub relaxation_degree: usize,
    /// The iteration that ran.
    #[serde(serialize_with = "name")]
    pub krylov: KrylovChoice,
    /// Which b.
    pub rhs: RightHandSide,
    /// As asked for.
    pub tolerance: f64,
    /// Tractions were counted in units of this while iterating (residuals too); the solution is in the units of the system.
    pub traction_unit: f64,
    /// Displacement unknowns.
    pub n_u: usize,
    /// Traction unknowns.
    pub n_t: usize,
    /// Pressure unknowns.
    pub n_p: usize,
    /// `flops(M⁻¹) / flops(𝒜)`.
    pub c_app: f64,
    /// `n_it (1 + c_app)`; none where it did not converge.
    #[serde(rename = "C_s")]
    pub c_s: Option<f64>,
    /// What both are, in one sentence.
    pub cost_convention: &'static str,
    /// Products with 𝒜; none after a breakdown.
    pub products: Option<u64>,
    /// Wall time of the set-up [s].
    pub setup_s: f64,
    /// Wall time of the iterations [s].
    pub solve_s: f64,
    /// High-water mark of the process [bytes], where the system tells.
    pub peak_memory_bytes: Option<u64>,
    /// Levels of multigrid.
    pub amg: Option<Summary>,
    /// The ranks that solved it together, where there were any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine: Option<OverRanks>,
    /// Why it did not converge, or what to mind where it did.
    pub reason: Option<String>,
    /// What is worth telling.
    pub findings: Vec<Finding>,
    /// Times that a preconditioner in f32 gave way to one in f64; why is among the findings.
    pub precision_fallbacks: usize,
    /// Times that an inner solver could not be set up, or got nowhere, and another took its place; why is among the findings.
    pub inner_fallbacks: usize,
    /// Where it was asked for.
    pub explain: Option<Explanation>,
    /// What arithmetic gave up for.
    #[serde(skip)]
    pub breakdown: Option<Breakdown>,
    /// u, t, p in the units of the system.
    #[serde(skip)]
    pub x: Vec<f64>,
}

fn name<S: Serializer>(krylov: &KrylovChoice, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(krylov)
}

/// A contact residual above this multiple of the tolerance means that the norm of b does not see the contact rows.
const UNSEEN: f64 = 100.0;

/// A backward error below this is rounding: a few hundred units in the last place.
const ROUNDING: f64 = 1e-13;

impl Solved {
    /// True where the tolerance is met.
    pub fn has_converged(&self) -> bool {
        self.outcome == End::Converged
    }

    /// u.
    pub fn displacements(&self) -> &[f64] {
        &self.x[..self.n_u]
    }

    /// t, in the unit of the system.
    pub fn tractions(&self) -> &[f64] {
        &self.x[self.n_u..self.n_u + self.n_t]
    }

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
                    Outcome::Converged => End::Converged,
                    Outcome::IterationLimit => End::IterationLimit,
                    Outcome::Stopped => End::Stopped,
                };
                self.iterations = before + report.iterations;
                self.products = products.map(|before| before + report.products);
                self.c_s = self.has_converged().then(|| c_s(self.iterations));
                self.reason = self
                    .contact_residual
                    .filter(|_| self.measure == Measure::Residual)
                    .filter(|r| self.c_s.is_some() && *r > UNSEEN * self.tolerance)
                    .map(|r| {
                        format!(
                            "converged in the norm of b, where forces hide the jumps: the contact rows hold to {r:.1e} of \
                             the jumps only; lower the tolerance by that ratio or take method = \"direct\""
                        )
                    });
            }
            Err(breakdown) => {
                self.iterations = before + breakdown.iteration();
                self.breakdown = Some(*breakdown);
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
}
