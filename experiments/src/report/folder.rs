//! Runs experiments and writes their files.

use super::html::page;
use super::manifest::Manifest;
use super::{Experiment, Findings, Level};
use anyhow::Context;
use fracas::io::write_atomically;
use fracas_solvers::Observer;
use std::io::Write;
use std::path::Path;

/// Formats that figures are written in beside SVG and CSV.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Formats {
    /// PDF, with the letters embedded.
    pub pdf: bool,
}

/// How an experiment ended.
pub enum Outcome {
    /// With an answer, whatever its checks say.
    Answered(Findings),
    /// Without one.
    Broken(anyhow::Error),
}

/// An experiment and its answer: a chapter of the report.
pub struct Chapter {
    /// What was asked.
    pub experiment: &'static dyn Experiment,
    /// What was found.
    pub outcome: Outcome,
}

impl Chapter {
    /// True when there is an answer and every check holds.
    pub fn passed(&self) -> bool {
        matches!(&self.outcome, Outcome::Answered(findings) if findings.passed())
    }

    /// A sentence for every check that fails, or the reason why there is no answer.
    pub fn failed(&self) -> Vec<String> {
        match &self.outcome {
            Outcome::Answered(findings) => findings.failed(),
            Outcome::Broken(reason) => vec![format!("{reason:#}")],
        }
    }
}

/// Runs an experiment and writes `out/<id>/*.csv *.svg *.column.svg manifest.json`, `*.pdf` where asked for. An experiment that breaks is a chapter too.
///
/// # Errors
/// Files that cannot be written.
pub fn run_chapter(
    experiment: &'static dyn Experiment,
    level: Level,
    (out, formats): (&Path, Formats),
    observer: &mut dyn Observer,
) -> anyhow::Result<Chapter> {
    let outcome = match experiment.run(level, observer) {
        Ok(findings) => {
            let folder = out.join(experiment.id());
            write_findings(experiment, level, &findings, (&folder, formats))?;
            Outcome::Answered(findings)
        }
        Err(error) => Outcome::Broken(error),
    };
    Ok(Chapter {
        experiment,
        outcome,
    })
}

fn write_findings(
    experiment: &dyn Experiment,
    level: Level,
    findings: &Findings,
    (folder, formats): (&Path, Formats),
) -> anyhow::Result<()> {
    write_results(experiment.id(), findings, folder, formats)?;
    for figure in &findings.figures {
        let column = format!("{}.column.svg", figure.id);
        write(folder, &column, &figure.to_column_svg()?)?;
    }
    let mut manifest = serde_json::to_string_pretty(&Manifest::new(experiment, level, findings))?;
    manifest.push('\n');
    write(folder, "manifest.json", &manifest)
}

/// Writes `folder/*.csv *.svg`, and `*.pdf` where asked for; `of` says whose results they are.
pub(super) fn write_results(
    of: &str,
    findings: &Findings,
    folder: &Path,
    formats: Formats,
) -> anyhow::Result<()> {
    let mut ids = std::collections::BTreeSet::new();
    let named = findings.tables.iter().map(|t| &t.id);
    let panels = || findings.panels.iter().flat_map(|p| &p.figures);
    let drawn = findings.figures.iter().chain(panels());
    for id in named.chain(drawn.map(|f| &f.id)) {
        anyhow::ensure!(
            ids.insert(id),
            "two results of {of} are named {id}; one file would overwrite the other"
        );
    }
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create {}", folder.display()))?;
    for table in &findings.tables {
        write(folder, &format!("{}.csv", table.id), &table.to_csv())?;
    }
    for figure in &findings.figures {
        write(folder, &format!("{}.csv", figure.id), &figure.to_csv())?;
        write(folder, &format!("{}.svg", figure.id), &figure.to_svg()?)?;
        if formats.pdf {
            let path = folder.join(format!("{}.pdf", figure.id));
            write_whole(&path, &figure.to_pdf()?)?;
        }
    }
    for figure in panels() {
        write(folder, &format!("{}.csv", figure.id), &figure.to_csv())?;
        let svg = figure.to_panel_svg()?;
        write(folder, &format!("{}.svg", figure.id), &svg)?;
        if formats.pdf {
            let path = folder.join(format!("{}.pdf", figure.id));
            write_whole(&path, &figure.to_panel_pdf()?)?;
        }
    }
    Ok(())
}

/// Writes the self-contained `out/report.html`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_report(chapters: &[Chapter], level: Level, out: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(out).with_context(|| format!("cannot create {}", out.display()))?;
    write(out, "report.html", &page(chapters, level)?)
}

pub(super) fn write(folder: &Path, name: &str, text: &str) -> anyhow::Result<()> {
    write_whole(&folder.join(name), text)
}

/// Writes a file whole or not at all; into what is no file of its own (a device, a pipe, a link) it writes in place.
pub(crate) fn write_whole(
    path: &Path,
    content: &(impl AsRef<[u8]> + ?Sized),
) -> anyhow::Result<()> {
    let content = content.as_ref();
    let in_place = path.symlink_metadata().is_ok_and(|m| !m.is_file());
    match in_place {
        true => std::fs::write(path, content),
        false => write_atomically(path, |out| out.write_all(content)),
    }
    .with_context(|| format!("cannot write {}", path.display()))
}
