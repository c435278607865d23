//! The commands of `fracas`: arguments, exit status, one sentence for each bad input.
//!
//! Results go to standard output or to files, progress to standard error. Exit status: 0 done, 2 bad input or not enough
//! memory, 3 not converged, 4 a check failed; 130 and 143: a run or a study that SIGINT or SIGTERM stopped, with its state written.
//! Every other command ends at once, by that signal.

mod beyond;
mod check;
mod compare;
mod engine;
mod explain;
mod export;
mod fault;
mod interrupt;
mod list;
mod manual;
mod method;
mod modes;
mod origin;
mod output;
mod page;
mod progress;
mod report;
mod reproduce;
mod residuals;
mod run;
mod scene;
mod schema;
mod schema_page;
mod show;
mod solve;
mod source;
mod spectrum;
mod study;

use crate::allocation::{exit_on_refusal, share_arena_below_limit};
use crate::sentence;
use clap::{Parser, Subcommand};
use fracas_operators::simd::Level;
use interrupt::Signal;
pub use page::{PageSteps, write as write_page};
pub use residuals::Residuals;
use std::io::{self, Write};
use std::process::ExitCode;

/// Saddle-point solvers for frictional contact on fractures in three-dimensional rock.
#[derive(Debug, Parser)]
#[command(name = "fracas", version, long_version = origin::long_version(), max_term_width = 110)]
pub struct Arguments {
    /// Threads; results do not depend on it [default: all cores; one on each rank of --engine petsc].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MAX_THREADS))]
    threads: Option<u16>,
    /// Instruction set, to see the digits of a machine without a better one [default: the best of this machine].
    #[arg(long, global = true, value_name = "SET", value_parser = instructions)]
    instructions: Option<Level>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Figures and tables beside the published numbers, in one report.html.
    Reproduce(reproduce::Reproduce),
    /// Runs a scene through its load steps: fields, history, checkpoints.
    Run(run::Run),
    /// Reads and audits a scene or a system folder without solving.
    Check(check::Check),
    /// Assembles a scene and writes it as a system folder.
    Export(export::Export),
    /// Eigenvalues of the preconditioned system and the bounds that hold for them.
    Spectrum(spectrum::Spectrum),
    /// Solves one linear system and reports its cost and true residual.
    Solve(solve::Solve),
    /// A study file: a product of scenes, meshes and methods, a row per solve, figures and a page.
    Study(study::Study),
    /// The same from the command line: scenes, meshes and methods, against each other.
    Compare(compare::Compare),
    /// Semi-analytic slip of a displaced fault, without a mesh.
    Fault(fault::Fault),
    /// Experiments and scenes, a line each: id, question, expected answer.
    List,
    /// Prints a scene of the gallery, as a beginning of one's own.
    Scene(show::Show),
    /// JSON Schema of the scene file.
    Schema(schema::Schema),
    /// Completions of a shell, on standard output.
    Completions(manual::Completions),
    /// Manual pages, a file per command.
    Manual(manual::Manual),
}

/// How a command ended, as its exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Status {
    /// 0.
    Done,
    /// 3.
    NotConverged,
    /// 4.
    CheckFailed,
    /// 128 and the signal.
    Interrupted(Signal),
}

/// Most threads that can be asked for: more only cost stacks.
const MAX_THREADS: i64 = 1024;

/// Exit status of bad input.
const BAD_INPUT: u8 = 2;

/// An instruction set of this machine by the first word of its name.
fn instructions(name: &str) -> Result<Level, String> {
    let word = |level: Level| level.name().split(' ').next().unwrap_or_default();
    Level::supported()
        .find(|level| word(*level) == name)
        .ok_or_else(|| {
            let names: Vec<&str> = Level::supported().map(word).collect();
            format!("this machine has {}", names.join(", "))
        })
}

/// Runs a command on a pool of its own and returns the exit status.
pub fn main(arguments: &Arguments) -> ExitCode {
    share_arena_below_limit();
    interrupt::warn(exit_on_refusal(BAD_INPUT.into()));
    if let Some(level) = arguments.instructions {
        assert!(
            level.prefer(),
            "instructions are in use before the arguments"
        );
    }
    let threads = arguments.threads.map(usize::from);
    let threads = threads.unwrap_or_else(|| arguments.command.threads());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let (status, sentence) = match pool {
        Ok(pool) => pool.install(|| outcome(arguments, &mut io::stdout())),
        Err(error) => (BAD_INPUT, Some(error.to_string())),
    };
    if let Some(sentence) = sentence {
        let _ = writeln!(io::stderr(), "error: {sentence}");
    }
    ExitCode::from(status)
}

/// Runs a command on the threads at hand: its exit status, and what is wrong with its input.
pub fn outcome(arguments: &Arguments, out: &mut dyn Write) -> (u8, Option<String>) {
    match arguments.command.run(out) {
        Ok(Status::Done) => (0, None),
        Ok(Status::NotConverged) => (3, None),
        Ok(Status::CheckFailed) => (4, None),
        Ok(Status::Interrupted(signal)) => (signal.status(), None),
        // The reader of our output left: nothing is wrong and nobody listens.
        Err(error) if is_broken_pipe(&error) => (0, None),
        Err(error) if error.is::<engine::SaidByFirst>() => (BAD_INPUT, None),
        Err(error) => (BAD_INPUT, Some(sentence::of(&error))),
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

impl Command {
    /// Threads where none are asked for: one on each rank, else 0 for all cores.
    fn threads(&self) -> usize {
        match self {
            Self::Solve(command) if command.is_over_ranks() => 1,
            _ => 0,
        }
    }

    fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        match self {
            Self::Reproduce(command) => command.run(out),
            Self::Run(command) => command.run(out),
            Self::Spectrum(command) => command.run(out),
            Self::Solve(command) => command.run(out),
            Self::Check(command) => command.run(out),
            Self::Export(command) => command.run(out),
            Self::Fault(command) => command.run(out),
            Self::Scene(command) => command.run(out),
            Self::Schema(command) => command.run(out),
            Self::Completions(command) => command.run(out),
            Self::Manual(command) => command.run(out),
            Self::Study(command) => command.run(out),
            Self::Compare(command) => command.run(out),
            Self::List => list::run(out),
        }
    }
}
