//! `fracas solve`: one linear system, its cost, its true residual.

mod iteration;
mod matrix_free;
mod precision;
mod report;
mod stages;

use super::method::{Asked, Method};
use super::progress::Progress;
use super::source::{Source, System as Loaded};
use super::{Status, explain, memory, output, rank};
use clap::{Args, ValueEnum};
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{Assembled, Measure, Ready, SaddleMethod};
use fracas_solvers::spectrum::{Explanation, Solved};
use iteration::{Built, Names};
use precision::{Double, InDouble};
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
    /// Iteration: gmres, gmres:RESTART, fgmres, bicgstab, sqmr, minres, cg [default: gmres where its basis fits into memory,
    /// else what does].
    #[arg(long, value_name = "METHOD")]
    krylov: Option<KrylovChoice>,
    /// What the tolerance is for: the errors of u and t, each relative to the solution's in the norm of energy, or the residual
    /// relative to ‖b‖₂, as in published counts.
    #[arg(long, value_enum, default_value = "error")]
    measure: MeasureName,
    /// Relative to what --measure says.
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

/// `--measure`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MeasureName {
    Error,
    Residual,
}

impl From<MeasureName> for Measure {
    fn from(name: MeasureName) -> Self {
        match name {
            MeasureName::Error => Self::Error,
            MeasureName::Residual => Self::Residual,
        }
    }
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

/// What is to be said of the inner solver, and what takes its place where it cannot be set up.
struct Inner {
    findings: Vec<String>,
    /// In turn.
    otherwise: Vec<SaddleMethod>,
    /// Set-ups that failed.
    fallbacks: usize,
}

impl Inner {
    /// What takes the place of an inner solver whose set-up failed; it is told and counted.
    ///
    /// # Errors
    /// The failure, where nothing takes its place.
    fn instead(
        &mut self,
        failure: anyhow::Error,
        progress: &mut Progress,
    ) -> anyhow::Result<SaddleMethod> {
        if self.otherwise.is_empty() {
            return Err(failure);
        }
        let next = self.otherwise.remove(0);
        let name = next.inner().map(|inner| inner.to_string());
        let name = name.unwrap_or_default();
        let finding = format!("inner: {name} instead, because the set-up failed: {failure:#}");
        progress.say(&finding);
        self.findings.push(finding);
        self.fallbacks += 1;
        Ok(next)
    }
}

impl Solve {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let asked = match (self.source.scene(), self.explain) {
            (None, _) => Asked::Folder,
            (Some(_), true) => Asked::SceneWithEntries("--explain"),
            (Some(_), false) if self.source.is_grid()? => Asked::Scene,
            (Some(_), false) => Asked::SceneOfFile,
        };
        let chosen = self.method.route(asked)?;
        output::try_files(self.json.iter().chain(&self.solution))?;
        let mut progress = Progress::new();
        if let Some(reason) = &chosen.reason {
            progress.say(&format!("inner: {reason}"));
        }
        let inner = Inner {
            findings: chosen
                .reason
                .map(|reason| format!("inner: {reason}"))
                .into_iter()
                .collect(),
            otherwise: chosen.otherwise,
            fallbacks: 0,
        };
        self.by(chosen.method, inner, progress, out)
    }

    /// By this method: without an assembled A, or with one.
    fn by(
        &self,
        method: SaddleMethod,
        inner: Inner,
        progress: Progress,
        out: &mut dyn Write,
    ) -> anyhow::Result<Status> {
        match (method.matrix_free(), self.source.scene()) {
            (Some(racp), Some(scene)) => self.matrix_free(scene, racp, inner, progress, out),
            _ => self.assembled(method, inner, progress, out),
        }
    }

    /// From assembled blocks.
    fn assembled(
        &self,
        mut method: SaddleMethod,
        mut inner: Inner,
        mut progress: Progress,
        out: &mut dyn Write,
    ) -> anyhow::Result<Status> {
        let mut loaded = self.source.load(&mut progress)?;
        // a foreign system keeps its units, and its residual is measured in them
        let unit = self.traction_unit.unwrap_or(if loaded.is_ours {
            loaded.blocks.traction_unit()
        } else {
            1.0
        });
        loaded.blocks = loaded.blocks.into_traction_unit(unit);
        let Loaded {
            blocks,
            has_rhs,
            mut findings,
            body,
            ..
        } = loaded;
        let blocks = &blocks;
        let (rhs, b) = self.right_hand_side(has_rhs, blocks.rhs(), &mut progress);

        let start = Instant::now();
        progress.say("setting up");
        let (
            Ready {
                inverse: preconditioner,
                hierarchy,
                parts,
                relaxation,
            },
            lost,
        ) = loop {
            match precision::ready(&method, blocks) {
                Ok(ready) => break ready,
                Err(error) => {
                    let scene = self.source.scene();
                    let error = rank::blamed(error, scene, body.as_ref()).into();
                    method = inner.instead(error, &mut progress)?;
                    if method.matrix_free().is_some() {
                        return self.by(method, inner, progress, out);
                    }
                }
            }
        };
        let method = &method;
        findings.extend(inner.findings);
        let fallbacks = usize::from(lost.is_some());
        let in_f64 = lost.is_some();
        if let Some(lost) = lost {
            progress.say(&lost);
            findings.push(lost);
        }
        let strain = match &body {
            Some(body) => body.strain_norm()?,
            None => None,
        };
        let equations = Assembled::new(blocks, strain);
        let setup_s = start.elapsed().as_secs_f64();
        let explain = |solve_s: f64| -> anyhow::Result<Explanation> {
            Ok(Explanation::new(&Solved {
                blocks,
                method,
                preconditioner: &*preconditioner,
                hierarchy: hierarchy.as_ref(),
                parts,
                rhs: &b,
                setup_s,
                solve_s,
            })?)
        };
        self.iterate(
            &Built {
                equations: &equations,
                preconditioner: &*preconditioner,
                hierarchy: hierarchy.clone(),
                names: Names {
                    method: method.to_string(),
                    augmentation: method.augmentation().map(|c| c.to_string()),
                    inner: match in_f64 {
                        true => precision::name_in_double(method),
                        false => method.inner().map(|inner| inner.to_string()),
                    },
                    relaxation,
                },
                rhs,
                b: &b,
                unit,
                setup_s,
                findings,
                explain: self.explain.then_some(&explain),
                fallbacks,
                inner_fallbacks: inner.fallbacks,
                in_double: precision::in_double(method).map(|double| -> InDouble<'_> {
                    Box::new(move |_| {
                        let ready = double.ready(blocks)?;
                        Ok(Double {
                            preconditioner: ready.inverse,
                            hierarchy: ready.hierarchy,
                            inner: precision::name_in_double(&double).unwrap_or_default(),
                        })
                    })
                }),
                in_entries: None,
            },
            progress,
            out,
        )
    }

    /// The right-hand side that was asked for, `own` being that of the system.
    fn right_hand_side(
        &self,
        has_rhs: bool,
        own: Vec<f64>,
        progress: &mut Progress,
    ) -> (RightHandSide, Vec<f64>) {
        let chosen = self.rhs.unwrap_or(if has_rhs {
            RightHandSide::Folder
        } else {
            RightHandSide::Sin
        });
        if self.rhs.is_none() && !has_rhs {
            progress.say("the system has no right-hand side: taking b_i = sin(i), i = 1…n");
        }
        let n = own.len();
        let b = match chosen {
            RightHandSide::Folder => own,
            RightHandSide::Sin => (1..=n).map(|i| (i as f64).sin()).collect(),
            RightHandSide::Ones => vec![1.0; n],
        };
        (chosen, b)
    }
}
