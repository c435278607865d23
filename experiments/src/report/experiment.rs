//! What an experiment is: a question, a set-up, an expectation, and a function that answers.

use super::{Check, Table};
use fracas_figures::Figure;
use fracas_solvers::Observer;
use serde::{Deserialize, Serialize};

/// How large to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Seconds: continuous integration.
    Smoke,
    /// The size of the figures in print.
    Paper,
}

impl Level {
    /// The word on the command line.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Smoke => "smoke",
            Self::Paper => "paper",
        }
    }
}

/// A figure or table that can be reproduced.
pub trait Experiment: Sync {
    /// Short name on the command line: `e01`.
    fn id(&self) -> &str;

    /// Heading in the report.
    fn title(&self) -> &str;

    /// What is asked, in a sentence.
    fn question(&self) -> &str;

    /// Scene, sizes, methods, tolerances.
    fn setup(&self) -> &str;

    /// The expected answer, with its source.
    fn expect(&self) -> &str;

    /// Answers. Methods that fail are rows of the table; an error means that the experiment itself broke.
    ///
    /// # Errors
    /// Whatever keeps the experiment from giving an answer.
    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings>;
}

/// Small figures side by side, under a heading.
#[derive(Clone, Debug, Default)]
pub struct Panels {
    /// Heading; one that is empty goes on with the panels before.
    pub title: String,
    /// What all of them show, and how.
    pub caption: String,
    /// From left to right; each an SVG and a CSV file.
    pub figures: Vec<Figure>,
}

/// What an experiment found.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    /// Every setting that the numbers depend on, printed verbatim into the manifest.
    pub settings: serde_json::Map<String, serde_json::Value>,
    /// Tables, each a CSV file.
    pub tables: Vec<Table>,
    /// Figures, each an SVG and a CSV file.
    pub figures: Vec<Figure>,
    /// Figures that are looked at side by side, behind those that stand alone.
    pub panels: Vec<Panels>,
    /// Claims held against numbers; one that fails makes `fracas reproduce` end with status 4.
    pub checks: Vec<Check>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
}

impl Findings {
    /// Records a setting.
    pub fn set(&mut self, key: &str, value: impl Into<serde_json::Value>) -> &mut Self {
        self.settings.insert(key.into(), value.into());
        self
    }

    /// True when no check failed.
    pub fn passed(&self) -> bool {
        self.checks.iter().all(|c| c.pass)
    }

    /// A sentence for every check that failed.
    pub fn failed(&self) -> Vec<String> {
        let failed = self.checks.iter().filter(|check| !check.pass);
        let told = |check: &Check| {
            let (expected, ours) = (&check.expected, &check.ours);
            format!("{}: expected {expected}, found {ours}", check.claim)
        };
        let mut claims: Vec<String> = failed.map(told).collect();
        // of several rows in the same words
        let mut said = std::collections::HashSet::new();
        claims.retain(|claim| said.insert(claim.clone()));
        claims
    }
}
