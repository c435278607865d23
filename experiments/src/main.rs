//! The `fracas` command line. Everything it can do is in the library.

use clap::Parser;
use fracas_experiments::allocation::Noted;
use fracas_experiments::command::Arguments;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: Noted = Noted;

fn main() -> ExitCode {
    match Arguments::try_parse() {
        Ok(arguments) => fracas_experiments::command::main(&arguments),
        // the first of the ranks of mpirun says it
        Err(error) if is_another_rank() => ExitCode::from(error.exit_code() as u8),
        Err(error) => error.exit(),
    }
}

/// True for a rank of `mpirun` that is not the first, before MPI has begun.
fn is_another_rank() -> bool {
    let rank = ["OMPI_COMM_WORLD_RANK", "PMI_RANK"].map(std::env::var);
    cfg!(feature = "petsc") && rank.into_iter().flatten().any(|rank| rank != "0")
}
