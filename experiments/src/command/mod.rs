//! The commands of `fracas`: arguments, exit status, one sentence for each bad input.
//!
//! Results go to standard output or to files, progress to standard error. Exit status: 0 done, 2 bad input, 3 not
//! converged, 4 a check failed.

mod check;
mod explain;
mod export;
mod list;
pub(crate) mod memory;
mod method;
mod modes;
mod output;
mod progress;
mod rank;
mod reproduce;
mod run;
mod scene;
mod schema;
mod sentence;
mod solve;
mod source;
mod spectrum;

use clap::{Parser, Subcommand};
use std::io::{self, Write};
use std::process::ExitCode;

/// Saddle-point solvers for frictional contact on fractures in three-dimensional rock.
#[derive(Debug, Parser)]
#[command(name = "fracas", version, max_term_width = 110)]
pub struct Arguments {
    /// Threads; results do not depend on it [default: all cores].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=MAX_THREADS))]
    threads: Option<u16>,
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
    /// Experiments and scenes, a line each: id, question, expected answer.
    List,
    /// JSON Schema of the scene file.
    Schema,
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
}

/// Most threads that can be asked for: more only cost stacks.
const MAX_THREADS: i64 = 1024;

/// Exit status of bad input.
const BAD_INPUT: u8 = 2;

/// Runs a command on a pool of its own and returns the exit status.
pub fn main(arguments: &Arguments) -> ExitCode {
    let threads = arguments.threads.map_or(0, usize::from);
    let result = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(anyhow::Error::from)
        .and_then(|pool| pool.install(|| arguments.command.run(&mut io::stdout())));
    match result {
        Ok(Status::Done) => ExitCode::SUCCESS,
        Ok(Status::NotConverged) => ExitCode::from(3),
        Ok(Status::CheckFailed) => ExitCode::from(4),
        // The reader of our output left: nothing is wrong and nobody listens.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            let _ = writeln!(io::stderr(), "error: {}", sentence::of(&error));
            ExitCode::from(BAD_INPUT)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<io::Error>()
        .is_some_and(|e| e.kind() == io::ErrorKind::BrokenPipe)
}

impl Command {
    fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        match self {
            Self::Reproduce(command) => command.run(out),
            Self::Run(command) => command.run(out),
            Self::Spectrum(command) => command.run(out),
            Self::Solve(command) => command.run(out),
            Self::Check(command) => command.run(out),
            Self::Export(command) => command.run(out),
            Self::Schema => schema::run(out),
            Self::List => list::run(out),
        }
    }
}
