//! What a result says about itself: settings, files, verdicts, version. No clock and no host, so that equal runs give
//! equal bytes.

use super::{Check, Column, Experiment, Findings, Level};
use serde::Serialize;

/// Content of `manifest.json` beside the tables and figures of an experiment.
#[derive(Serialize)]
pub(super) struct Manifest<'a> {
    id: &'a str,
    title: &'a str,
    question: &'a str,
    setup: &'a str,
    expect: &'a str,
    level: Level,
    version: &'a str,
    settings: &'a serde_json::Map<String, serde_json::Value>,
    tables: Vec<TableEntry<'a>>,
    figures: Vec<FigureEntry<'a>>,
    checks: &'a [Check],
    notes: &'a [String],
}

#[derive(Serialize)]
struct TableEntry<'a> {
    id: &'a str,
    caption: &'a str,
    columns: &'a [Column],
    rows: usize,
}

#[derive(Serialize)]
struct FigureEntry<'a> {
    id: &'a str,
    caption: &'a str,
}

impl<'a> Manifest<'a> {
    pub(super) fn new(
        experiment: &'a dyn Experiment,
        level: Level,
        findings: &'a Findings,
    ) -> Self {
        let table = |t: &'a super::Table| TableEntry {
            id: &t.id,
            caption: &t.caption,
            columns: &t.columns,
            rows: t.rows.len(),
        };
        Self {
            id: experiment.id(),
            title: experiment.title(),
            question: experiment.question(),
            setup: experiment.setup(),
            expect: experiment.expect(),
            level,
            version: env!("CARGO_PKG_VERSION"),
            settings: &findings.settings,
            tables: findings.tables.iter().map(table).collect(),
            figures: findings
                .figures
                .iter()
                .map(|f| FigureEntry {
                    id: &f.id,
                    caption: &f.caption,
                })
                .collect(),
            checks: &findings.checks,
            notes: &findings.notes,
        }
    }
}
