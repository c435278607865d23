//! `fracas reproduce`: figures and tables, beside the published numbers.

use super::progress::Progress;
use super::study::Also;
use super::{Status, output};
use crate::list::{EXPERIMENTS, SHORT_SELECTION, find};
use crate::report::{Experiment, Level, run_chapter, write_report};
use clap::Args;
use fracas_solvers::Observer;
use std::io::Write;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(super) struct Reproduce {
    /// Experiments by id (see `fracas list`), or `all`; none = every one at the level `smoke`, in about three minutes.
    #[arg(value_name = "ID")]
    ids: Vec<String>,
    /// Size: `paper`, the size in print, where experiments are named; `smoke`, which takes seconds each, where none is.
    #[arg(long, value_enum)]
    level: Option<LevelChoice>,
    /// Folder for report.html and one subfolder per experiment.
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    #[command(flatten)]
    also: Also,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum LevelChoice {
    Smoke,
    Paper,
}

/// An experiment that does not exist.
#[derive(Debug, thiserror::Error)]
#[error("no experiment `{id}`{}; `fracas list` shows them all", nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)")))]
struct UnknownExperiment {
    id: String,
    nearest: Option<&'static str>,
}

impl Reproduce {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let level = match (self.level, self.ids.as_slice()) {
            (Some(LevelChoice::Smoke), _) | (None, []) => Level::Smoke,
            (Some(LevelChoice::Paper), _) | (None, _) => Level::Paper,
        };
        let selection = select(&self.ids, level)?;
        output::folder(&self.out)?;
        let mut progress = Progress::new();
        let mut chapters = Vec::new();
        for experiment in selection {
            progress.say(&format_args!(
                "{}: {}",
                experiment.id(),
                experiment.question()
            ));
            let chapter = run_chapter(
                experiment,
                level,
                (&self.out, self.also.formats()),
                &mut progress,
            )?;
            let verdict = if chapter.passed() { "holds" } else { "FAILS" };
            writeln!(out, "{} {verdict}: {}", experiment.id(), experiment.title())?;
            for claim in chapter.failed() {
                writeln!(out, "  fails: {claim}")?;
            }
            chapters.push(chapter);
            // After each chapter, so that an interrupted run leaves a readable page.
            write_report(&chapters, level, &self.out)?;
        }
        writeln!(out, "{}", self.out.join("report.html").display())?;
        let good = chapters.iter().all(|c| c.passed());
        Ok(if good {
            Status::Done
        } else {
            Status::CheckFailed
        })
    }
}

/// The experiments named, in the order of the list and without repetition; without names all of them, or those that take minutes in print.
fn select(ids: &[String], level: Level) -> Result<Vec<&'static dyn Experiment>, UnknownExperiment> {
    let unknown = |id: &String| UnknownExperiment {
        id: id.clone(),
        nearest: nearest(id),
    };
    if let Some(id) = ids.iter().find(|id| *id != "all" && find(id).is_none()) {
        return Err(unknown(id));
    }
    let wanted = |id: &str| match ids {
        [] => level == Level::Smoke || SHORT_SELECTION.contains(&id),
        _ => ids.iter().any(|wanted| wanted == id || wanted == "all"),
    };
    Ok(EXPERIMENTS
        .iter()
        .copied()
        .filter(|e| wanted(e.id()))
        .collect())
}

fn nearest(id: &str) -> Option<&'static str> {
    let distance = |known: &&str| strsim::damerau_levenshtein(known, id);
    EXPERIMENTS
        .iter()
        .map(|e| e.id())
        .min_by_key(distance)
        .filter(|known| distance(known) <= 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_names_everything_is_small_or_the_short_selection_is_as_in_print() {
        let ids = |level| -> Vec<&str> {
            let selection = select(&[], level).unwrap_or_default();
            selection.iter().map(|e| e.id()).collect()
        };
        assert_eq!(ids(Level::Smoke).len(), EXPERIMENTS.len());
        assert_eq!(ids(Level::Paper), SHORT_SELECTION);
    }
}
