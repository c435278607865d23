//! Tables of a study: a row per row, or per group of rows, whose columns choose among them.

use super::findings::{Fields, Findings};
use super::measure::{Group, Name};
use super::product::Wanted;
use crate::report::{Cell, Table as Printed};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::Table;

/// `[[table]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TableSection {
    /// Name of its file.
    pub id: String,
    /// A sentence above it.
    #[serde(default)]
    pub caption: String,
    /// Rows of the study that it shows.
    #[serde(default, rename = "where", skip_serializing_if = "Table::is_empty")]
    pub of_rows: Table,
    /// Columns whose values make a row of it; every row of the study by default.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<String>,
    /// A formula: of the rows that agree in these the one with the least value is shown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<String>,
    /// Its columns.
    pub columns: Vec<Column>,
}

/// A column: `"n_it"`, `"heading = formula"`, or a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Column {
    /// With a heading, where there is a ` = `.
    Short(String),
    /// With all it may have.
    Long(LongColumn),
}

/// A column with all it may have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LongColumn {
    /// Heading.
    pub name: String,
    /// A measure, an axis, or a formula of them.
    pub of: String,
    /// Which row of the group.
    #[serde(default, rename = "where", skip_serializing_if = "Table::is_empty")]
    pub of_rows: Table,
    /// Words in the place of fields; `X` that of a failure.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub words: BTreeMap<String, String>,
}

impl Column {
    pub(super) fn full(&self) -> LongColumn {
        let text = match self {
            Self::Long(column) => return column.clone(),
            Self::Short(text) => text,
        };
        let (name, of) = text.split_once(" = ").unwrap_or((text, text));
        LongColumn {
            name: name.into(),
            of: of.into(),
            of_rows: Table::new(),
            words: BTreeMap::new(),
        }
    }
}

/// The table that a section asks for.
pub(super) fn table(section: &TableSection, findings: &Findings) -> Printed {
    let columns: Vec<LongColumn> = section.columns.iter().map(Column::full).collect();
    let headings: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    let mut table = Printed::new(&section.id, &section.caption, &headings);
    let mut groups: Vec<(Vec<&str>, Vec<&Fields>)> = Vec::new();
    for row in findings.chosen(&section.of_rows) {
        let key: Vec<&str> = match section.rows.is_empty() {
            true => vec![findings.field(row, "row")],
            false => section
                .rows
                .iter()
                .map(|name| findings.field(row, name))
                .collect(),
        };
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((key, vec![row])),
        }
    }
    if let Some(least) = &section.least {
        // rows that failed last, of equal ones the first
        let value = |row: &Fields| match findings.value(row, least, true) {
            value if value.is_nan() => f64::INFINITY,
            value => value,
        };
        for (_, rows) in &mut groups {
            let best = (rows.iter().copied()).min_by(|a, b| value(a).total_cmp(&value(b)));
            *rows = best.into_iter().collect();
        }
    }
    let cells = |(_, rows): &(_, Vec<&Fields>)| -> Vec<Cell> {
        columns
            .iter()
            .map(|column| cell(column, rows, findings))
            .collect()
    };
    table.rows = groups.iter().map(cells).collect();
    table
}

/// The first value among rows, or how the first one failed.
fn cell(column: &LongColumn, rows: &[&Fields], findings: &Findings) -> Cell {
    let wanted = Wanted::new(&column.of_rows);
    let is_meant = |row: &&&Fields| wanted.is_met(|name| findings.field(row, name).to_owned());
    let mut cells = rows
        .iter()
        .filter(is_meant)
        .map(|row| one(column, row, findings));
    let first = cells.next().unwrap_or(Cell::Missing);
    match first {
        Cell::Missing | Cell::Failed => {
            let other = cells.find(|cell| !matches!(cell, Cell::Missing | Cell::Failed));
            other.unwrap_or(first)
        }
        _ => first,
    }
}

fn one(column: &LongColumn, row: &Fields, findings: &Findings) -> Cell {
    let of = column.of.as_str();
    let field = match findings.header.iter().any(|name| name == of) || of.starts_with("published.")
    {
        true => findings.field(row, of).to_owned(),
        false => match findings.value(row, of, false) {
            value if value.is_finite() => super::measure::number(value),
            _ => String::new(),
        },
    };
    let word = |field: &str| column.words.get(field).map(|word| word.as_str().into());
    if let Some(word) = word(&field) {
        return word;
    }
    if field.is_empty() {
        let group = Name::find(of).map(Name::group);
        let is_result = matches!(
            group,
            Some(Group::Count | Group::Condition | Group::Spectrum | Group::NonNormal)
        );
        return match is_result && findings.has_failed(row) {
            true => word("X").unwrap_or(Cell::Failed),
            false => Cell::Missing,
        };
    }
    parsed(&field, findings)
}

/// A field as what it is.
pub(super) fn parsed(field: &str, findings: &Findings) -> Cell {
    match (field, field.parse::<i64>(), field.parse::<f64>()) {
        ("", ..) => Cell::Missing,
        ("X", ..) => Cell::Failed,
        (_, Ok(n), _) => Cell::Integer(n),
        (_, _, Ok(value)) if value.is_finite() => Cell::Real(value),
        _ => findings.label(field).as_str().into(),
    }
}
