//! `fracas solve`: one linear system, its cost, its true residual.

use super::method::Method;
use super::progress::Progress;
use super::source::{Source, System as Loaded};
use super::{Status, explain, memory, output};
use clap::{Args, ValueEnum};
use fracas_operators::matrix_market::write_vector;
use fracas_operators::{LinearOperator, vector};
use fracas_solvers::Observer;
use fracas_solvers::amg::Summary;
use fracas_solvers::krylov::{Breakdown, Criteria, KrylovChoice, Outcome, Report, System};
use fracas_solvers::saddle::{Cost, Ready, SaddleBlocks, SaddleOperator};
use fracas_solvers::spectrum::{Explanation, Solved};
use serde::Serialize;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

#[derive(Args, Debug)]
pub(super) struct Solve {
    #[command(flatten)]
    source: Source,
    #[command(flatten)]
    method: Method,
    /// Iteration: gmres, gmres:RESTART, fgmres, bicgstab, sqmr, minres, cg.
    #[arg(long, value_name = "METHOD", default_value_t)]
    krylov: KrylovChoice,
    /// Relative to the norm of the right-hand side.
    #[arg(long, value_name = "TOL", default_value = "1e-8", allow_negative_numbers = true, value_parser = tolerance)]
    tolerance: f64,
    /// Iterations over all restarts.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    max_iterations: usize,
    /// Unit of the tractions while iterating, so that the residual sees the contact rows; default: balanced for a scene
    /// and its export, 1 for a system folder of another code.
    #[arg(long, value_name = "S", value_parser = unit)]
    traction_unit: Option<f64>,
    /// Right-hand side [default: that of the system, or b_i = sin(i), i = 1…n, when it has none].
    #[arg(long, value_enum)]
    rhs: Option<RightHandSide>,
    /// Says why it took what it took: eigenvalues seen, where the outliers live, C against H, time, one sentence of advice.
    #[arg(long)]
    explain: bool,
    /// Report as JSON; `-` writes it to standard output.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// The solution (u, t, p) as a Matrix Market vector.
    #[arg(long, value_name = "FILE.mtx")]
    solution: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
enum RightHandSide {
    /// Of the system.
    #[serde(rename = "folder")]
    Folder,
    /// `b_i = sin(i)`, i = 1…n.
    #[serde(rename = "sin(i)")]
    Sin,
    /// `b_i = 1`.
    #[serde(rename = "ones")]
    Ones,
}

/// A positive factor.
fn unit(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && f64::is_finite(value) => Ok(value),
        _ => Err("the unit is a positive number".into()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("the tolerance is a number between 0 and 1".into()),
    }
}

/// Keys of the JSON report; infinite or undefined = null.
#[derive(Serialize)]
struct SolveReport {
    outcome: &'static str,
    iterations: usize,
    relative_residual: Option<f64>,
    /// `‖b − 𝒜x‖_∞ / (‖𝒜‖_∞ ‖x‖_∞ + ‖b‖_∞)`: 1e-16 means that f64 cannot do better.
    backward_error: Option<f64>,
    /// `‖r_t‖_∞ / ‖|B1|ᵀ|u| + |b_t|‖_∞`: what the norm over all rows hides where forces and jumps have distant units.
    contact_residual: Option<f64>,
    method: String,
    augmentation: Option<String>,
    inner: Option<String>,
    krylov: String,
    rhs: RightHandSide,
    tolerance: f64,
    /// Tractions were counted in units of this while iterating (residuals too); the solution is in the units of the system.
    traction_unit: f64,
    n_u: usize,
    n_t: usize,
    n_p: usize,
    c_app: f64,
    #[serde(rename = "C_s")]
    c_s: Option<f64>,
    cost_convention: &'static str,
    products: Option<u64>,
    setup_s: f64,
    solve_s: f64,
    peak_memory_bytes: Option<u64>,
    amg: Option<Summary>,
    reason: Option<String>,
    findings: Vec<String>,
    /// Null unless asked for.
    explain: Option<Explanation>,
}

impl Solve {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let method = self.method.chosen()?;
        output::try_files(self.json.iter().chain(&self.solution))?;
        let mut progress = Progress::new();
        let mut loaded = self.source.load(&mut progress)?;
        // a foreign system keeps its units, and its residual is measured in them
        let unit = self.traction_unit.unwrap_or(if loaded.is_ours {
            loaded.blocks.traction_unit()
        } else {
            1.0
        });
        loaded.blocks = loaded.blocks.into_traction_unit(unit);
        let blocks = &loaded.blocks;
        let (rhs, b) = self.right_hand_side(&loaded, blocks, &mut progress);

        let start = Instant::now();
        progress.say("setting up");
        let Ready {
            inverse: preconditioner,
            hierarchy,
            parts,
        } = method.ready(blocks)?;
        let operator = SaddleOperator::new(blocks);
        let setup_s = start.elapsed().as_secs_f64();

        let start = Instant::now();
        progress.say("iterating");
        let krylov = self.krylov.flexible_for(&*preconditioner);
        let system = System {
            operator: &operator,
            preconditioner: &*preconditioner,
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: self.tolerance,
            max_iterations: self.max_iterations,
        };
        let mut x = vec![0.0; b.len()];
        let result = krylov.method().solve(
            &system,
            &criteria,
            &mut x,
            &mut progress as &mut dyn Observer,
        );
        let solve_s = start.elapsed().as_secs_f64();
        let explanation = if self.explain {
            progress.say("explaining");
            Some(Explanation::new(&Solved {
                blocks,
                method: &method,
                preconditioner: &*preconditioner,
                hierarchy: hierarchy.as_ref(),
                parts,
                rhs: &b,
                setup_s,
                solve_s,
            })?)
        } else {
            None
        };
        drop(progress);

