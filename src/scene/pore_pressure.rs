//! Pore pressures of a material in time, as tables: in the scene, or in a CSV file.

use super::located::{Located, at};
use super::sections::SceneSections;
use super::{History, Problem};
use crate::units::{Duration, Kind, Measure, PorePressure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The pore pressure of a material in time; what counts is its change since time 0. Give `points` or `file`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PorePressureSection {
    /// `[[time, pressure], …]`, times increasing; constant outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<(Measure<Duration>, Measure<PorePressure>)>>,
    /// A CSV file with the heading `time [day],north [bar],…` and a row per time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Its column; the name of the material if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// What holds between two times.
    #[serde(default, skip_serializing_if = "Between::is_linear")]
    pub between: Between,
}

/// What holds between two times of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Between {
    /// The straight line.
    #[default]
    Linear,
    /// The value of the earlier one.
    Steps,
}

impl Between {
    fn is_linear(&self) -> bool {
        *self == Self::Linear
    }
}

/// A table of pressures that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableProblem {
    /// The file cannot be read.
    #[error("cannot read {file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// A heading that names no unit, or no time.
    #[error(
        "{file}, row 1: the heading must be `time [day],north [bar],…`, a name and a unit per column, time first; column {column} is `{found}`"
    )]
    Heading {
        /// The file.
        file: String,
        /// Number of the column, from 1.
        column: usize,
        /// What stands there.
        found: String,
    },
    /// A column that is not there.
    #[error("{file} has no column `{column}`; it has: {}", known.join(", "))]
    NoColumn {
        /// The file.
        file: String,
        /// As asked for.
        column: String,
        /// Its columns.
        known: Vec<String>,
    },
    /// A hole, or a word.
    #[error(
        "{file}, row {row}: column `{column}` is `{found}`, which is no number; fill it, or leave the row out"
    )]
    NoNumber {
        /// The file.
        file: String,
        /// Its row, from 1.
        row: usize,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
    },
    /// More cells than the heading has columns: a decimal comma, say.
    #[error(
        "{file}, row {row} has {found} cells and the heading {columns}: cell {found} is `{surplus}`; write decimals with a point, and one cell per column"
    )]
    Surplus {
        /// The file.
        file: String,
        /// Its row, from 1.
        row: usize,
        /// Cells of the row.
        found: usize,
        /// Columns of the heading.
        columns: usize,
        /// The last cell.
        surplus: String,
    },
    /// Two columns of one name.
    #[error(
        "{file}, row 1: columns {first} and {second} are both named `{column}`; give each a name of its own"
    )]
    TwoColumns {
        /// The file.
        file: String,
        /// Their name.
        column: String,
        /// Number of the first, from 1.
        first: usize,
        /// That of the other.
        second: usize,
    },
    /// A number that makes no sense with its unit.
    #[error("{file}, row {row}, column `{column}`: {reason}")]
    Senseless {
        /// The file.
        file: String,
        /// Its row, from 1.
        row: usize,
        /// The column.
        column: String,
        /// Why.
        reason: String,
    },
    /// Times that go back.
    #[error(
        "{place}, row {row}: time {time} s does not come after {before} s; sort the rows by time"
    )]
    Unsorted {
        /// File or table.
        place: String,
        /// Its row, from 1.
        row: usize,
        /// Its time [s].
        time: f64,
        /// That of the row before [s].
        before: f64,
    },
    /// No row at all.
    #[error("{place} has no row; give a [time, pressure] at least")]
    Empty {
        /// File or table.
        place: String,
    },
}

/// Takes the rows of files into the sections, so that scene, checkpoint and restart know the numbers and not a path.
pub(super) fn read_files(sections: &mut SceneSections, folder: &Path) -> Result<(), Located> {
    for (i, material) in sections.material.iter_mut().enumerate() {
        let Some(section) = &mut material.pore_pressure else {
            continue;
        };
        let place = |key: &str| {
            [
                String::from("material"),
                i.to_string(),
                "pore_pressure".into(),
                key.into(),
            ]
        };
        let found = usize::from(section.points.is_some()) + usize::from(section.file.is_some());
        if found != 1 {
            let what = format!("`pore_pressure` of material \"{}\"", material.name);
            let keys = "`points`, `file`";
            let path = ["material", &i.to_string(), "pore_pressure"];
            return Err(at(&path, Problem::ExactlyOne { what, keys, found }));
        }
        let Some(file) = section.file.take() else {
            continue;
        };
        let column = section.column.take().unwrap_or(material.name.clone());
        let points = rows(&folder.join(&file), &file.display().to_string(), &column);
        let points = points.map_err(|problem| Located {
            path: place("file").to_vec(),
            problem: Box::new(problem.into()),
        })?;
        section.points = Some(points);
    }
    Ok(())
}

type Points = Vec<(Measure<Duration>, Measure<PorePressure>)>;

