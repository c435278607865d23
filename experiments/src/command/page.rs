//! A run as a page: its history as curves, the body in sections and every fracture at steps that tell most.

mod body;
mod fractures;
mod ground;
mod steps;
mod unit;
mod written;

use crate::report::{FIGURES, Findings, Formats, Panels, Sheet, Table};
use anyhow::Context;
use fracas::run::{History, Running};
use fracas::scene::Scene;
use fracas_figures::{Axis, Figure, Mark, Series};
use ground::{Moment, Scale};
use std::path::Path;
pub use steps::PageSteps;

/// Pieces of all maps of a page: some megabytes.
const PIECES: usize = 200_000;

/// Pieces of one map: more could not be told apart.
const PIECES_OF_MAP: usize = 12_000;

/// Points of a curve: more could not be told apart.
const POINTS: usize = 400;

/// Points of a curve that have markers.
const MARKED: usize = 100;

/// Writes `figures/` and `report.html` of a run.
///
/// # Errors
/// Those of the files.
pub fn write(
    scene: &Scene,
    lead: &str,
    run: &Running<'_>,
    steps: &PageSteps,
    out: &Path,
) -> anyhow::Result<()> {
    let rows = run.history();
    let mut findings = Findings::default();
    let sections = serde_json::to_value(scene.sections())?;
    if let serde_json::Value::Object(sections) = sections {
        findings.settings = sections;
    }
    if rows.is_empty() {
        findings.notes.push("No step was accepted.".into());
    } else {
        if rows.len() > 1 {
            findings.figures = vec![states(rows), iterations(rows), slip(rows)];
            let of = |file: &str| written::Rows::read(&out.join(file));
            (findings.figures).extend(of("energy.csv").and_then(|rows| written::energy(&rows)));
            if let Some(rows) = of("flow.csv") {
                findings.figures.extend(written::volumes(&rows));
                findings.figures.extend(written::wells(&rows));
            }
        }
        (findings.panels, findings.notes) = maps(run, steps)?;
        findings.tables.extend(onsets(run));
        findings.tables.push(totals(rows));
    }
    let sheet = Sheet {
        title: scene.title(),
        lead,
        findings: &findings,
    };
    // a run that went on from an earlier step may have shown other fractures
    match std::fs::remove_dir_all(out.join(FIGURES)) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("cannot clear {}", out.join(FIGURES).display()))?;
        }
        _ => {}
    }
    sheet.write(out, Formats::default())
}

/// Sections of the body and every fracture at these steps, and what is to be said.
fn maps(run: &Running<'_>, steps: &PageSteps) -> anyhow::Result<(Vec<Panels>, Vec<String>)> {
    let with_fields: Vec<usize> = run.steps_with_fields().iter().map(|(s, _)| *s).collect();
    let (chosen, mut notes) = steps.choose(run.history(), &with_fields);
    let body = run.simulation().problem().body();
    if chosen.is_empty() {
        return Ok((Vec::new(), notes));
    }
    let of_fractures = fractures::figures(body);
    let share = |figures: usize| (PIECES / (chosen.len() * figures).max(1)).min(PIECES_OF_MAP);
    let most = |sections| share(body::figures(sections) + of_fractures);
    let mut sections = body::Sections::new(body, most);
    let mut fractures = fractures::Fractures::new(body, most(sections.len()));
    let (mut moments, mut scale) = (Vec::new(), Scale::default());
    for step in chosen {
        let Some(stored) = run.stored(step.step)? else {
            continue;
        };
        scale.add(&stored);
        sections.add(body, &stored);
        fractures.add(&stored);
        moments.push(Moment {
            step: step.step,
            title: format!("step {}, t = {}", step.step, unit::time(stored.time)),
            why: step.why,
        });
    }
    let (mut panels, same) = sections.panels(body, &moments, scale);
    notes.extend(same);
    let (more, same) = fractures.panels(&moments, scale);
    panels.extend(more);
    notes.extend(same);
    Ok((panels, notes))
}

/// A curve through as many points as can be told apart: of more, the least and the largest of each piece.
fn series(name: &str, points: Vec<[f64; 2]>) -> Series {
    let mark = match points.len() {
        ..=MARKED => Mark::LinePoints,
        _ => Mark::Line,
    };
    let each = points.len().div_ceil(POINTS / 2);
    if points.len() <= POINTS {
        return Series::new(name, mark, points);
    }
    let ends = |piece: &[[f64; 2]]| {
        let by = |a: &[f64; 2], b: &[f64; 2]| a[1].total_cmp(&b[1]);
        let found = [
            piece.iter().copied().min_by(by),
            piece.iter().copied().max_by(by),
        ];
        let mut found: Vec<[f64; 2]> = found.into_iter().flatten().collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        found
    };
    let mut thin: Vec<[f64; 2]> = points.chunks(each).flat_map(ends).collect();
    thin.insert(0, points[0]);
    thin.extend(points.last());
    Series::new(name, mark, thin)
}