        let cost = Cost::new(&operator, &*preconditioner);
        let residual = Residual::new(&operator, blocks, &x, &b);
        let mut report = SolveReport {
            outcome: "breakdown",
            iterations: 0,
            relative_residual: residual.relative,
            backward_error: residual.backward,
            contact_residual: residual.contact,
            method: method.to_string(),
            augmentation: method.augmentation().map(|c| c.to_string()),
            inner: method.inner().map(|inner| inner.to_string()),
            krylov: krylov.to_string(),
            rhs,
            tolerance: self.tolerance,
            traction_unit: unit,
            n_u: blocks.n_u(),
            n_t: blocks.n_t(),
            n_p: blocks.n_p(),
            c_app: cost.c_app(),
            c_s: None,
            cost_convention: Cost::CONVENTION,
            products: None,
            setup_s,
            solve_s,
            peak_memory_bytes: memory::peak_bytes(),
            amg: hierarchy,
            reason: None,
            findings: loaded.findings,
            explain: explanation,
        };
        report.record(&result, |iterations| cost.c_s(iterations, &krylov));
        if let Some(path) = &self.solution {
            let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
            x[n_u..n_u + n_t].iter_mut().for_each(|t| *t *= unit);
            write_vector(path, &x)?;
        }
        match &self.json {
            Some(path) => output::json(path, &report, out)?,
            None => report.print(out)?,
        }
        Ok(if report.outcome == "converged" {
            Status::Done
        } else {
            Status::NotConverged
        })
    }

    fn right_hand_side(
        &self,
        loaded: &Loaded,
        blocks: &SaddleBlocks,
        progress: &mut Progress,
    ) -> (RightHandSide, Vec<f64>) {
        let chosen = self.rhs.unwrap_or(if loaded.has_rhs {
            RightHandSide::Folder
        } else {
            RightHandSide::Sin
        });
        if self.rhs.is_none() && !loaded.has_rhs {
            progress.say("the system has no right-hand side: taking b_i = sin(i), i = 1…n");
        }
        let n = blocks.size();
        let b = match chosen {
            RightHandSide::Folder => blocks.rhs(),
            RightHandSide::Sin => (1..=n).map(|i| (i as f64).sin()).collect(),
            RightHandSide::Ones => vec![1.0; n],
        };
        (chosen, b)
    }
}

/// The true residual, recomputed; `None` where it is not a number.
struct Residual {
    /// `‖b − 𝒜x‖₂ / ‖b‖₂`; 0 for b = 0.
    relative: Option<f64>,
    /// `‖b − 𝒜x‖_∞ / (‖𝒜‖_∞ ‖x‖_∞ + ‖b‖_∞)`.
    backward: Option<f64>,
    /// `‖r_t‖_∞ / ‖|B1|ᵀ|u| + |b_t|‖_∞`.
    contact: Option<f64>,
}

impl Residual {
    fn new(
        operator: &dyn LinearOperator<f64>,
        blocks: &SaddleBlocks,
        x: &[f64],
        b: &[f64],
    ) -> Self {
        let mut r = b.to_vec();
        operator.apply_add(-1.0, x, &mut r, &mut vec![0.0; operator.work_len()]);
        let over = |r: f64, scale: f64| if r == 0.0 { 0.0 } else { r / scale };
        let number = |v: f64| v.is_finite().then_some(v);
        let n_u = blocks.n_u();
        let mut jumps: Vec<f64> = blocks.rhs_t.iter().map(|b| b.abs()).collect();
        for (row, u) in blocks.b1.outer_iterator().zip(&x[..n_u]) {
            row.iter().for_each(|(j, b)| jumps[j] += (b * u).abs());
        }
        let scale = blocks.norm_inf() * vector::norm_inf(x) + vector::norm_inf(b);
        Self {
            relative: number(over(vector::norm2(&r), vector::norm2(b))),
            backward: number(over(vector::norm_inf(&r), scale)),
            contact: number(over(
                vector::norm_inf(&r[n_u..n_u + blocks.n_t()]),
                vector::norm_inf(&jumps),
            )),
        }
    }
}

/// A contact residual above this multiple of the tolerance means that the norm of b does not see the contact rows.
const UNSEEN: f64 = 100.0;

/// A backward error below this is rounding: a few hundred units in the last place.
const ROUNDING: f64 = 1e-13;

impl SolveReport {
    fn record(&mut self, result: &Result<Report, Breakdown>, c_s: impl Fn(usize) -> f64) {
        match result {
            Ok(report) => {
                self.outcome = match report.outcome {
                    Outcome::Converged => "converged",
                    Outcome::IterationLimit => "iteration_limit",
                    Outcome::Stopped => "stopped",
                };
                self.iterations = report.iterations;
                self.products = Some(report.products);
                self.c_s = (report.outcome == Outcome::Converged).then(|| c_s(report.iterations));
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
                self.iterations = breakdown.iteration();
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

    fn print(&self, out: &mut dyn Write) -> anyhow::Result<()> {
        let optional =
            |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
        let mut rows = vec![
            ("outcome", self.outcome.to_owned()),
            ("n_it", self.iterations.to_string()),
            (
                "relative residual",
                self.relative_residual
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
        if let Some(reason) = &self.reason {
            rows.push(("reason", reason.clone()));
        }
        if let Some(facts) = &self.explain {
            rows.extend(explain::rows(facts));
        }
        output::pairs(out, &rows)
    }
}
