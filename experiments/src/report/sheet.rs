//! One answer on one page, for results that are no experiment.

use super::folder::{write, write_results};
use super::html::single;
use super::{Findings, Formats};
use std::path::Path;

/// Subfolder of the tables and figures of a sheet.
pub(crate) const FIGURES: &str = "figures";

/// A page with a heading, a sentence, and what was found.
#[derive(Clone, Debug)]
pub struct Sheet<'a> {
    /// Heading.
    pub title: &'a str,
    /// What the reader should know first.
    pub lead: &'a str,
    /// Tables, figures, checks, notes, settings.
    pub findings: &'a Findings,
}

impl Sheet<'_> {
    /// Writes `out/figures/*.csv *.svg`, `*.pdf` where asked for, and the self-contained `out/report.html`.
    ///
    /// # Errors
    /// Files that cannot be written; two results of one name.
    pub fn write(&self, out: &Path, formats: Formats) -> anyhow::Result<()> {
        write_results(self.title, self.findings, &out.join(FIGURES), formats)?;
        write(out, "report.html", &single(self)?)
    }
}