/// Of these times [s], in a unit that fits the last of them, and how many seconds that has.
fn time_axis(times: impl Iterator<Item = f64>) -> (Axis, f64) {
    let (unit, length) = unit::of_times(times.fold(0.0, f64::max));
    (Axis::linear(&format!("time [{unit}]")), length)
}

/// A column over time, both in units that fit.
fn over_time(rows: &History, y: &str, (length, factor): (f64, f64), name: &str) -> Series {
    let points = rows.column("time_s").zip(rows.column(y));
    series(
        name,
        points.map(|(t, y)| [t / length, factor * y]).collect(),
    )
}

fn states(rows: &History) -> Figure {
    let (times, length) = time_axis(rows.column("time_s"));
    let of = |y, name| over_time(rows, y, (length, 1.0), name);
    Figure::new(
        "states",
        "",
        "Fracture faces in each contact state at the end of a step.",
        times,
        Axis::linear("faces"),
    )
    .with(of("stick", "stick"))
    .with(of("newslip", "new-slip"))
    .with(of("slip", "slip"))
    .with(of("open", "open"))
}

fn iterations(rows: &History) -> Figure {
    let of = |y, name| {
        let points = rows.column("step").zip(rows.column(y));
        series(name, points.map(|(x, y)| [x, y]).collect())
    };
    Figure::new(
        "iterations",
        "",
        "Iterations of the three cycles, summed over a step.",
        Axis::linear("step"),
        Axis::log("iterations"),
    )
    .with(of("active_it", "active set"))
    .with(of("newton_it", "Newton"))
    .with(of("lin_it", "Krylov"))
}

fn slip(rows: &History) -> Figure {
    let (times, length) = time_axis(rows.column("time_s"));
    let largest = rows.column("slip_max_m").fold(0.0, f64::max);
    let (unit, factor) = unit::Kind::Length.unit(largest);
    Figure::new(
        "slip",
        "",
        "Largest slip of a face at the end of a step.",
        times,
        Axis::linear(&format!("largest slip [{unit}]")),
    )
    .with(over_time(rows, "slip_max_m", (length, factor), ""))
}

/// When slip began, where the run looked for it and found it.
fn onsets(run: &Running<'_>) -> Option<Table> {
    let mut table = Table::new(
        "onset",
        "When slip begins on a fracture, and where; onset.csv has a row per onset.",
        &[
            "fracture",
            "begins",
            "not yet at [s]",
            "by [s]",
            "by",
            "x [m]",
            "y [m]",
            "z [m]",
            "largest patch [m²]",
            "α Δp, minus side [MPa]",
            "α Δp, plus side [MPa]",
        ],
    );
    let mut is_empty = true;
    for (fracture, onset) in run.onsets() {
        is_empty = false;
        let [x, y, z] = onset.center;
        let [minus, plus] = onset.drained.map(|p| p / 1e6);
        table.push([
            fracture.into(),
            onset.begins.name().into(),
            onset.before.map_or_else(|| "".into(), Into::into),
            onset.after.into(),
            unit::time(onset.after).as_str().into(),
            x.into(),
            y.into(),
            z.into(),
            onset.area.into(),
            minus.into(),
            plus.into(),
        ]);
    }
    (!is_empty).then_some(table)
}

/// Sums and extremes over all steps.
fn totals(rows: &History) -> Table {
    let sum = |name| rows.column(name).sum::<f64>() as usize;
    let most = |name| rows.column(name).fold(0.0, f64::max);
    let mut table = Table::new(
        "totals",
        "The whole run; history.csv has a row per step, solver.csv one per linear solve.",
        &["over all steps", "value"],
    );
    for (what, count) in [
        ("steps", rows.len()),
        ("rounds of the active set", sum("active_it")),
        ("Newton steps", sum("newton_it")),
        ("Krylov iterations", sum("lin_it")),
        ("step cuts", sum("cuts")),
    ] {
        table.push([what.into(), count.into()]);
    }
    for (what, name) in [
        ("largest relative residual of a linear solve", "lin_res"),
        ("largest penetration [m]", "max_pen"),
        ("largest excess of shear [Pa]", "max_tau_viol"),
        ("largest slip [m]", "slip_max_m"),
        ("largest jump by the stabilization [m]", "h_jump_max_m"),
        ("largest overlap by it [m]", "h_overlap_max_m"),
    ] {
        table.push([what.into(), most(name).into()]);
    }
    table
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn long_curves_keep_their_ends_and_peaks() {
        let mut points: Vec<[f64; 2]> = (0..10_000).map(|k| [f64::from(k), 0.0]).collect();
        points[7_531][1] = 5.0;
        points[123][1] = -2.0;
        let thin = series("", points);
        assert!(thin.points.len() <= POINTS + 2);
        assert_eq!(thin.points[0], [0.0, 0.0]);
        assert_eq!(thin.points.last(), Some(&[9_999.0, 0.0]));
        assert!(thin.points.contains(&[7_531.0, 5.0]) && thin.points.contains(&[123.0, -2.0]));
        assert!(thin.points.is_sorted_by(|a, b| a[0] <= b[0]));
    }
}
