//! The `fracas` command line. Everything it can do is in the library.

use clap::Parser;
use fracas_experiments::allocation::Noted;
use fracas_experiments::command::Arguments;
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: Noted = Noted;

fn main() -> ExitCode {
    fracas_experiments::command::main(&Arguments::parse())
}
