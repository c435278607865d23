//! Pore pressures of a material in time: tables in the scene or in a CSV file, fields in files, diffusion from a neighbour.

use super::csv_table::{CsvTable, measured};
use super::located::{Located, at};
use super::pores::{self, DrawdownSection, Interpolation};
use super::sections::{MaterialSection, SceneSections};
use super::{History, Problem, TableProblem};
use crate::units::{Distance, Duration, Measure, PorePressure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The pore pressure of a material in time; what counts is its change since time 0. Give one of `points`, `file`, `fields`, `grid`, `drawdown`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PorePressureSection {
    /// `[[time, pressure], …]`, times increasing; constant outside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Points>,
    /// A CSV file with the heading `time [day],north [bar],…` and a row per time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Its column; the name of the material if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// `[[time, file], …]`, times increasing: unstructured grids of VTK (`.vtu`) with a pressure per cell or per point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fields: Option<Vec<(Measure<Duration>, PathBuf)>>,
    /// Name of the array in `fields`; `"pressure"` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub array: Option<String>,
    /// Unit of the array, such as `"bar"`; `fields` need it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// A CSV file with the heading `x [m],y [m],z [m],0 year [bar],10 year [bar],…` and a row per point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grid: Option<PathBuf>,
    /// What an element takes of `fields` or `grid`; if not given, that of the cell that holds its centre where the array is of cells, and between
    /// points the linear value of a full lattice, else the nearest point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolation: Option<Interpolation>,
    /// Largest distance of the centre of an element from the cells or points of `fields` or `grid`; 1.5 times the larger of the diameter of the
    /// element and the spacing of the points if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<Measure<Distance>>,
    /// Diffusion into a layer from a neighbour whose pressure changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drawdown: Option<DrawdownSection>,
    /// What holds between two times.
    #[serde(default, skip_serializing_if = "Between::is_linear")]
    pub between: Between,
    /// Of the files of `fields` or `grid`, which have to be those that it was taken of; the program writes it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
}

/// Times and pressures, as written.
pub type Points = Vec<(Measure<Duration>, Measure<PorePressure>)>;

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
    pub(super) fn is_linear(&self) -> bool {
        *self == Self::Linear
    }

    /// The history through some points (time [s], value).
    fn history(self, points: Vec<(f64, f64)>) -> Option<History> {
        match self {
            Self::Linear => History::through(points),
            Self::Steps => History::in_steps(points),
        }
    }
}

/// A table of one pressure in time: in the scene, or a column of a CSV file.
pub(super) struct Table<'a> {
    pub(super) points: &'a mut Option<Points>,
    pub(super) file: &'a mut Option<PathBuf>,
    pub(super) column: &'a mut Option<String>,
}

impl Table<'_> {
    /// Takes the rows of the file into the points.
    pub(super) fn fill(self, own: &str, folder: &Path) -> Result<(), TableProblem> {
        if let Some(file) = self.file.take() {
            let column = self.column.take().unwrap_or(own.into());
            let table = CsvTable::read(&folder.join(&file), &file.display().to_string())?;
            *self.points = Some(column_of(&table, &column)?);
        }
        Ok(())
    }
}

/// Takes the rows of files into the sections, so that scene, checkpoint and restart know the numbers and not a path; of fields, which may
/// be large, the digest.
pub(super) fn read_files(sections: &mut SceneSections, folder: &Path) -> Result<(), Located> {
    for (i, material) in sections.material.iter_mut().enumerate() {
        let MaterialSection {
            name,
            pore_pressure: Some(section),
            ..
        } = material
        else {
            continue;
        };
        let number = i.to_string();
        let here = ["material", number.as_str(), "pore_pressure"];
        let found = [
            section.points.is_some(),
            section.file.is_some(),
            section.fields.is_some(),
            section.grid.is_some(),
            section.drawdown.is_some(),
        ];
        let found = found.into_iter().filter(|is_there| *is_there).count();
        if found != 1 {
            let what = format!("`pore_pressure` of material \"{name}\"");
            let keys = "`points`, `file`, `fields`, `grid`, `drawdown`";
            return Err(at(&here, Problem::ExactlyOne { what, keys, found }));
        }
        require_used(section, name, &here)?;
        let place = |key: &'static str| [here[0], here[1], here[2], key];
        let table = Table {
            points: &mut section.points,
            file: &mut section.file,
            column: &mut section.column,
        };
        (table.fill(name, folder)).map_err(|problem| at(&place("file"), problem))?;
        if let Some(drawdown) = &mut section.drawdown {
            drawdown.read_file(name, folder, &here)?;
        }
        pores::digest(section, name, folder, &here)?;
    }
    Ok(())
}

/// Makes the paths of files that sections still name good from any folder.
pub(super) fn make_absolute(sections: &mut SceneSections, folder: &Path) {
    let spatial = sections.material.iter_mut();
    for section in spatial.filter_map(|m| m.pore_pressure.as_mut()) {
        let fields = section.fields.iter_mut().flatten().map(|(_, file)| file);
        let has_digest = section.digest.is_some();
        for file in fields.chain(&mut section.grid) {
            let path = pores::place(file, folder, has_digest);
            *file = std::path::absolute(&path).unwrap_or(path);
        }
    }
}

