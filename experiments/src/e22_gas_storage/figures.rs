//! Slipping area, dip slip and energies in time, criticality on the central fault.

use super::run::{Run, Stage};
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Series};

/// Slipping area of every fault against time.
pub(super) fn area(run: &Run) -> Figure {
    let mut figure = Figure::new(
        "e22_area",
        "",
        "Slipping area of every fault in time: production to year 10, cushion gas to year 12, then storage.",
        Axis::linear("time [year]"),
        Axis::linear("slipping area [km²]"),
    );
    for (k, name) in run.body.fractures.names.iter().enumerate() {
        let points = run.years.iter();
        let points = points
            .map(|y| [y.time, 1e-6 * y.faults[k].slipping_area])
            .collect();
        figure = figure.with(Series::new(name, Mark::LinePoints, points));
    }
    figure
}

/// Mean slip of the central fault along its dip, a line per variation.
pub(super) fn dip_slip(runs: &[Run]) -> Figure {
    let mut figure = Figure::new(
        "e22_dip_slip",
        "",
        "Mean slip of the central fault along its dip in time, the eastern block up: it goes back when cushion gas comes in.",
        Axis::linear("time [year]"),
        Axis::linear("mean dip slip [mm]"),
    );
    for run in runs {
        let points = run.years.iter().map(|y| [y.time, y.dip_slip]).collect();
        figure = figure.with(Series::new(&run.name, Mark::LinePoints, points));
    }
    figure
}

/// What friction and creep dissipate in a year.
pub(super) fn energy(run: &Run, stiff: &Run) -> Figure {
    let mut figure = Figure::new(
        "e22_energy",
        "",
        "Energy that friction and creep dissipate in a year. The salt starts at rest.",
        Axis::linear("time [year]"),
        Axis::linear("energy [TJ]"),
    );
    for (name, run, creep) in [
        ("creep of the salt", run, true),
        ("friction", run, false),
        ("friction, salt does not creep", stiff, false),
    ] {
        let points = run.years.iter().map(|y| {
            let energy = match creep {
                true => y.energy.creep_dissipation,
                false => y.energy.dissipation,
            };
            [y.time, 1e-12 * energy]
        });
        figure = figure.with(Series::new(name, Mark::LinePoints, points.collect()));
    }
    figure
}

/// χ on the central fault at the end of every stage.
pub(super) fn criticality(run: &Run) -> Vec<Figure> {
    let stages = [Stage::Production, Stage::Cushion, Stage::Storage];
    let body = &run.body;
    let own = |f: &usize| body.fractures.faces[*f].fracture == 0;
    let faces: Vec<usize> = (0..body.fractures.faces.len()).filter(own).collect();
    let corner = |a: u32| {
        let [_, y, z] = body.mesh.nodes[a as usize];
        [y, z]
    };
    let picture = |(k, stage): (usize, Stage)| {
        let year = run.years.iter().rfind(|y| y.stage == stage)?;
        let mut figure = Figure::new(
            &format!("e22_chi_{}", k + 1),
            "",
            &format!(
                "Criticality χ on the central fault at the end of the stage {}, year {:.0}.",
                stage.word(),
                year.time
            ),
            Axis::linear("y [m]").range(0.0, 1500.0),
            Axis::linear("z [m]").range(-2500.0, -1900.0),
        );
        figure.cells = Some(Cells {
            colors: Colors::Diverging,
            label: "χ".into(),
            quads: faces
                .iter()
                .map(|f| body.fractures.faces[*f].minus.nodes.map(corner))
                .collect(),
            values: faces.iter().map(|f| year.fields.criticality[*f]).collect(),
            range: [0.0, 1.0],
        });
        figure.equal_aspect = true;
        Some(figure)
    };
    stages.into_iter().enumerate().filter_map(picture).collect()
}
