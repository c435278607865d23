//! e14: a fracture through stick, slip and opening and back.

mod figures;
mod phases;
mod steps;

use crate::report::{Check, Experiment, Findings, Level};
use crate::scenes::with_cells;
use fracas::contact::ContactState;
use fracas::scene::{Scene, named};
use fracas_solvers::Observer;
use steps::{Row, Run};

/// Does a fracture find its way through its states?
#[derive(Debug)]
pub struct Cycle;

/// The scene.
const SCENE: &str = "cycle";

/// Cells per axis of the scene, times this, at paper level.
const TIMES: [usize; 3] = [1, 2, 4];

/// Of the fracture in the scene [°].
const FRICTION: f64 = 30.0;

/// What the loads prescribe: largest distance of the sides, and slip while they are apart [m].
const APART: f64 = 0.9e-3;
const SHIFTED: f64 = 1e-3;

/// Newton steps of a step in which no face slips or changes.
const QUIET: f64 = 2.0;

fn scenes(level: Level) -> anyhow::Result<Vec<Scene>> {
    let entry = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
    let scenes = match level {
        Level::Smoke => vec![entry.small_scene()?],
        Level::Paper => {
            let scene = entry.scene()?;
            let scenes = TIMES.map(|times| with_cells(&scene, [8, 10, 10].map(|n| times * n)));
            scenes.into_iter().collect::<Result<_, _>>()?
        }
    };
    let strict = scenes
        .iter()
        .map(|s| s.with_overrides(&["solver.tolerance=1e-10", "solver.measure=residual"]));
    Ok(strict.collect::<Result<_, _>>()?)
}

/// No face slips, and none has changed.
fn is_quiet(row: &Row) -> bool {
    let [_, new, slip, _] = row.done.record.faces;
    new + slip == 0 && row.done.record.changed_area == 0.0
}

fn checks(run: &Run) -> Vec<Check> {
    let Run { name, body, rows } = run;
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
    let friction = FRICTION.to_radians().tan();
    let all = |state: ContactState| {
        let code = usize::from(state.code());
        rows.iter().filter(move |r| r.done.record.faces[code] == n)
    };
    let cone = all(ContactState::Slip).fold(0.0_f64, |m, r| {
        m.max((r.friction(body) / (friction * r.pressure(body)) - 1.0).abs())
    });
    let apart = all(ContactState::Open).fold(0.0_f64, |m, r| m.max(r.aperture(body)));
    let shifted =
        all(ContactState::Open).fold(0.0_f64, |m, r| m.max((r.slip(body) / SHIFTED - 1.0).abs()));
    let quiet = rows.iter().filter(|r| is_quiet(r));
    let newton = quiet.map(|r| r.done.record.newton_it).max().unwrap_or(0);
    let cuts = rows.iter().map(|r| r.done.record.cuts).sum();
    let of = |claim: &str| format!("{name} cells: {claim}");
    vec![
        Check::equal(of("most faces in stick"), n, most(ContactState::Stick)),
        Check::equal(of("most faces in slip"), n, most(ContactState::Slip)),
        Check::equal(of("most faces open"), n, most(ContactState::Open)),
        Check::equal(of("open faces at the end"), 0, last[3]),
        Check::equal(
            of("new slip in accepted steps"),
            0,
            most(ContactState::NewSlip),
        ),
        Check::at_most(
            of("traction of an open face, or tension of a closed one, over the largest traction"),
            1e-5,
            pull,
        ),
        Check::at_most(
            of("shear beyond the limit over the largest traction"),
            1e-5,
            beyond,
        ),
        Check::at_most(
            of("all slip: mean shear over tan φ times the mean pressure, less 1"),
            1e-5,
            cone,
        )
        .closed_form(),
        Check::at_most(
            of("all open: largest aperture over the prescribed one, less 1"),
            1e-6,
            (apart / APART - 1.0).abs(),
        )
        .closed_form(),
        Check::at_most(
            of("all open: slip over the prescribed shift, less 1"),
            1e-6,
            shifted,
        )
        .closed_form(),
        Check::at_most(
            of("Newton steps of a step in which no face slips or changes"),
            QUIET,
            newton as f64,
        ),
        Check::equal(of("halved steps"), 0, cuts),
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
         and pressed on again, and sheared back by 2 mm; friction angle 30°, 40 steps. Smoke 4 × 5 × 5 cells, paper 8 × 10 × 10, 16 × 20 × 20 \
         and 32 × 40 × 40. Lagrange multipliers with jump stabilization; relative residual 1e-10, states judged to 1e-6."
    }

    fn expect(&self) -> &'static str {
        "Slip spreads until all faces slip; they open as a whole, close in stick and slip back. Open faces carry nothing; \
         closed ones no tension and no shear beyond the limit; where all slip the shear is tan 30° times the pressure, where all are open the jump \
         is the prescribed motion. A step in which no face slips or changes takes at most two Newton steps; one with \
         slip takes more, because the direction and the limit of the shear move, too."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("scene", SCENE).set("level", level.word());
        let mut runs = Vec::new();
        for scene in scenes(level)? {
            runs.push(Run::of(&scene, observer)?);
        }
        let finest = runs.last().ok_or_else(|| anyhow::anyhow!("no mesh"))?;
        let mut table = steps::table();
        table.rows = finest.rows.iter().map(|r| r.cells(&finest.body)).collect();
        findings.tables.push(table);
        findings.tables.push(phases::table(&runs));
        findings.figures.push(figures::shares(finest));
        findings.figures.push(figures::path(&runs));
        findings.figures.extend(figures::mobilised(finest));
        findings.checks = runs.iter().flat_map(checks).collect();
        Ok(findings)
    }
}
