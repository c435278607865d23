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
    /// Less than nothing.
    #[error(
        "{place}, row {row}: a pore pressure of {value} Pa is negative; give absolute pressures"
    )]
    Negative {
        /// File or table.
        place: String,
        /// Its row, from 1.
        row: usize,
        /// That value [Pa].
        value: f64,
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

/// Times and one column of a CSV file, unit by unit.
fn rows(path: &Path, file: &str, column: &str) -> Result<Points, TableProblem> {
    let file = || file.to_string();
    let text = std::fs::read_to_string(path).map_err(|error| TableProblem::Unreadable {
        file: file(),
        reason: error.to_string(),
    })?;
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty());
    let (_, heading) = lines.next().ok_or(TableProblem::Empty { place: file() })?;
    let names: Vec<(&str, &str)> = heading
        .split(',')
        .map(|cell| match cell.trim().split_once('[') {
            Some((name, unit)) => (name.trim(), unit.trim_end().trim_end_matches(']').trim()),
            None => (cell.trim(), ""),
        })
        .collect();
    let wrong = |k: usize| TableProblem::Heading {
        file: file(),
        column: k + 1,
        found: heading
            .split(',')
            .nth(k)
            .unwrap_or_default()
            .trim()
            .to_string(),
    };
    if names[0].0 != "time" || measured::<Duration>("1", names[0].1).is_none() {
        return Err(wrong(0));
    }
    let place = names.iter().skip(1).position(|(name, _)| *name == column);
    let place = place.ok_or_else(|| TableProblem::NoColumn {
        file: file(),
        column: column.into(),
        known: names
            .iter()
            .skip(1)
            .map(|(name, _)| (*name).to_string())
            .collect(),
    })? + 1;
    if measured::<PorePressure>("1", names[place].1).is_none() {
        return Err(wrong(place));
    }
    lines
        .map(|(n, line)| {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            let cell = |k: usize| cells.get(k).copied().unwrap_or_default();
            let number = |k: usize| match cell(k).parse::<f64>() {
                Ok(value) if value.is_finite() => Ok(value),
                _ => Err(TableProblem::NoNumber {
                    file: file(),
                    row: n + 1,
                    column: names[k].0.into(),
                    found: cell(k).into(),
                }),
            };
            let (time, pressure) = (number(0)?, number(place)?);
            let negative = |value: f64| TableProblem::Negative {
                place: file(),
                row: n + 1,
                value,
            };
            let time = measured(&time.to_string(), names[0].1).ok_or_else(|| wrong(0))?;
            let written = pressure.to_string();
            let pressure = measured(&written, names[place].1).ok_or_else(|| negative(pressure))?;
            Ok((time, pressure))
        })
        .collect()
}

/// A number with a unit, where both make sense.
fn measured<K: Kind>(number: &str, unit: &str) -> Option<Measure<K>> {
    format!("{number} {unit}").parse().ok()
}

impl PorePressureSection {
    /// The change since time 0 against time [Pa].
    pub(super) fn history(&self, name: &str) -> Result<History, TableProblem> {
        let place = || format!("`pore_pressure` of material \"{name}\"");
        let points: Vec<(f64, f64)> = (self.points.iter().flatten())
            .map(|(time, pressure)| (time.si(), pressure.si()))
            .collect();
        let back = points.windows(2).position(|pair| pair[0].0 >= pair[1].0);
        if let Some(row) = back {
            return Err(TableProblem::Unsorted {
                place: place(),
                row: row + 2,
                time: points[row + 1].0,
                before: points[row].0,
            });
        }
        let history = match self.between {
            Between::Linear => History::through(points.clone()),
            Between::Steps => History::in_steps(points.clone()),
        };
        let first = history.as_ref().map_or(0.0, |h| h.at(0.0));
        history
            .map(|history| history.less(first))
            .ok_or(TableProblem::Empty { place: place() })
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
