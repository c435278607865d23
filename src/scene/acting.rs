//! Whether tables of times act within a run.

use super::Problem;
use super::located::{Located, at};
use super::sections::SceneSections;
use crate::units::{Duration, Measure};

/// A factor in time, as written.
type Factors = Option<Vec<(Measure<Duration>, f64)>>;

/// A table whose values differ.
struct Varying<'a> {
    /// Where it is written.
    path: Vec<String>,
    key: &'static str,
    what: String,
    first: &'a Measure<Duration>,
}

/// Refuses tables that vary where time stands still, or after the run is over.
pub(super) fn require_time(sections: &SceneSections) -> Result<(), Located> {
    varying(sections)
        .into_iter()
        .try_for_each(|table| require_time_of(sections, table))
}

/// The same for fields of pressure of a material, whose first time stands in their file.
pub(super) fn require_time_for(
    sections: &SceneSections,
    material: usize,
    first: &Measure<Duration>,
) -> Result<(), Located> {
    let key = "pore_pressure";
    let table = Varying {
        path: vec!["material".into(), material.to_string(), key.into()],
        key,
        what: format!("material \"{}\"", sections.material[material].name),
        first,
    };
    require_time_of(sections, table)
}

fn require_time_of(sections: &SceneSections, table: Varying<'_>) -> Result<(), Located> {
    let Varying {
        path,
        key,
        what,
        first,
    } = table;
    let problem = match &sections.time {
        None => Problem::Timeless { key, what },
        Some(time) if first.si() >= time.end.si() => Problem::Late {
            key,
            what,
            first: first.to_string(),
            end: time.end.to_string(),
        },
        Some(_) => return Ok(()),
    };
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    Err(at(&path, problem))
}

/// All tables of a scene whose values differ.
fn varying(sections: &SceneSections) -> Vec<Varying<'_>> {
    let mut all = Vec::new();
    for (i, m) in sections.material.iter().enumerate() {
        let (key, what) = ("pore_pressure", format!("material \"{}\"", m.name));
        if let Some(table) = m.pore_pressure.as_ref().filter(|table| table.varies()) {
            all.extend(table.first().map(|first| Varying {
                path: vec!["material".into(), i.to_string(), key.into()],
                key,
                what: what.clone(),
                first,
            }));
        }
        let place = ["material", &i.to_string()];
        all.extend(factors(
            &place,
            "pressure_history",
            what,
            &m.pressure_history,
        ));
    }
    for (i, f) in sections.fracture.iter().enumerate() {
        let (what, number) = (format!("fracture \"{}\"", f.name), i.to_string());
        let place = ["fracture", &number];
        all.extend(factors(
            &place,
            "pressure_history",
            what,
            &f.pressure_history,
        ));
    }
    for (i, b) in sections.boundary.iter().enumerate() {
        let place = ["boundary", &i.to_string()];
        all.extend(factors(&place, "history", b.place(), &b.history));
    }
    for (i, s) in sections.source.iter().enumerate() {
        let place = ["source", &i.to_string()];
        all.extend(factors(&place, "history", s.name(), &s.history));
    }
    for (i, w) in sections.well.iter().enumerate() {
        let (what, number) = (format!("[[well]] \"{}\"", w.name), i.to_string());
        all.extend(factors(&["well", &number], "history", what, &w.history));
    }
    if let Some(time) = &sections.time {
        all.extend(factors(
            &["time"],
            "history",
            "[time]".into(),
            &time.history,
        ));
    }
    all
}

/// A factor in time, where it differs.
fn factors<'a>(
    place: &[&str],
    key: &'static str,
    what: String,
    written: &'a Factors,
) -> Option<Varying<'a>> {
    let rows = written.as_ref()?;
    let (first, factor) = rows.first()?;
    let varies = rows.iter().any(|row| row.1 != *factor);
    varies.then(|| Varying {
        path: (place.iter().chain([&key]))
            .map(|segment| (*segment).to_owned())
            .collect(),
        key,
        what,
        first,
    })
}
