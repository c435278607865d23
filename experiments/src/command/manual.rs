//! `fracas completions` and `fracas manual`: what the parser of the arguments knows, for shells and for `man`.

use super::{Arguments, Status, output};
use anyhow::Context;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use std::io::Write;
use std::path::PathBuf;

/// Completions of a shell, on standard output.
#[derive(Args, Debug)]
pub(super) struct Completions {
    /// Which shell.
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

impl Completions {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let mut text = Vec::new();
        generate(self.shell, &mut Arguments::command(), "fracas", &mut text);
        out.write_all(&text)?;
        Ok(Status::Done)
    }
}

/// Manual pages, a file per command.
#[derive(Args, Debug)]
pub(super) struct Manual {
    /// Folder of `fracas.1`, `fracas-solve.1`, ….
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl Manual {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        output::folder(&self.out)?;
        clap_mangen::generate_to(Arguments::command(), &self.out)
            .with_context(|| format!("cannot write into {}", self.out.display()))?;
        writeln!(out, "{}", self.out.join("fracas.1").display())?;
        Ok(Status::Done)
    }
}
