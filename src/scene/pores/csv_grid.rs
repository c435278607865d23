//! Points and their pressures in time from a CSV file.

use super::cloud::{Cloud, Origin};
use crate::scene::TableProblem;
use crate::scene::csv_table::{CsvTable, measured};
use crate::scene::pore_pressure::increasing;
use crate::units::{Duration, Length, Measure, PorePressure};

/// What the heading is.
const HEADING: &str = "x [m],y [m],z [m],0 year [bar],…";

/// Reads points and times: three columns of places, then one per time.
///
/// # Errors
/// [`TableProblem`] with row and column.
pub(super) fn read(
    text: &[u8],
    file: &str,
) -> Result<(Vec<Measure<Duration>>, Cloud), TableProblem> {
    let table = CsvTable::of_text(text, file)?;
    let names = &table.names;
    let wrong = |k: usize| TableProblem::Heading {
        file: file.into(),
        expected: HEADING,
        order: "the place of a point with units, then a time and the unit of pressure per column",
        column: k + 1,
        found: table.heading.get(k).unwrap_or_default().into(),
    };
    for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let is_own = |[name, unit]: &[String; 2]| {
            name == axis && !unit.is_empty() && measured::<Length>("1", unit).is_ok()
        };
        if !names.get(k).is_some_and(is_own) {
            return Err(wrong(k));
        }
    }
    let mut times = Vec::new();
    for k in 3..names.len().max(4) {
        let time = names.get(k).and_then(|[time, unit]| {
            let time: Option<Measure<Duration>> = time.parse().ok();
            time.filter(|_| !unit.is_empty() && measured::<PorePressure>("1", unit).is_ok())
        });
        times.push(time.ok_or_else(|| wrong(k))?);
    }
    let place = || format!("{file}, row 1");
    let si = times.iter().map(Measure::si);
    increasing(si, place, |k| ("column", 4 + k))?;
    let rows = table.rows.len();
    let mut cloud = Cloud {
        file: file.into(),
        origin: Origin::Record,
        numbers: Vec::with_capacity(rows),
        points: Vec::with_capacity(rows),
        pressures: vec![Vec::with_capacity(rows); times.len()],
        cells: None,
        shapes: None,
    };
    for row in &table.rows {
        table.require_no_surplus(row)?;
        let mut point = [0.0; 3];
        for (k, x) in point.iter_mut().enumerate() {
            *x = table.quantity::<Length>(row, k)?.si();
        }
        for (k, pressures) in cloud.pressures.iter_mut().enumerate() {
            let pressure = table.quantity::<PorePressure>(row, 3 + k)?;
            pressures.push(pressure.si());
        }
        cloud.points.push(point);
        cloud.numbers.push(row.number);
    }
    if cloud.points.is_empty() {
        return Err(TableProblem::Empty { place: file.into() });
    }
    Ok((times, cloud))
}
