//! Tables in CSV files: cells may be quoted, a mark of byte order may come first, empty rows count as none.

use super::TableProblem;
use crate::units::{Kind, Measure};
use std::path::Path;

/// A heading of names and units, and records below it.
pub(super) struct CsvTable {
    /// Name of the file for messages.
    pub(super) file: String,
    /// The cells of the heading as they stand there.
    pub(super) heading: csv::StringRecord,
    /// Their names and units.
    pub(super) names: Vec<[String; 2]>,
    /// The rows below it.
    pub(super) rows: Vec<Row>,
}

/// A row of cells.
pub(super) struct Row {
    /// Its number in the file, from 1.
    pub(super) number: usize,
    cells: csv::StringRecord,
}

impl CsvTable {
    /// Reads the file.
    pub(super) fn read(path: &Path, file: &str) -> Result<Self, TableProblem> {
        match std::fs::read(path) {
            Ok(text) => Self::of_text(&text, file),
            Err(error) => Err(TableProblem::Unreadable {
                file: file.into(),
                reason: error.to_string(),
            }),
        }
    }

    /// The table in the bytes of a file.
    pub(super) fn of_text(text: &[u8], file: &str) -> Result<Self, TableProblem> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .from_reader(text);
        let records: Vec<csv::StringRecord> = (reader.records().collect::<Result<_, _>>())
            .map_err(|error| TableProblem::Unreadable {
                file: file.into(),
                reason: error.to_string(),
            })?;
        let mut filled = (records.into_iter()).filter(|r| r.iter().any(|cell| !cell.is_empty()));
        let heading = filled
            .next()
            .ok_or_else(|| TableProblem::Empty { place: file.into() })?;
        Ok(Self {
            names: heading.iter().map(named).collect(),
            rows: numbered(filled, text),
            heading,
            file: file.into(),
        })
    }

    /// Refuses a row with more cells than the heading.
    pub(super) fn require_no_surplus(&self, row: &Row) -> Result<(), TableProblem> {
        if row.cells.len() <= self.names.len() {
            return Ok(());
        }
        Err(TableProblem::Surplus {
            file: self.file.clone(),
            row: row.number,
            found: row.cells.len(),
            columns: self.names.len(),
            surplus: row.cells[row.cells.len() - 1].to_string(),
        })
    }

    /// The quantity in column k of a row.
    pub(super) fn quantity<K: Kind>(
        &self,
        row: &Row,
        k: usize,
    ) -> Result<Measure<K>, TableProblem> {
        let cell = row.cells.get(k).unwrap_or_default();
        let [name, unit] = &self.names[k];
        let number = cell.parse().ok().filter(|value: &f64| value.is_finite());
        let Some(number) = number else {
            return Err(TableProblem::NoNumber {
                file: self.file.clone(),
                row: row.number,
                column: name.clone(),
                found: cell.into(),
            });
        };
        measured(&number.to_string(), unit).map_err(|reason| TableProblem::Senseless {
            file: self.file.clone(),
            row: row.number,
            column: name.clone(),
            reason,
        })
    }
}

/// Name and unit of `name [unit]`.
fn named(cell: &str) -> [String; 2] {
    let parts = match cell.split_once('[') {
        Some((name, unit)) => [name.trim(), unit.trim_end().trim_end_matches(']').trim()],
        None => [cell, ""],
    };
    parts.map(String::from)
}

/// Records with their rows. The position of one lies before the empty rows that it follows.
fn numbered(records: impl Iterator<Item = csv::StringRecord>, text: &[u8]) -> Vec<Row> {
    let (mut row, mut counted) = (1, 0);
    let number = |cells: csv::StringRecord| {
        let from = cells.position().map_or(0, |at| at.byte() as usize);
        let ends = |byte: &&u8| matches!(byte, b'\r' | b'\n');
        let start = from + text[from..].iter().take_while(ends).count();
        row += text[counted..start].iter().filter(|b| **b == b'\n').count();
        counted = start;
        Row { number: row, cells }
    };
    records.map(number).collect()
}

/// A number with a unit, or why it makes no sense.
pub(super) fn measured<K: Kind>(number: &str, unit: &str) -> Result<Measure<K>, String> {
    let read = format!("{number} {unit}").parse();
    read.map_err(|error: <Measure<K> as std::str::FromStr>::Err| error.to_string())
}
