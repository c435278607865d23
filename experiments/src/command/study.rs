//! `fracas study`: a study file, row by row.

use super::Status;
use super::interrupt::{self, Signals};
use crate::report::Formats;
use crate::study::{Engine, Study as File, gallery};
use anyhow::bail;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(super) struct Study {
    /// Study file, or the name of a study of the gallery (see `fracas list`).
    #[arg(value_name = "STUDY.toml")]
    file: PathBuf,
    /// Level of the file, where it has several: `smoke` is that of the gallery that takes seconds.
    #[arg(long, value_name = "NAME")]
    level: Option<String>,
    #[command(flatten)]
    place: Place,
}

/// Where a study goes, and how many rows at once.
#[derive(Args, Debug)]
pub(super) struct Place {
    /// Folder of the results: new, empty, or of the same study, which goes on where it stopped.
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Rows at once, each on its share of the threads; times are then not comparable.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..=256))]
    jobs: u16,
    #[command(flatten)]
    also: Also,
}

/// What figures are written as, besides SVG and CSV.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct Also {
    /// Every figure as PDF, too, with its letters embedded.
    #[arg(long)]
    pdf: bool,
}

impl Also {
    pub(super) fn formats(self) -> Formats {
        Formats { pdf: self.pdf }
    }
}

impl Study {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let level = self.level.as_deref();
        let named = self.file.to_str().and_then(gallery::named);
        let study = match named {
            Some(study) if !self.file.exists() => study.read(level)?,
            None if !self.file.exists() => bail!(
                "no study file and no study of the gallery is called `{}`; `fracas list` shows the gallery",
                self.file.display()
            ),
            _ => File::load(&self.file, level)?,
        };
        self.place.run(&study, out)
    }
}

impl Place {
    /// Solves what is left of a study; rows that fail are rows, and no status.
    pub(super) fn run(&self, study: &File, out: &mut dyn Write) -> anyhow::Result<Status> {
        interrupt::listen();
        let engine = Engine {
            study,
            out: &self.out,
            jobs: self.jobs.into(),
            formats: self.also.formats(),
        };
        let bar = std::io::stderr().is_terminal().then(bar);
        let ended = engine.run(&Signals, |row| {
            if let Some(bar) = &bar {
                bar.set_length(row.total as u64);
                if bar.position() == 0 {
                    // rows of before took no time
                    bar.set_position(row.done as u64 - 1);
                    bar.reset_eta();
                }
                bar.set_position(row.done as u64);
                bar.set_message(format!("{}: {}", row.name, row.outcome));
            }
        })?;
        if let Some(bar) = &bar {
            bar.finish_and_clear();
        }
        let (done, total) = (ended.done, ended.total);
        writeln!(out, "{done} of {total} rows")?;
        for claim in &ended.failed {
            writeln!(out, "fails: {claim}")?;
        }
        writeln!(out, "{}", page(&self.out).display())?;
        Ok(match interrupt::asked() {
            Some(signal) if !ended.is_complete() => Status::Interrupted(signal),
            _ if !ended.failed.is_empty() => Status::CheckFailed,
            _ => Status::Done,
        })
    }
}

fn page(out: &Path) -> PathBuf {
    out.join("report.html")
}

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{pos}/{len} {wide_bar} {eta} left  {msg}");
    let bar = ProgressBar::new(0);
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
