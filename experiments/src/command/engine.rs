//! `--engine`: one process, or the ranks of `mpirun` together.

use super::Status;
use super::solve::Solve;
use clap::ValueEnum;
use std::io::Write;

/// Who solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Engine {
    /// This process, on all threads.
    Own,
    /// The ranks of `mpirun` together, with the system's PETSc.
    Petsc,
}

/// What went wrong is said by the first rank.
#[derive(Debug, thiserror::Error)]
#[error("the first rank says what is wrong")]
pub(super) struct SaidByFirst;

/// Solves over ranks.
#[cfg(feature = "petsc")]
pub(super) fn solve(command: &Solve, out: &mut dyn Write) -> anyhow::Result<Status> {
    let ranks = fracas_solvers::petsc::Ranks::begin()?;
    let result = command.over_ranks(ranks, out);
    ranks.leave();
    result.map_err(|error| match ranks.is_first() {
        true => error,
        false => SaidByFirst.into(),
    })
}

/// Solves over ranks, in another build.
#[cfg(not(feature = "petsc"))]
pub(super) fn solve(_: &Solve, _: &mut dyn Write) -> anyhow::Result<Status> {
    anyhow::bail!(
        "--engine petsc is not part of this build: compile with --features petsc, which needs MPI and PETSc, or leave --engine out"
    )
}
