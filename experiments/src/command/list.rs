//! `fracas list`: what there is to run.

use super::Status;
use crate::list::{EXPERIMENTS, SHORT_SELECTION};
use fracas::scene::gallery;
use std::io::Write;

pub(super) fn run(out: &mut dyn Write) -> anyhow::Result<Status> {
    let width = EXPERIMENTS.iter().map(|e| e.id().len()).max().unwrap_or(0);
    writeln!(
        out,
        "experiments (* = in the short selection of `fracas reproduce --level paper`; those in docs/studies.md are studies for `fracas study`, too)"
    )?;
    for e in EXPERIMENTS {
        let star = if SHORT_SELECTION.contains(&e.id()) {
            '*'
        } else {
            ' '
        };
        writeln!(
            out,
            "{star} {:width$}  {}  {}",
            e.id(),
            e.question(),
            e.expect()
        )?;
    }
    let width = gallery().iter().map(|s| s.name.len()).max().unwrap_or(0);
    writeln!(out, "\nscenes")?;
    for s in gallery() {
        writeln!(out, "  {:width$}  {}  {}", s.name, s.question, s.expected)?;
    }
    Ok(Status::Done)
}
