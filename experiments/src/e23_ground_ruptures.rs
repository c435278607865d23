//! e23: where the ground tears as water is drawn.

use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, Scene, named};
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Series};
use fracas_solvers::Observer;

/// Where does the ground tear?
#[derive(Debug)]
pub struct GroundRuptures;

/// Scenes and what holds the sediments back.
const MECHANISMS: [(&str, &str); 3] = [
    ("rupture_bedrock", "bedrock that emerges"),
    ("rupture_step", "abrupt change of thickness"),
    ("rupture_ridge", "buried ridge"),
];

/// Drawdown at the end [MPa].
const LAST: f64 = 0.2;

/// Half the width of the section that figures show [m].
const SEEN: f64 = 200.0;

/// How far below the topmost centre of a face others are at the ground, too: rounding [m].
const TOP: f64 = 1e-6;

/// A mechanism from no drawdown to the last.
struct Run {
    name: &'static str,
    body: Body,
    rows: Vec<Row>,
    /// Vertical displacement at the end, 3 per node [m].
    u: Vec<f64>,
}

/// A step.
struct Row {
    /// [MPa].
    drawdown: f64,
    /// Largest aperture of the topmost faces [mm].
    opening: f64,
    /// Largest vertical jump of the topmost faces [mm].
    throw: f64,
    /// Depth of the lowest open face's centre, and of the lowest that slips or is open; 0 where none does [m].
    open_to: f64,
    torn_to: f64,
    /// Depth of the highest open face's centre [m].
    open_from: f64,
}

impl Run {
    fn of(name: &'static str, scene: &Scene, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let body = scene.build()?;
        let end = body.time.map_or(1.0, |t| t.end);
        let mut simulation = Simulation::new(&body)?;
        let (mut rows, mut u) = (Vec::new(), Vec::new());
        simulation.run(observer, |simulation, _, done| {
            let fields = simulation.face_fields(&done.state);
            let faces = &simulation.problem().body().fractures.faces;
            let top = faces
                .iter()
                .map(|f| f.center[2])
                .fold(f64::NEG_INFINITY, f64::max);
            let mut row = Row {
                drawdown: LAST * done.record.time / end,
                opening: 0.0,
                throw: 0.0,
                open_to: 0.0,
                torn_to: 0.0,
                open_from: f64::INFINITY,
            };
            for (f, face) in faces.iter().enumerate() {
                let depth = -face.center[2];
                let open = fields.aperture[f] > 0.0;
                if open {
                    row.open_to = row.open_to.max(depth);
                    row.open_from = row.open_from.min(depth);
                }
                if open || fields.slip[f] > 0.0 {
                    row.torn_to = row.torn_to.max(depth);
                }
                if face.center[2] >= top - TOP {
                    let up: f64 = (0..3)
                        .map(|k| fields.jump[3 * f + k] * face.frame[k][2])
                        .sum();
                    row.opening = row.opening.max(1e3 * fields.aperture[f]);
                    if 1e3 * up.abs() > row.throw.abs() {
                        row.throw = 1e3 * up;
                    }
                }
            }
            rows.push(row);
            u = simulation.displacement(&done.state);
        })?;
        drop(simulation);
        Ok(Self {
            name,
            body,
            rows,
            u,
        })
    }

    /// Drawdown of the first step for which something holds [MPa].
    fn first(&self, holds: impl Fn(&Row) -> bool) -> Option<f64> {
        self.rows
            .iter()
            .find(|row| holds(row))
            .map(|row| row.drawdown)
    }

    fn last(&self, of: impl Fn(&Row) -> f64) -> f64 {
        self.rows.last().map_or(0.0, of)
    }

    /// Settlement of the section, with the drawdown of the last step.
    fn section(&self) -> Figure {
        let mut figure = Figure::new(
            &format!("e23_{}", self.name),
            "",
            &format!(
                "Settlement at a drawdown of 0.2 MPa, the middle 400 m of the section: {}.",
                self.what()
            ),
            Axis::linear("x [m]").range(-SEEN, SEEN),
            Axis::linear("z [m]").range(-400.0, 0.0),
        );
        let mesh = &self.body.mesh;
        // the sides at y = 0
        let side = |nodes: &[u32; 8]| [nodes[0], nodes[1], nodes[5], nodes[4]];
        let place = |a: u32| mesh.nodes[a as usize];
        let seen = |quad: &[u32; 4]| {
            let near = |a: &u32| place(*a)[0].abs() < SEEN;
            quad.iter().all(|a| place(*a)[1] == 0.0) && quad.iter().any(near)
        };
        let cells: Vec<_> = mesh.elements.iter().map(side).filter(seen).collect();
        let mean = |quad: &[u32; 4]| {
            let sum: f64 = quad.iter().map(|a| self.u[3 * *a as usize + 2]).sum();
            -100.0 * sum / 4.0
        };
        let values: Vec<f64> = cells.iter().map(mean).collect();
        let most = values.iter().fold(0.0, |m: f64, v| m.max(*v));
        figure.cells = Some(Cells {
            colors: Colors::Sequential,
            label: "settlement [cm]".into(),
            quads: (cells.iter())
                .map(|quad| quad.map(|a| [place(a)[0].clamp(-SEEN, SEEN), place(a)[2]]))
                .collect(),
            values,
            range: [0.0, most],
        });
        figure.equal_aspect = true;
        let faces = &self.body.fractures.faces;
        let depth = faces.iter().map(|f| f.center[2]).fold(0.0, f64::min);
        let plane = vec![[0.0, depth], [0.0, 0.0]];
        figure.with(Series::new("the plane", Mark::Dashed, plane))
    }

