//! e19: a tilted well through four fractures.

use crate::flow_runs::{FlowRun, table};
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Check, Experiment, Findings, Level, Table};
use fracas::scene::Scene;
use fracas_solvers::Observer;

/// What do the fractures do while a well that crosses them injects and withdraws?
#[derive(Debug)]
pub struct TiltedWell;

/// The scene, on 24 cells per axis.
const SCENE: &str = include_str!("e19_tilted_well.toml");

/// Pressure that holds the fractures closed [Pa].
const CLOSING: f64 = 5e6;

impl Experiment for TiltedWell {
    fn id(&self) -> &'static str {
        "e19"
    }

    fn title(&self) -> &'static str {
        "A tilted well through four fractures"
    }

    fn question(&self) -> &'static str {
        "What do fractures do while a well that crosses them injects for 3 s, ever more, and withdraws then?"
    }

    fn setup(&self) -> &'static str {
        "A cube of 24 m under 5 MPa on four parallel fractures of 12 m × 12 m; a well of 0.05 m cuts each of them in another place; its rate \
         grows to 20 L/s in 3 s, then 10 L/s are withdrawn until 5 s. Paper 72 cells per axis, n_p as printed, 40 steps; smoke 12 cells, 10 \
         steps. Place and size of fractures and well are not printed."
    }

    fn expect(&self) -> &'static str {
        "The pressure of the well stays above what holds the fractures closed while fluid is injected; no volume is lost; at most 25 Krylov \
         iterations and six Newton steps in the median."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("scene", SCENE).set("level", level.word());
        let (cells, steps, printed) = match level {
            Level::Smoke => (12, 10, "not printed"),
            Level::Paper => (72, 40, "1,027,926 + 15,552 + 5,184"),
        };
        let sets = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells={cells}"));
        let sets = [&sets[..], &[format!("time.steps={steps}")]].concat();
        let scene = Scene::from_toml(SCENE, "e19_tilted_well.toml")?.with_overrides(&sets)?;
        let run = FlowRun::of(&format!("{cells}³"), &scene, observer)?;
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
        Ok(findings)
    }
}
