//! Path, shares of the states, and where slip spreads.

use super::steps::{Row, Run};
use fracas::contact::ContactState;
use fracas::scene::Body;
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Series};

/// Mean shear against mean slip, a line per mesh.
pub(super) fn path(runs: &[Run]) -> Figure {
    let mut figure = Figure::new(
        "e14_path",
        "",
        "Mean shear traction against mean slip along z: sheared until it slips; drawn apart, the shear falls with the pressure; \
         open it carries none; closed again in stick, sheared back until it slips back.",
        Axis::linear("mean slip along z [mm]"),
        Axis::linear("mean shear [MPa]"),
    );
    for run in runs {
        let points = run
            .rows
            .iter()
            .map(|row| [1e3 * row.slip(&run.body), 1e-6 * row.shear(&run.body)])
            .collect();
        let name = format!("{} cells", run.name);
        figure = figure.with(Series::new(&name, Mark::LinePoints, points));
    }
    figure
}

/// Share of the faces in every state against time.
pub(super) fn shares(run: &Run) -> Figure {
    let mut figure = Figure::new(
        "e14_shares",
        "",
        "Share of the faces per state against time, finest mesh.",
        Axis::linear("time [s]"),
        Axis::linear("share of faces [%]"),
    );
    let faces = run.body.fractures.faces.len() as f64;
    for (name, state, tone) in [
        ("stick", ContactState::Stick, 0),
        ("slip", ContactState::Slip, 1),
        ("open", ContactState::Open, 2),
    ] {
        let points = run.rows.iter().map(|row| {
            let record = &row.done.record;
            let count = record.faces[usize::from(state.code())];
            [record.time, 100.0 * count as f64 / faces]
        });
        let series = Series::new(name, Mark::LinePoints, points.collect());
        figure = figure.with(series.tone(tone));
    }
    figure
}

/// Some faces slip, others do not.
fn is_partial(row: &Row) -> bool {
    let [stick, new, slip, _] = row.done.record.faces;
    stick > 0 && new + slip > 0
}

/// Slipping faces less half of them all.
fn from_half(row: &Row) -> f64 {
    let [_, new, slip, _] = row.done.record.faces;
    let half = 0.5 * row.done.state.states.len() as f64;
    ((new + slip) as f64 - half).abs()
}

/// Mobilised friction wherever slip spreads: of the steps in a row that end in stick and slip, the one nearest to half and half.
pub(super) fn mobilised(run: &Run) -> Vec<Figure> {
    let spreading = run.rows.chunk_by(|a, b| is_partial(a) == is_partial(b));
    let halfway = spreading
        .filter(|rows| rows.iter().all(is_partial))
        .filter_map(|rows| {
            rows.iter()
                .min_by(|a, b| from_half(a).total_cmp(&from_half(b)))
        });
    let picture = |(number, row)| map(&run.body, row, number);
    halfway.enumerate().map(picture).collect()
}

/// The fracture, seen along x.
fn map(body: &Body, row: &Row, number: usize) -> Figure {
    let corner = |a: u32| {
        let [_, y, z] = body.mesh.nodes[a as usize];
        [y, z]
    };
    let faces = &body.fractures.faces;
    let end = |axis: usize| body.mesh.nodes.iter().fold(0.0, |m: f64, x| m.max(x[axis]));
    let mut figure = Figure::new(
        &format!("e14_mobilised_{}", number + 1),
        "",
        &format!(
            "Shear over its limit on the fracture at {} s, finest mesh: faces at 1 slip; 0.9 and below in one colour.",
            row.done.record.time
        ),
        Axis::linear("y [m]").range(0.0, end(1)),
        Axis::linear("z [m]").range(0.0, end(2)),
    );
    figure.cells = Some(Cells {
        colors: Colors::Diverging,
        label: "shear over limit".into(),
        quads: faces.iter().map(|f| f.minus.nodes.map(corner)).collect(),
        values: row.fields.criticality.clone(),
        range: [0.9, 1.0],
    });
    figure.equal_aspect = true;
    figure
}
