//! The history of a run as curves, and its fractures at the end, as a page.

use super::faces;
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{FIGURES, Findings, Sheet, Table};
use anyhow::Context;
use fracas::run::{History, Running};
use fracas::scene::Scene;
use std::path::Path;

/// Writes `figures/` and `report.html` of a run.
///
/// # Errors
/// Those of the files.
pub fn write(scene: &Scene, lead: &str, run: &Running<'_>, out: &Path) -> anyhow::Result<()> {
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
            let written = std::fs::read_to_string(out.join("energy.csv"));
            findings
                .figures
                .extend(written.ok().and_then(|t| energy(&t)));
        }
        let (maps, notes) = faces::figures(run);
        findings.figures.extend(maps);
        findings.notes = notes;
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
    sheet.write(out)
}

fn curve(rows: &History, x: &str, y: &str, name: &str) -> Series {
    let points = rows.column(x).zip(rows.column(y));
    let points = points.map(|(x, y)| [x, y]).collect();
    Series::new(name, Mark::LinePoints, points)
}

fn states(rows: &History) -> Figure {
    let of = |y, name| curve(rows, "time_s", y, name);
    Figure::new(
        "states",
        "",
        "Fracture faces in each contact state at the end of a step.",
        Axis::linear("time [s]"),
        Axis::linear("faces"),
    )
    .with(of("stick", "stick"))
    .with(of("newslip", "new-slip"))
    .with(of("slip", "slip"))
    .with(of("open", "open"))
}

fn iterations(rows: &History) -> Figure {
    let of = |y, name| curve(rows, "step", y, name);
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
    Figure::new(
        "slip",
        "",
        "Largest slip of a face at the end of a step.",
        Axis::linear("time [s]"),
        Axis::linear("largest slip [m]"),
    )
    .with(curve(rows, "time_s", "slip_max_m", ""))
}

/// What loads have done, and where it went, from `energy.csv`, a row per step; none for a file of another form.
fn energy(csv: &str) -> Option<Figure> {
    let mut lines = csv.lines();
    let heading: Vec<&str> = lines.next()?.split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|x| x.parse().ok()).collect())
        .collect::<Option<_>>()?;
    let column = |name: &str| heading.iter().position(|h| *h == name);
    let time = column("time_s")?;
    let summed = |names: &[&str], name: &str| {
        let columns = names.iter().filter_map(|n| column(n));
        let columns: Vec<usize> = columns.collect();
        let points = rows.iter().scan(0.0, |sum, row| {
            *sum += columns.iter().map(|k| row[*k]).sum::<f64>();
            Some([row[time], *sum])
        });
        Series::new(name, Mark::LinePoints, points.collect())
    };
    let figure = Figure::new(
        "energy",
        "",
        "Energy since the beginning: work of the loads and of fluid pressures, what is stored in the rock, what friction dissipates.",
        Axis::linear("time [s]"),
        Axis::linear("energy [J]"),
    )
    .with(summed(&["external_work_J", "pressure_work_J"], "work"))
    .with(summed(&["elastic_change_J"], "stored"))
    .with(summed(&["dissipation_J"], "dissipated"));
    Some(figure)
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
    fn energies_are_summed_over_the_steps() {
        let csv =
            "step,time_s,external_work_J,elastic_change_J,dissipation_J\n0,0,3,2,1\n1,0.5,1,-1,2\n";
        let figure = energy(csv).unwrap();
        let ends = figure.series.iter().map(|s| s.points[1]);
        let ends: Vec<[f64; 2]> = ends.collect();
        assert_eq!(ends, [[0.5, 4.0], [0.5, 1.0], [0.5, 3.0]]);
        assert!(energy("step\n1\n").is_none());
        assert!(energy("time_s,dissipation_J\n0,x\n").is_none());
    }
}
