//! e19: a tilted well through nine fractures.

use crate::flow_runs::{FlowRun, table};
use crate::report::{Check, Experiment, Findings, Level, Panels, Table};
use crate::scenes::with_cells;
use fracas::nonlinear::FaceFields;
use fracas::scene::Scene;
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Series};
use fracas_solvers::Observer;

/// What do the fractures do while a well that crosses them injects and withdraws?
#[derive(Debug)]
pub struct TiltedWell;

/// The scene, with cells of 1 m.
const SCENE: &str = include_str!("e19_tilted_well.toml");

/// Of the block [m].
const LENGTHS: [usize; 3] = [40, 40, 200];

/// The fracture that pictures show: the one in the middle.
const SHOWN: u16 = 4;

/// Times of the pictures [s]: rising, most, just turned, withdrawn, at the end.
const TIMES: [f64; 5] = [1.5, 3.0, 3.25, 4.0, 5.0];

/// Pressure that holds the fractures closed [Pa].
const CLOSING: f64 = 5e6;

impl Experiment for TiltedWell {
    fn id(&self) -> &'static str {
        "e19"
    }

    fn title(&self) -> &'static str {
        "A tilted well through nine fractures"
    }

    fn question(&self) -> &'static str {
        "What do fractures do while a well that crosses them injects for 3 s, ever more, and withdraws then?"
    }

    fn setup(&self) -> &'static str {
        "A block of 40 m × 40 m × 200 m under 5 MPa on nine level fractures of 24 m × 24 m; a well of 0.05 m cuts each of them in another place; its rate \
         grows to 90 L/s in 3 s, then 45 L/s are withdrawn until 5 s. Paper cells of 1 m, 40 steps: the printed sizes are those of 40 × 40 × 200 cells with nine fractures of \
         24 × 24 faces, n_u = 3(41·41·201 + 9·23²). Smoke cells of 4 m, 10 steps. Place of fractures and well, stress and rates are not printed."
    }

    fn expect(&self) -> &'static str {
        "The pressure of the well stays above what holds the fractures closed while fluid is injected; no volume is lost; at most 25 Krylov \
         iterations and six Newton steps in the median."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("scene", SCENE).set("level", level.word());
        let (size, steps, printed) = match level {
            Level::Smoke => (4, 10, "not printed"),
            Level::Paper => (1, 40, "1,027,926 + 15,552 + 5,184"),
        };
        let cells = LENGTHS.map(|length| length / size);
        let scene = Scene::from_toml(SCENE, "e19_tilted_well.toml")?;
        let scene = scene.with_overrides(&[format!("time.steps={steps}")])?;
        let scene = with_cells(&scene, cells)?;
        let [x, y, z] = cells;
        let run = FlowRun::of(&format!("{x} × {y} × {z}"), &scene, observer)?;
        let mut sheet = table(
            "e19_tilted_well",
            "Iterations; medians over the steps with flow.",
        );
        sheet.rows.push(run.row(printed));
        let mut history = Table::new(
            "e19_history",
            "The well and the fractures in time.",
            &[
                "time [s]",
                "rate [L/s]",
                "pressure of the well [MPa]",
                "volume in the fractures [L]",
                "open",
                "slip",
            ],
        );
        let (mut volume, mut pressure, mut held) = (0.0, Vec::new(), Vec::new());
        let mut least = f64::INFINITY;
        for step in &run.steps {
            let (Some(flow), Some(well)) = (step.flow, step.wells.first()) else {
                continue;
            };
            let time = step.record.time;
            volume += flow.stored_opening;
            pressure.push([time, 1e-6 * well.pressure]);
            held.push([time, 1e3 * volume]);
            if well.rate > 0.0 {
                least = least.min(well.pressure);
            }
            history.rows.push(vec![
                time.into(),
                (1e3 * well.rate).into(),
                (1e-6 * well.pressure).into(),
                (1e3 * volume).into(),
                step.record.faces[3].into(),
                step.record.faces[2].into(),
            ]);
        }
        findings.checks.extend(run.checks());
        findings.checks.push(Check::at_least(
            "least pressure of the well while it injects, over what closes the fractures",
            1.0,
            least / CLOSING,
        ));
        findings.tables.extend([sheet, history]);
        let figure = |id: &str, caption: &str, axis: &str, points| {
            Figure::new(
                id,
                "",
                caption,
                Axis::linear("time [s]"),
                Axis::linear(axis),
            )
            .with(Series::new("", Mark::LinePoints, points))
        };
        findings.figures.push(figure(
            "e19_pressure",
            "Pressure of the well: it rises until the fractures open, and follows their opening.",
            "pressure [MPa]",
            pressure,
        ));
        findings.figures.push(figure(
            "e19_volume",
            "Volume in the open fractures.",
            "volume [L]",
            held,
        ));
        findings.panels = pictures(&run);
        Ok(findings)
    }
}

/// A quantity of the faces that is shown.
type Quantity = (&'static str, &'static str, fn(&FaceFields, usize) -> f64);

/// Pressure, aperture and slip of the fracture in the middle at five times, each with one scale.
fn pictures(run: &FlowRun) -> Vec<Panels> {
    const QUANTITIES: [Quantity; 3] = [
        ("pressure", "pressure [MPa]", |fields, f| {
            1e-6 * fields.pressure[f]
        }),
        ("aperture", "aperture [mm]", |fields, f| {
            1e3 * fields.aperture[f]
        }),
        ("slip", "slip [mm]", |fields, f| 1e3 * fields.slip[f]),
    ];
    let faces = &run.body.fractures.faces;
    let shown = (0..faces.len()).filter(|f| faces[*f].fracture == SHOWN);
    let shown: Vec<usize> = shown.collect();
    let place = |node: u32| {
        let [x, y, _] = run.body.mesh.nodes[node as usize];
        [x, y]
    };
    let quads: Vec<_> = (shown.iter().map(|f| faces[*f].minus.nodes.map(place))).collect();
    // the step at each time, or the one after it
    let steps = TIMES.map(|time| {
        let reached = |step: &fracas::nonlinear::Accepted| step.record.time >= time - 1e-9;
        let at = run.steps.iter().position(reached);
        at.unwrap_or(run.steps.len() - 1)
    });
    let panels = QUANTITIES.iter().map(|(id, label, of)| {
        let values = steps.map(|k| shown.iter().map(|f| of(&run.fields[k], *f)).collect());
        let all = || values.iter().flat_map(|v: &Vec<f64>| v.iter().copied());
        let [least, most] = [
            all().fold(f64::INFINITY, f64::min),
            all().fold(f64::NEG_INFINITY, f64::max),
        ];
        let picture = |(k, values): (usize, &Vec<f64>)| {
            let mut figure = Figure::new(
                &format!("e19_{id}_{}", k + 1),
                &format!("t = {} s", run.steps[steps[k]].record.time),
                "",
                Axis::linear("x [m]"),
                Axis::linear("y [m]"),
            );
            figure.cells = Some(Cells {
                label: (*label).into(),
                colors: Colors::Sequential,
                quads: quads.clone(),
                values: values.clone(),
                range: [least, if most > least { most } else { least + 1.0 }],
            });
            figure.equal_aspect = true;
            figure
        };
        Panels {
            title: String::new(),
            caption: format!("The fracture in the middle, at a height of 100 m: {label}, one scale for all times."),
            figures: values.iter().enumerate().map(picture).collect(),
        }
    });
    panels.collect()
}
