//! e14: a fracture through stick, slip and opening and back.

use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::contact::ContactState;
use fracas::nonlinear::{Accepted, FaceFields, Simulation, State};
use fracas::scene::{Body, named};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Does a fracture find its way through its states?
#[derive(Debug)]
pub struct Cycle;

/// The scene.
const SCENE: &str = "cycle";

/// Names of the states, by number.
const STATES: [&str; 4] = ["stick", "new slip", "slip", "open"];

/// Places in the palette: what carries shear in blue, what slips in orange, what is open hollow in colour of its own.
const TONES: [usize; 4] = [0, 3, 1, 2];

/// Pictures of the states in one figure.
const PICTURES: usize = 9;

/// An accepted step and what its faces show.
struct Row {
    done: Accepted,
    fields: FaceFields,
}

impl Row {
    /// Area-weighted mean of a quantity of faces.
    fn mean(&self, body: &Body, value: impl Fn(usize) -> f64) -> f64 {
        let faces = &body.fractures.faces;
        let area: f64 = faces.iter().map(|f| f.area).sum();
        let sum: f64 = faces
            .iter()
            .enumerate()
            .map(|(i, f)| f.area * value(i))
            .sum();
        sum / area
    }

    /// Component of a vector of faces along z, the direction of the shear.
    fn along_z(body: &Body, field: &[f64], f: usize) -> f64 {
        let frame = body.fractures.faces[f].frame;
        (0..3).map(|k| field[3 * f + k] * frame[k][2]).sum()
    }

    fn shear(&self, body: &Body) -> f64 {
        self.mean(body, |f| Self::along_z(body, &self.fields.traction, f))
    }

    fn slip(&self, body: &Body) -> f64 {
        self.mean(body, |f| Self::along_z(body, &self.fields.jump, f))
    }

    fn cells(&self, body: &Body) -> Vec<Cell> {
        let record = &self.done.record;
        let [stick, new, slip, open] = record.faces;
        let pressure = self.mean(body, |f| -self.fields.traction[3 * f]);
        let aperture = self.mean(body, |f| self.fields.aperture[f]);
        vec![
            record.time.into(),
            stick.into(),
            new.into(),
            slip.into(),
            open.into(),
            record.changed_area.into(),
            (1e-6 * pressure).into(),
            (1e-6 * self.shear(body)).into(),
            (1e3 * self.slip(body)).into(),
            (1e3 * aperture).into(),
            record.active_it.into(),
            record.newton_it.into(),
            record.lin_it.into(),
            record.cuts.into(),
        ]
    }
}

fn table() -> Table {
    Table::new(
        "e14_cycle",
        "Every step: faces per state, means over the fracture, iterations of the three cycles.",
        &[
            "time [s]",
            "stick",
            "new slip",
            "slip",
            "open",
            "changed area [m²]",
            "mean −t_N [MPa]",
            "mean t_z [MPa]",
            "mean slip z [mm]",
            "mean aperture [mm]",
            "n_it active set",
            "n_it Newton",
            "n_it Krylov",
            "cuts",
        ],
    )
}

/// Runs the scene to its end.
fn steps(body: &Body, observer: &mut dyn Observer) -> anyhow::Result<Vec<Row>> {
    let mut simulation = Simulation::new(body)?;
    let mut state: State = simulation.initial_state();
    let total = 1 + body.time.map_or(0, |time| time.steps as usize);
    let mut rows: Vec<Row> = Vec::new();
    while rows.is_empty() || !simulation.is_finished(&state) {
        let stage = "steps";
        let done = rows.len().min(total);
        if observer.observe(&Step::Progress { stage, done, total }) == ControlFlow::Break(()) {
            anyhow::bail!("stopped on request");
        }
        let done = simulation.advance(&state, observer)?;
        state = done.state.clone();
        let fields = simulation.face_fields(&state);
        rows.push(Row { done, fields });
    }
    Ok(rows)
}

/// Share of the faces in every state against time.
fn counts(rows: &[Row]) -> Figure {
    let mut figure = Figure::new(
        "e14_counts",
        "",
        "Faces per state against time.",
        Axis::linear("time [s]"),
        Axis::linear("faces"),
    );
    for (k, name) in STATES.iter().enumerate().filter(|(k, _)| *k != 1) {
        let points = rows
            .iter()
            .map(|row| [row.done.record.time, row.done.record.faces[k] as f64])
            .collect();
        figure = figure.with(Series::new(name, Mark::LinePoints, points).tone(TONES[k]));
    }
    figure
}

/// Shear against what shears.
fn path(body: &Body, rows: &[Row]) -> Figure {
    let caption = "Mean shear traction against mean slip along z: sheared until it slips; drawn apart, the shear falls with the pressure; \
                   open it carries none; closed again in stick, sheared back until it slips back.";
    let points = rows
        .iter()
        .map(|row| [1e3 * row.slip(body), 1e-6 * row.shear(body)])
        .collect();
    Figure::new(
        "e14_path",
        "",
        caption,
        Axis::linear("mean slip along z [mm]"),
        Axis::linear("mean shear traction along z [MPa]"),
    )
    .with(Series::new("steps", Mark::LinePoints, points))
}