/// Refuses keys that belong to another form.
fn require_used(section: &PorePressureSection, name: &str, here: &[&str]) -> Result<(), Located> {
    let in_files = section.fields.is_some() || section.grid.is_some();
    let given = [
        (
            "column",
            section.column.is_some(),
            "file",
            section.file.is_some(),
        ),
        (
            "array",
            section.array.is_some(),
            "fields",
            section.fields.is_some(),
        ),
        (
            "unit",
            section.unit.is_some(),
            "fields",
            section.fields.is_some(),
        ),
        (
            "interpolation",
            section.interpolation.is_some(),
            "fields` or `grid",
            in_files,
        ),
        (
            "within",
            section.within.is_some(),
            "fields` or `grid",
            in_files,
        ),
        (
            "digest",
            section.digest.is_some(),
            "fields` or `grid",
            in_files,
        ),
    ];
    let stray = given.into_iter().find(|(_, given, _, of)| *given && !of);
    let what = format!("`pore_pressure` of material \"{name}\"");
    match (stray, &section.drawdown) {
        (Some((key, _, without, _)), _) => {
            let path: Vec<&str> = here.iter().copied().chain([key]).collect();
            Err(at(&path, Problem::Idle { key, what, without }))
        }
        (None, Some(_)) if !section.between.is_linear() => {
            let path: Vec<&str> = here.iter().copied().chain(["between"]).collect();
            let stray = Problem::StrayKey {
                what,
                key: "between",
                belongs: "a table",
                instead: "write it inside `drawdown`",
            };
            Err(at(&path, stray))
        }
        _ => Ok(()),
    }
}

/// Times and one column of a CSV file, unit by unit.
fn column_of(table: &CsvTable, column: &str) -> Result<Points, TableProblem> {
    let file = || table.file.clone();
    let wrong = |k: usize| TableProblem::Heading {
        file: file(),
        expected: "time [day],north [bar],…",
        order: "a name and a unit per column, time first",
        column: k + 1,
        found: table.heading[k].to_string(),
    };
    let names = &table.names;
    if names[0][0] != "time" || measured::<Duration>("1", &names[0][1]).is_err() {
        return Err(wrong(0));
    }
    let mut named = (1..names.len()).filter(|k| names[*k][0] == column);
    let place = named.next().ok_or_else(|| TableProblem::NoColumn {
        file: file(),
        column: column.into(),
        known: names[1..].iter().map(|[name, _]| name.clone()).collect(),
    })?;
    if let Some(second) = named.next() {
        return Err(TableProblem::TwoColumns {
            file: file(),
            column: column.into(),
            first: place + 1,
            second: second + 1,
        });
    }
    if measured::<PorePressure>("1", &names[place][1]).is_err() {
        return Err(wrong(place));
    }
    let mut points = Points::new();
    for row in &table.rows {
        table.require_no_surplus(row)?;
        points.push((table.quantity(row, 0)?, table.quantity(row, place)?));
    }
    let times = points.iter().map(|(time, _)| time.si());
    increasing(times, file, |k| ("row", table.rows[k].number))?;
    Ok(points)
}

/// Times [s] that increase; `line` is what a time stands in and its number, for a message.
pub(super) fn increasing(
    times: impl Iterator<Item = f64>,
    place: impl Fn() -> String,
    line: impl Fn(usize) -> (&'static str, usize),
) -> Result<(), TableProblem> {
    let times: Vec<f64> = times.collect();
    let Some(k) = times.windows(2).position(|pair| pair[0] >= pair[1]) else {
        return Ok(());
    };
    let (line, row) = line(k + 1);
    Err(TableProblem::Unsorted {
        place: place(),
        line,
        row,
        time: times[k + 1],
        before: times[k],
    })
}

/// The change since time 0 of such points against time [Pa].
pub(super) fn change(
    points: Option<&Points>,
    between: Between,
    place: impl Fn() -> String,
) -> Result<History, TableProblem> {
    let given = points.map(Vec::as_slice).unwrap_or_default();
    increasing(given.iter().map(|(t, _)| t.si()), &place, |k| {
        ("row", k + 1)
    })?;
    let si =
        |(time, pressure): &(Measure<Duration>, Measure<PorePressure>)| (time.si(), pressure.si());
    let history = between.history(given.iter().map(si).collect());
    let first = history.as_ref().map_or(0.0, |h| h.at(0.0));
    history
        .map(|history| history.less(first))
        .ok_or(TableProblem::Empty { place: place() })
}

/// Whether points differ in pressure.
pub(super) fn differ(points: Option<&Points>) -> bool {
    let given = points.map(Vec::as_slice).unwrap_or_default();
    let first = given.first();
    (given.iter()).any(|(_, p)| first.is_some_and(|(_, first)| p.si() != first.si()))
}

impl PorePressureSection {
    /// The change since time 0 against time [Pa] of a table; `None` where the pressure differs from element to element.
    pub(super) fn history(&self, name: &str) -> Result<Option<History>, TableProblem> {
        if self.is_spatial() {
            return Ok(None);
        }
        let place = || format!("`pore_pressure` of material \"{name}\"");
        change(self.points.as_ref(), self.between, place).map(Some)
    }

    /// True where the pressure differs from element to element.
    pub(super) fn is_spatial(&self) -> bool {
        self.fields.is_some() || self.grid.is_some() || self.drawdown.is_some()
    }

    /// Its first time; that of a `grid` stands in its file.
    pub(super) fn first(&self) -> Option<&Measure<Duration>> {
        let of_fields = self.fields.as_ref().and_then(|all| all.first());
        let own = self.points.as_ref();
        let points = own.or(self.drawdown.as_ref().and_then(|d| d.points.as_ref()));
        let of_points = points.and_then(|all| all.first()).map(|(time, _)| time);
        of_points.or(of_fields.map(|(time, _)| time))
    }

    /// True where it changes; fields of several times may.
    pub(super) fn varies(&self) -> bool {
        let drawdown = self.drawdown.as_ref();
        differ(self.points.as_ref())
            || drawdown.is_some_and(|d| differ(d.points.as_ref()))
            || self.fields.as_ref().is_some_and(|all| all.len() > 1)
    }
}