/// Times and one column of a CSV file, unit by unit; cells may be quoted, a mark of byte order may come first.
fn rows(path: &Path, file: &str, column: &str) -> Result<Points, TableProblem> {
    let file = || file.to_string();
    let unreadable = |reason: String| TableProblem::Unreadable {
        file: file(),
        reason,
    };
    let text = std::fs::read(path).map_err(|error| unreadable(error.to_string()))?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(&text[..]);
    let records: Vec<csv::StringRecord> = (reader.records().collect::<Result<_, _>>())
        .map_err(|error| unreadable(error.to_string()))?;
    let mut filled = (records.iter()).filter(|record| record.iter().any(|cell| !cell.is_empty()));
    let heading = filled.next().ok_or(TableProblem::Empty { place: file() })?;
    let names: Vec<(&str, &str)> = (heading.iter())
        .map(|cell| match cell.split_once('[') {
            Some((name, unit)) => (name.trim(), unit.trim_end().trim_end_matches(']').trim()),
            None => (cell, ""),
        })
        .collect();
    let wrong = |k: usize| TableProblem::Heading {
        file: file(),
        column: k + 1,
        found: heading[k].to_string(),
    };
    if names[0].0 != "time" || measured::<Duration>("1", names[0].1).is_err() {
        return Err(wrong(0));
    }
    let mut named = (1..names.len()).filter(|k| names[*k].0 == column);
    let place = named.next().ok_or_else(|| TableProblem::NoColumn {
        file: file(),
        column: column.into(),
        known: names[1..]
            .iter()
            .map(|(name, _)| name.to_string())
            .collect(),
    })?;
    if let Some(second) = named.next() {
        return Err(TableProblem::TwoColumns {
            file: file(),
            column: column.into(),
            first: place + 1,
            second: second + 1,
        });
    }
    if measured::<PorePressure>("1", names[place].1).is_err() {
        return Err(wrong(place));
    }
    let mut lines = Vec::new();
    let mut points = Points::new();
    for record in filled {
        let row = row_of(record, &text);
        if record.len() > names.len() {
            return Err(TableProblem::Surplus {
                file: file(),
                row,
                found: record.len(),
                columns: names.len(),
                surplus: record[record.len() - 1].to_string(),
            });
        }
        let number = |k: usize| {
            let cell = record.get(k).unwrap_or_default();
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value.to_string()),
                _ => Err(TableProblem::NoNumber {
                    file: file(),
                    row,
                    column: names[k].0.into(),
                    found: cell.into(),
                }),
            }
        };
        let senseless = |k: usize, reason: String| TableProblem::Senseless {
            file: file(),
            row,
            column: names[k].0.into(),
            reason,
        };
        let time = measured(&number(0)?, names[0].1).map_err(|why| senseless(0, why))?;
        let pressure = measured(&number(place)?, names[place].1);
        let pressure = pressure.map_err(|why| senseless(place, why))?;
        points.push((time, pressure));
        lines.push(row);
    }
    increasing(&points, file, |k| lines[k])?;
    Ok(points)
}

/// Row of a record, from 1. Its position lies before the empty rows that it follows.
fn row_of(record: &csv::StringRecord, text: &[u8]) -> usize {
    let from = record.position().map_or(0, |at| at.byte() as usize);
    let ends = |byte: &&u8| matches!(byte, b'\r' | b'\n');
    let start = from + text[from..].iter().take_while(ends).count();
    1 + text[..start].iter().filter(|byte| **byte == b'\n').count()
}

/// A number with a unit, or why it makes no sense.
fn measured<K: Kind>(number: &str, unit: &str) -> Result<Measure<K>, String> {
    let read = format!("{number} {unit}").parse();
    read.map_err(|error: <Measure<K> as std::str::FromStr>::Err| error.to_string())
}

/// Times that increase; `row` is the number of a point for a message.
fn increasing(
    points: &[(Measure<Duration>, Measure<PorePressure>)],
    place: impl Fn() -> String,
    row: impl Fn(usize) -> usize,
) -> Result<(), TableProblem> {
    let times: Vec<f64> = points.iter().map(|(time, _)| time.si()).collect();
    match times.windows(2).position(|pair| pair[0] >= pair[1]) {
        None => Ok(()),
        Some(k) => Err(TableProblem::Unsorted {
            place: place(),
            row: row(k + 1),
            time: times[k + 1],
            before: times[k],
        }),
    }
}

impl PorePressureSection {
    /// The change since time 0 against time [Pa].
    pub(super) fn history(&self, name: &str) -> Result<History, TableProblem> {
        let place = || format!("`pore_pressure` of material \"{name}\"");
        let given = self.points.as_deref().unwrap_or_default();
        increasing(given, place, |k| k + 1)?;
        let points: Vec<(f64, f64)> = (given.iter())
            .map(|(time, pressure)| (time.si(), pressure.si()))
            .collect();
        let history = match self.between {
            Between::Linear => History::through(points.clone()),
            Between::Steps => History::in_steps(points.clone()),
        };
        let first = history.as_ref().map_or(0.0, |h| h.at(0.0));
        history
            .map(|history| history.less(first))
            .ok_or(TableProblem::Empty { place: place() })
    }

    /// Its first time.
    pub(super) fn first(&self) -> Option<&Measure<Duration>> {
        self.points.as_ref()?.first().map(|(time, _)| time)
    }

    /// True where it changes.
    pub(super) fn varies(&self) -> bool {
        let points = self.points.iter().flatten();
        let first = self.points.iter().flatten().next();
        points
            .into_iter()
            .any(|(_, p)| first.is_some_and(|(_, first)| p.si() != first.si()))
    }
}
