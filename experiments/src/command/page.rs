//! The history of a run as curves and as a page.

use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Findings, Sheet, Table};
use fracas::run::History;
use fracas::scene::Scene;
use std::path::Path;

/// Writes `figures/` and `report.html`.
pub(super) fn write(scene: &Scene, lead: &str, rows: &History, out: &Path) -> anyhow::Result<()> {
    let mut findings = Findings::default();
    let sections = serde_json::to_value(scene.sections())?;
    if let serde_json::Value::Object(sections) = sections {
        findings.settings = sections;
    }
    if rows.is_empty() {
        findings.notes.push("No step was accepted.".into());
    } else {
        findings.figures = vec![states(rows), iterations(rows), slip(rows)];
        findings.tables.push(totals(rows));
    }
    let sheet = Sheet {
        title: scene.title(),
        lead,
        findings: &findings,
    };
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

/// Sums and extremes over all steps.
fn totals(rows: &History) -> Table {
    let sum = |name| rows.column(name).sum::<f64>() as usize;
    let most = |name| rows.column(name).fold(0.0, f64::max);
    let mut table = Table::new(
        "totals",
        "The whole run; history.csv has a row per step, solver.csv one per linear solve.",
        &[
            "steps",
            "active set",
            "Newton",
            "Krylov",
            "step cuts",
            "largest relative residual of a linear solve",
            "largest penetration [m]",
            "largest excess of shear [Pa]",
            "largest slip [m]",
            "largest jump by the stabilization [m]",
            "largest overlap by it [m]",
        ],
    );
    table.push([
        rows.len().into(),
        sum("active_it").into(),
        sum("newton_it").into(),
        sum("lin_it").into(),
        sum("cuts").into(),
        most("lin_res").into(),
        most("max_pen").into(),
        most("max_tau_viol").into(),
        most("slip_max_m").into(),
        most("h_jump_max_m").into(),
        most("h_overlap_max_m").into(),
    ]);
    table
}
