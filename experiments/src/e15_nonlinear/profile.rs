//! What the steps of three scenes cost, by multipliers and by springs.

use super::fault::fractured;
use super::run::{Counts, Run, Way};
use crate::report::{Cell, Check, Findings, Level, Table};
use fracas::scene::{Scene, named};
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::Observer;

/// A scene with what makes it a path in time.
struct Case {
    name: &'static str,
    /// In the gallery; else the fault of the comparison of methods.
    scene: Option<&'static str>,
    overrides: &'static [&'static str],
}

const CASES: [Case; 3] = [
    Case {
        name: "cycle of states",
        scene: Some("cycle"),
        overrides: &["time.steps=20"],
    },
    // pressed, then sheared forth and back
    Case {
        name: "fault in a plate",
        scene: None,
        overrides: &[
            "solver.tolerance=1e-8",
            "time={ end = '3 s', steps = 12 }",
            "boundary.4.history=[['0 s', 0.0], ['1 s', 1.0], ['3 s', -1.0]]",
        ],
    },
    // the side is pressed, let go and drawn
    Case {
        name: "crossing",
        scene: Some("crossing"),
        overrides: &[
            "mesh.map.incline.plane=x",
            "mesh.map.incline.dip=60 deg",
            "mesh.map.incline.fade=true",
            "fracture.upright.friction_angle=15 deg",
            "fracture.flat.friction_angle=15 deg",
            "time={ end = '1 s', steps = 8, history = [['0 s', 1.0], ['1 s', 1.0]] }",
            "boundary.2.history=[['0 s', 1.0], ['1 s', -1.0]]",
        ],
    },
];

/// Ways that are compared on every scene.
const WAYS: [Way; 4] = [
    Way::Lagrange,
    Way::Penalty(1e2),
    Way::Penalty(1e4),
    Way::Augmented(1e1),
];

/// Largest Krylov iterations of multipliers per Newton step with an unsymmetric J over those with a symmetric one.
const GROWTH: f64 = 2.5;

impl Case {
    fn scene(&self, level: Level) -> anyhow::Result<Scene> {
        let named = |name| named(name).ok_or_else(|| anyhow::anyhow!("no scene {name}"));
        let scene = match (self.scene, level) {
            (Some(name), Level::Smoke) => named(name)?.small_scene()?,
            (Some(name), Level::Paper) => named(name)?.scene()?,
            (None, Level::Smoke) => fractured(16)?,
            (None, Level::Paper) => fractured(32)?,
        };
        let scene = scene.with_overrides(self.overrides)?;
        Ok(scene.with_overrides(&["solver.inner=exact", "solver.measure=residual"])?)
    }
}

fn steps_table() -> Table {
    let mut headings = vec!["scene", "step", "time [s]", "stick", "slip", "open"];
    headings.extend(Counts::HEADINGS);
    Table::new(
        "e15_steps",
        "Lagrange multipliers: what every step costs. J is symmetric where all faces stick.",
        &headings,
    )
}

fn totals_table() -> Table {
    let mut headings = vec!["scene", "n_u", "n_t", "method", "κω", "steps"];
    headings.extend(Counts::HEADINGS);
    headings.push("time [s]");
    Table::new(
        "e15_totals",
        "Whole runs. Rounds: of the active set for multipliers, updates of the multipliers for springs. J of springs is symmetric \
         where no face slips. X: a step failed after every halving. Processor time of one thread, the least of three runs.",
        &headings,
    )
}

fn steps_figure(number: usize, case: &Case, run: &Run) -> Figure {
    let series = |name: &str, value: fn(&Counts) -> usize| {
        let points = run.steps.iter().map(|s| {
            let counts = Counts::of(s);
            [s.record.step as f64, value(&counts) as f64]
        });
        Series::new(name, Mark::LinePoints, points.collect())
    };
    Figure::new(
        &format!("e15_steps_{number}"),
        "",
        &format!(
            "{}: rounds, Newton steps and Krylov iterations of every step, Lagrange multipliers.",
            case.name
        ),
        Axis::linear("step"),
        Axis::log("iterations per step"),
    )
    .with(series("Krylov", |c| c.krylov))
    .with(series("Newton", |c| c.newton))
    .with(series("active set", |c| c.rounds))
}

/// All scenes, all ways.
pub(super) fn profile(
    level: Level,
    findings: &mut Findings,
    observer: &mut dyn Observer,
) -> anyhow::Result<()> {
    let (mut steps, mut totals) = (steps_table(), totals_table());
    for (number, case) in CASES.iter().enumerate() {
        let scene = case.scene(level)?;
        for way in WAYS {
            let run = Run::timed(level, &scene.with_overrides(&[way.setting()])?, observer)?;
            let size = scene.build()?;
            let mut row: Vec<Cell> = vec![
                case.name.into(),
                size.constraints.free_len().into(),
                (3 * size.fractures.faces.len()).into(),
                way.name().into(),
                way.factor().into(),
            ];
            let run = match run {
                Ok(run) => run,
                Err(reason) => {
                    row.extend(std::iter::repeat_n(
                        Cell::Failed,
                        1 + Counts::HEADINGS.len(),
                    ));
                    row.push(Cell::Missing);
                    totals.rows.push(row);
                    let note = format!("{}, {}: {reason}.", case.name, way.setting());
                    findings.notes.push(note);
                    continue;
                }
            };
            let counts = Counts::total(&run.steps);
            row.push(run.steps.len().into());
            row.extend(counts.cells());
            row.push(match level {
                Level::Paper => run.seconds.into(),
                Level::Smoke => Cell::Missing,
            });
            totals.rows.push(row);
            if way == Way::Lagrange {
                for step in &run.steps {
                    let [stick, new, slip, open] = step.record.faces;
                    let mut row: Vec<Cell> = vec![
                        case.name.into(),
                        step.record.step.into(),
                        step.record.time.into(),
                        stick.into(),
                        (new + slip).into(),
                        open.into(),
                    ];
                    row.extend(Counts::of(step).cells());
                    steps.rows.push(row);
                }
                findings.figures.push(steps_figure(number + 1, case, &run));
                findings
                    .checks
                    .extend(checks(case, &counts, run.steps.len()));
            }
        }
    }
    findings.tables.push(steps);
    findings.tables.push(totals);
    Ok(())
}

fn checks(case: &Case, counts: &Counts, steps: usize) -> Vec<Check> {
    let name = case.name;
    let mut checks = vec![
        Check::at_most(
            format!("{name}, multipliers: preconditioners built beside the first, per step"),
            1.0,
            (counts.setups as f64 - 1.0) / steps as f64,
        ),
        Check::equal(format!("{name}, multipliers: halved steps"), 0, counts.cuts),
    ];
    if let [Some(stick), Some(other)] = counts.per_newton() {
        checks.push(Check::at_most(
            format!(
                "{name}, multipliers: n_it per Newton step in slip or opening over that in stick"
            ),
            GROWTH,
            other / stick,
        ));
    }
    checks
}
