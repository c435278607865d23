//! `fracas solve`: one linear system, its cost, its true residual.

use super::engine::{self, Engine};
use super::method::Method;
use super::progress::Progress;
use super::residuals::Residuals;
use super::source::Source;
use super::{Status, output, report};
use clap::{Args, ValueEnum};
use fracas::solve::{RightHandSide, Solve as Settings, Solved};
use fracas_operators::matrix_market::write_vector;
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{Measure, SaddleMethod};
use std::io::Write;
use std::path::PathBuf;

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
    /// Iterations over all restarts, of each inner solver.
    #[arg(long, value_name = "N", default_value_t = 1000)]
    max_iterations: usize,
    /// Unit of the tractions while iterating, so that the residual sees the contact rows; default: balanced for a scene
    /// and its export, and for a system folder of another code unless residuals are compared or beside flow; else 1.
    #[arg(long, value_name = "S", value_parser = unit)]
    traction_unit: Option<f64>,
    /// Right-hand side [default: that of the system, or b_i = sin(i), i = 1…n, when it has none].
    #[arg(long, value_enum)]
    rhs: Option<RhsName>,
    /// Who solves: this process, or all ranks of `mpirun -n N fracas solve … --engine petsc`, each with its rows of the system.
    #[arg(long, value_enum, default_value = "own")]
    engine: Engine,
    /// Says why it took what it took: eigenvalues seen, where the outliers live, C against H, time, one sentence of advice.
    #[arg(long)]
    explain: bool,
    /// Report as JSON; `-` writes it to standard output, in place of the lines.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Residuals of the iteration, `iteration,residual`: relative to b, as its recurrence estimates them.
    #[arg(long, value_name = "FILE.csv")]
    history: Option<PathBuf>,
    /// The solution (u, t, p) as a Matrix Market vector.
    #[arg(long, value_name = "FILE.mtx")]
    solution: Option<PathBuf>,
}

/// `--rhs`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RhsName {
    /// Of the system.
    Folder,
    /// `b_i = sin(i)`, i = 1…n.
    Sin,
    /// `b_i = 1`, tractions in the unit that balances the blocks.
    Ones,
}

impl From<RhsName> for RightHandSide {
    fn from(name: RhsName) -> Self {
        match name {
            RhsName::Folder => Self::System,
            RhsName::Sin => Self::Sin,
            RhsName::Ones => Self::Ones,
        }
    }
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

impl Solve {
    fn settings(&self) -> anyhow::Result<Settings> {
        let (method, inner) = self.method.fitted(SaddleMethod::default())?;
        Ok(Settings {
            method,
            inner,
            krylov: self.krylov,
            measure: self.measure.into(),
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            traction_unit: self.traction_unit,
            rhs: self.rhs.map(RightHandSide::from),
            explain: self.explain,
        })
    }

    /// True where ranks share the work.
    pub(super) fn is_over_ranks(&self) -> bool {
        self.engine == Engine::Petsc
    }

    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        if self.is_over_ranks() {
            return engine::solve(self, out);
        }
        let problem = self.source.problem()?;
        let settings = self.settings()?;
        // what is wrong with them is said before any file is tried
        settings.route(&problem)?;
        self.try_files()?;
        let mut progress = Progress::new();
        let mut residuals = Residuals::around(&mut progress);
        let solved = settings.solve(&problem, &mut residuals)?;
        let history = residuals.to_csv();
        drop(progress);
        self.write(&solved, &history, out)?;
        Ok(Self::status(&solved))
    }

    /// By all ranks together; the first one writes.
    #[cfg(feature = "petsc")]
    pub(super) fn over_ranks(
        &self,
        ranks: fracas_solvers::petsc::Ranks,
        out: &mut dyn Write,
    ) -> anyhow::Result<Status> {
        use crate::sentence;
        let is_first = ranks.is_first();
        let said = |error: anyhow::Error| sentence::of(&error);
        let asked = || {
            let asked = (self.source.problem()?, self.settings()?);
            if is_first {
                self.try_files()?;
            }
            anyhow::Ok(asked)
        };
        let (problem, settings) = ranks.agree(asked().map_err(said))?;
        let (mut progress, mut silent) = (is_first.then(Progress::new), fracas_solvers::Silent);
        let watching: &mut dyn fracas_solvers::Observer = match &mut progress {
            Some(progress) => progress,
            None => &mut silent,
        };
        let mut residuals = Residuals::around(watching);
        let solved = settings.solve_over(ranks, &problem, &mut residuals)?;
        let history = residuals.to_csv();
        drop(progress);
        let written = match is_first {
            true => self.write(&solved, &history, out),
            false => Ok(()),
        };
        ranks.agree(written.map_err(said))?;
        Ok(Self::status(&solved))
    }

    /// Tries the files that will be written.
    fn try_files(&self) -> anyhow::Result<()> {
        let files = self.json.iter().chain(&self.solution);
        output::try_files(files.chain(&self.history))
    }

    /// Writes what was asked for.
    fn write(&self, solved: &Solved, history: &str, out: &mut dyn Write) -> anyhow::Result<()> {
        if let Some(path) = &self.history {
            output::file(path, history)?;
        }
        if let Some(path) = &self.solution {
            write_vector(path, &solved.x)?;
        }
        if let Some(path) = &self.json {
            output::json(path, &self.source.origin().of(solved), out)?;
        }
        if !output::is_standard(&self.json) {
            report::print(solved, out)?;
        }
        Ok(())
    }

    fn status(solved: &Solved) -> Status {
        match solved.has_converged() {
            true => Status::Done,
            false => Status::NotConverged,
        }
    }
}