/// The steps worth a picture: the first one and those that change most faces, in order.
fn chosen(rows: &[Row]) -> Vec<usize> {
    let changes = |k: usize| {
        let [now, before] = [k, k - 1].map(|k| &rows[k].done.state.states);
        now.iter().zip(before).filter(|(a, b)| a != b).count()
    };
    let mut changing: Vec<usize> = (1..rows.len()).filter(|k| changes(*k) > 0).collect();
    changing.sort_by_key(|k| std::cmp::Reverse(changes(*k)));
    let mut chosen: Vec<usize> = std::iter::once(0).chain(changing).take(PICTURES).collect();
    chosen.sort_unstable();
    chosen
}

/// The fracture at chosen steps, side by side.
fn pictures(body: &Body, rows: &[Row]) -> Figure {
    let faces = &body.fractures.faces;
    let width = faces.iter().fold(0.0, |m: f64, f| m.max(f.center[1]));
    let chosen = chosen(rows);
    let times = chosen
        .iter()
        .map(|k| format!("{:.2}", rows[*k].done.record.time))
        .collect();
    let mut figure = Figure::new(
        "e14_states",
        "",
        "States of the faces at chosen times: one picture of the fracture per time, seen along x, y to the right.",
        Axis::categories("time [s]", times),
        Axis::linear("z [m]"),
    );
    for (state, name) in STATES.iter().enumerate() {
        let mut points = Vec::new();
        for (place, k) in chosen.iter().enumerate() {
            for (f, face) in faces.iter().enumerate() {
                if usize::from(rows[*k].done.state.states[f].code()) == state {
                    let y = 0.8 * face.center[1] / width - 0.4;
                    points.push([place as f64 + y, face.center[2]]);
                }
            }
        }
        if !points.is_empty() {
            figure = figure.with(Series::new(name, Mark::Points, points).tone(TONES[state]));
        }
    }
    figure
}

fn checks(body: &Body, rows: &[Row]) -> Vec<Check> {
    let n = body.fractures.faces.len();
    let most = |state: ContactState| {
        let counts = rows
            .iter()
            .map(|r| r.done.record.faces[usize::from(state.code())]);
        counts.max().unwrap_or(0)
    };
    let last = rows.last().map_or([0; 4], |r| r.done.record.faces);
    let mut beyond: f64 = 0.0;
    let mut pull: f64 = 0.0;
    for row in rows {
        for (f, state) in row.done.state.states.iter().enumerate() {
            let largest = row.done.state.traction;
            let t = &row.fields.traction[3 * f..][..3];
            if *state == ContactState::Open {
                pull = pull.max(t.iter().fold(0.0, |m: f64, t| m.max(t.abs())) / largest);
            } else {
                pull = pull.max(t[0] / largest);
                beyond = beyond.max((t[1].hypot(t[2]) - row.fields.tau_limit[f]) / largest);
            }
        }
    }
    vec![
        Check::equal("most faces in stick", n, most(ContactState::Stick)),
        Check::equal("most faces in slip", n, most(ContactState::Slip)),
        Check::equal("most faces open", n, most(ContactState::Open)),
        Check::equal("open faces at the end", 0, last[3]),
        Check::equal("new slip in accepted steps", 0, most(ContactState::NewSlip)),
        Check::at_most(
            "traction of an open face, or tension of a closed one, over the largest traction",
            1e-5,
            pull,
        ),
        Check::at_most(
            "shear beyond the limit over the largest traction",
            1e-5,
            beyond,
        ),
    ]
}

impl Experiment for Cycle {
    fn id(&self) -> &'static str {
        "e14"
    }

    fn title(&self) -> &'static str {
        "Stick, slip, open and back"
    }

    fn question(&self) -> &'static str {
        "Does a fracture find its way through all its states and back, and what does a step cost?"
    }

    fn setup(&self) -> &'static str {
        "`cycle`: a block of 8 m × 20 m × 20 m cut in the middle, one side fixed, the other pressed on, sheared by 1 mm, drawn away \
         and pressed on again, and sheared back by 2 mm; friction angle 30°, 40 steps. Smoke 4 × 5 × 5 cells, paper 8 × 10 × 10. \
         Lagrange multipliers with jump stabilization; relative residual 1e-10, states judged to 1e-6."
    }

    fn expect(&self) -> &'static str {
        "Faces slip row by row until all do, open as a whole, close in stick and slip back. Open faces carry nothing; \
         closed ones no tension and no shear beyond the limit. A step without changes of state takes one or two Newton steps."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let entry = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
        let scene = match level {
            Level::Smoke => entry.small_scene()?,
            Level::Paper => entry.scene()?,
        };
        let body = scene.with_overrides(&["solver.tolerance=1e-10"])?.build()?;
        let mut findings = Findings::default();
        findings.set("scene", SCENE).set("level", level.word());
        let rows = steps(&body, observer)?;
        let mut table = table();
        table.rows = rows.iter().map(|row| row.cells(&body)).collect();
        findings.tables.push(table);
        findings.figures.push(counts(&rows));
        findings.figures.push(path(&body, &rows));
        findings.figures.push(pictures(&body, &rows));
        findings.checks = checks(&body, &rows);
        Ok(findings)
    }
}
