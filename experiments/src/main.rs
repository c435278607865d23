//! The `fracas` command line. Everything it can do is in the library.

use clap::Parser;
use fracas_experiments::command::Arguments;
use std::process::ExitCode;

fn main() -> ExitCode {
    fracas_experiments::command::main(&Arguments::parse())
}
