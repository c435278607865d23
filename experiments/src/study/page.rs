//! What a study leaves beside its rows: figures, a page, a manifest.

use super::engine::{Ended, Engine};
use super::figures::figures;
use super::findings::Findings as Rows;
use super::{Name, Study, tables};
use crate::report::{Findings, Sheet, Table, write_whole};
use std::collections::BTreeMap;

/// Figures, tables and checks.
pub(super) fn answer(study: &Study, rows: &Rows) -> Findings {
    let checks = study.check.iter().filter(|c| study.is_at_level(&c.not_at));
    let settings = match serde_json::to_value(study) {
        Ok(serde_json::Value::Object(settings)) => settings,
        _ => serde_json::Map::new(),
    };
    let (figures, missing) = figures(study, rows);
    Findings {
        figures,
        panels: Vec::new(),
        tables: study.table.iter().map(|t| tables::table(t, rows)).collect(),
        checks: checks.flat_map(|check| check.checks(rows)).collect(),
        notes: [study.note.clone(), missing].concat(),
        settings,
    }
}

/// Writes `figures/`, `report.html` and `manifest.json`; a sentence for every check that fails.
pub(super) fn write(
    engine: &Engine<'_>,
    rows: &Rows,
    ended: &Ended,
) -> anyhow::Result<Vec<String>> {
    let study = engine.study;
    let mut findings = answer(study, rows);
    if !ended.is_complete() {
        // claims are about all rows
        findings.checks.clear();
    }
    findings.tables.push(table(study, rows));
    findings.tables.extend(failed(study, rows));
    if !ended.is_complete() {
        let note =
            "The study was interrupted; the same command goes on with the rows that are left.";
        findings.notes.push(note.into());
    }
    if engine.jobs > 1 {
        let note = format!(
            "{} rows ran at once: times are not comparable, and peak memory is that of all of them.",
            engine.jobs
        );
        findings.notes.push(note);
    }
    if study.measured().contains(&Name::ReMin) {
        findings.notes.push("Where a system is too large for a dense eigenvalue problem, only its outer eigenvalues are found; the column `reason` of rows.csv says so.".into());
    }
    let outcomes = outcomes(rows);
    let counts: Vec<String> = (outcomes.iter())
        .map(|(word, n)| format!("{n} {}", word.replace('_', " ")))
        .collect();
    let texts = [&study.question, &study.setup, &study.expect];
    let texts: Vec<&str> = texts.iter().map(|text| text.as_str()).collect();
    let lead = format!(
        "{} {} of {} rows",
        texts.join(" ").trim(),
        ended.done,
        ended.total
    );
    let lead = match counts.is_empty() {
        true => format!("{lead}."),
        false => format!("{lead}: {}.", counts.join(", ")),
    };
    let sheet = Sheet {
        title: &study.title,
        lead: lead.trim(),
        findings: &findings,
    };
    sheet.write(engine.out, engine.formats)?;
    let figures: Vec<&str> = findings.figures.iter().map(|f| f.id.as_str()).collect();
    let manifest = serde_json::json!({
        "title": study.title,
        "question": study.question,
        "version": env!("CARGO_PKG_VERSION"),
        "rows": ended.done,
        "rows_of_study": ended.total,
        "jobs": engine.jobs,
        "outcomes": outcomes,
        "columns": rows.header,
        "figures": figures,
        "checks": findings.checks,
        "study": study,
    });
    let manifest = format!("{}\n", serde_json::to_string_pretty(&manifest)?);
    write_whole(&engine.out.join("manifest.json"), &manifest)?;
    Ok(findings.failed())
}

fn outcomes(rows: &Rows) -> BTreeMap<&str, usize> {
    let mut counts = BTreeMap::new();
    for row in &rows.rows {
        *counts.entry(rows.field(row, "outcome")).or_insert(0) += 1;
    }
    counts
}

/// Axes with a value that says something: more than one, or a source.
fn axes(study: &Study, rows: &Rows) -> Vec<String> {
    let mut names = study.axis_names();
    names.retain(|name| {
        if !study.varies(name) && name != "method" {
            return false;
        }
        let mut fields = rows.rows.iter().map(|row| rows.field(row, name));
        let first = fields.next();
        ["scene", "system", "method"].contains(&name.as_str()) || fields.any(|f| Some(f) != first)
    });
    names
}

fn table_of(
    id: &str,
    caption: &str,
    columns: &[&str],
    rows: &Rows,
    which: impl Fn(&[String]) -> bool,
) -> Table {
    let headings: Vec<String> = columns.iter().map(|name| heading(name)).collect();
    let headings: Vec<&str> = headings.iter().map(String::as_str).collect();
    let mut table = Table::new(id, caption, &headings);
    let rows_of = rows.rows.iter().filter(|row| which(row));
    table.rows = rows_of
        .map(|row| {
            columns
                .iter()
                .map(|name| tables::parsed(rows.field(row, name), rows))
                .collect()
        })
        .collect();
    table
}

/// With the unit of what has one.
fn heading(name: &str) -> String {
    match name {
        "setup_s" => "set-up [s]".into(),
        "solve_s" => "solve [s]".into(),
        "memory" => "memory [MiB]".into(),
        _ => name.into(),
    }
}

/// Tables that every study may have.
pub(super) const OWN_TABLES: [&str; 2] = ["table", "failed"];

fn table(study: &Study, rows: &Rows) -> Table {
    let axes = axes(study, rows);
    let columns: Vec<&str> = (["row"].into_iter())
        .chain(axes.iter().map(String::as_str))
        .chain(study.measures.iter().map(|name| name.text()))
        .chain(["outcome"])
        .collect();
    let has = |name: Name| study.measures.contains(&name);
    let errors = match (has(Name::ErrorU) || has(Name::ErrorT), study.reference) {
        (false, _) => "",
        (true, true) => {
            " Errors are in the norms of energy: those against a direct solver where `referenced` is yes, else estimates."
        }
        (true, false) => " Errors are estimates in the norms of energy.",
    };
    let caption = format!("Every row.{errors} rows.csv has every column.");
    table_of(OWN_TABLES[0], &caption, &columns, rows, |_| true)
}

/// Rows that did not converge, with their reasons.
fn failed(study: &Study, rows: &Rows) -> Option<Table> {
    let axes = axes(study, rows);
    let columns: Vec<&str> = (["row"].into_iter())
        .chain(axes.iter().map(String::as_str))
        .chain(["outcome", "reason"])
        .collect();
    let has_failed = |row: &[String]| !rows.is_good(row);
    let table = table_of(
        OWN_TABLES[1],
        "Rows that did not converge, and why.",
        &columns,
        rows,
        has_failed,
    );
    (!table.rows.is_empty()).then_some(table)
}