    fn what(&self) -> &'static str {
        let own = MECHANISMS.iter().find(|(name, _)| *name == self.name);
        own.map_or("", |(_, what)| what)
    }
}

impl Experiment for GroundRuptures {
    fn id(&self) -> &'static str {
        "e23"
    }

    fn title(&self) -> &'static str {
        "Ground ruptures"
    }

    fn question(&self) -> &'static str {
        "At which drawdown does the ground tear where bedrock emerges, where an aquifer changes its thickness, and above a buried ridge, \
         and from where does the rupture grow?"
    }

    fn setup(&self) -> &'static str {
        "`rupture_bedrock`, `rupture_step`, `rupture_ridge`: sections of 1,200 m × 400 m whose sediments lose 0.2 MPa of pore pressure below 20 m \
         of depth in 40 steps; a vertical plane without cohesion, friction angle 30°, where ruptures are expected. The three mechanisms are printed. Sediments of 35 MPa, ν = 0.25 and \
         21 kN/m³ are public stand-ins; geometry, drawdown, bedrock of 10 GPa and a horizontal stress of 0.5 of the vertical effective one are ours. Cells of 10 m beside the plane, \
         at paper level 5 m."
    }

    fn expect(&self) -> &'static str {
        "As printed in words: shear along emerging bedrock and steps of the thickness, and above a buried ridge ruptures that propagate from the \
         land surface downward."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word());
        let mut runs = Vec::new();
        for (name, _) in MECHANISMS {
            let entry = named(name).ok_or_else(|| anyhow::anyhow!("no scene {name}"))?;
            let scene = match level {
                Level::Smoke => entry.scene()?,
                Level::Paper => entry.scene()?.with_overrides(&[
                    "mesh.x.size=5 m",
                    "mesh.z.size=5 m",
                    "mesh.x.growth=1.15",
                    "mesh.z.growth=1.15",
                ])?,
            };
            let strict = scene.with_overrides(&["solver.tolerance=1e-10"])?;
            runs.push(Run::of(name, &strict, observer)?);
        }
        let mut table = Table::new(
            "e23_mechanisms",
            "Drawdown at the first slip and the first opening, and what the rupture shows at the ground at 0.2 MPa.",
            &[
                "mechanism",
                "first slip [MPa]",
                "first opening [MPa]",
                "opening at the ground [mm]",
                "throw at the ground [mm]",
                "open down to [m]",
                "torn down to [m]",
            ],
        );
        for run in &runs {
            table.push([
                Cell::from(run.what()),
                run.first(|r| r.torn_to > 0.0).into(),
                run.first(|r| r.open_to > 0.0).into(),
                run.last(|r| r.opening).into(),
                // what symmetry forbids is the error of the solver
                run.last(|r| (1e3 * r.throw).round() / 1e3 + 0.0).into(),
                run.last(|r| r.open_to).into(),
                run.last(|r| r.torn_to).into(),
            ]);
        }
        findings.tables.push(table);
        findings.figures.push(grown(&runs));
        findings.figures.extend(runs.iter().map(Run::section));
        let [bedrock, step, ridge] = &runs[..] else {
            anyhow::bail!("three mechanisms");
        };
        let top = |run: &Run| {
            let opened = run.rows.iter().find(|row| row.open_to > 0.0);
            opened.map_or(f64::INFINITY, |row| row.open_from)
        };
        let deepest = |run: &Run| {
            let grows = run.rows.windows(2).all(|w| w[1].open_to >= w[0].open_to);
            if grows { 0.0 } else { 1.0 }
        };
        findings.checks = vec![
            Check::at_least(
                "emerging bedrock: throw at the ground [mm]",
                50.0,
                bedrock.last(|r| r.throw.abs()),
            ),
            Check::at_least(
                "step: throw at the ground [mm]",
                1.0,
                step.last(|r| r.throw.abs()),
            ),
            Check::at_least(
                "ridge: opening at the ground [mm]",
                1.0,
                ridge.last(|r| r.opening),
            ),
            Check::at_most("ridge: depth of the first open face [m]", 10.0, top(ridge)),
            Check::equal(
                "ridge: the open part shrinks in a step (1: yes)",
                0,
                deepest(ridge) as usize,
            ),
            Check::at_most(
                "ridge: throw over opening, which symmetry forbids",
                1e-3,
                ridge.last(|r| r.throw.abs() / r.opening),
            )
            .closed_form(),
        ];
        Ok(findings)
    }
}

/// How far down ruptures are open or slip, against drawdown.
fn grown(runs: &[Run]) -> Figure {
    let mut figure = Figure::new(
        "e23_depth",
        "",
        "Depth down to which the rupture is open (lines) or has slipped or opened (dashed) against the drawdown.",
        Axis::linear("drawdown [MPa]"),
        Axis::linear("depth [m]"),
    );
    for (tone, run) in runs.iter().enumerate() {
        let of = |depth: fn(&Row) -> f64| run.rows.iter().map(|r| [r.drawdown, depth(r)]).collect();
        let open = Series::new(run.what(), Mark::LinePoints, of(|r| r.open_to));
        let torn = Series::new("", Mark::Dashed, of(|r| r.torn_to));
        figure = figure.with(open.tone(tone)).with(torn.tone(tone));
    }
    figure
}
