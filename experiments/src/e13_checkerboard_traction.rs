//! e13: the checkerboard in the tractions, with and without the jump stabilization.

mod field;
mod junctions;

use crate::crack::fitted;
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use anyhow::Context;
use field::Solved;
use fracas::contact::JumpStabilization;
use fracas::mesh::PlaneFracture;
use fracas::scene::named;
use fracas_figures::{Axis, Cells, Colors, Figure, Mark, Series};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Do the tractions alternate without H, and does H cost accuracy?
#[derive(Debug)]
pub struct CheckerboardTractions;

/// Cells per side of the fracture in the pictures.
const SHOWN: usize = 12;

/// Cracks whose kernel is counted, in their small versions.
const CRACKS: [&str; 3] = ["inclined_crack", "line_crack", "penny_crack"];

/// With H or without.
const CHOICES: [(&str, Option<JumpStabilization>); 2] = [
    ("without H", None),
    ("with H", Some(JumpStabilization::PUBLISHED)),
];

/// Errors of the normal traction on one mesh.
struct Row {
    choice: &'static str,
    n: usize,
    solved: Solved,
    /// t_N less the closed form per face [Pa].
    errors: Vec<f64>,
}

impl Row {
    fn new(choice: usize, n: usize) -> anyhow::Result<Self> {
        let (name, stabilization) = CHOICES[choice];
        let cut = vec![PlaneFracture::through("cut", 2, 0.0)];
        let solved = field::solve(n, cut, stabilization, &[])?;
        let errors = solved.errors().map(|[normal, ..]| normal).collect();
        Ok(Self {
            choice: name,
            n,
            solved,
            errors,
        })
    }

    fn h(&self) -> f64 {
        1.0 / self.n as f64
    }

    /// Root mean square of the error over the amplitude of t_N.
    fn l2(&self) -> f64 {
        self.rms(self.errors.iter().copied())
    }

    /// Root mean square of the jumps of the error over inner edges, over the amplitude of t_N.
    fn roughness(&self) -> f64 {
        let edges = &self.solved.built.fractures.edges;
        self.rms(edges.iter().map(|e| {
            let [k, l] = e.faces.map(|f| self.errors[f as usize]);
            k - l
        }))
    }

    /// `|Σ (−1)^{i+j} e_ij| / Σ |e_ij|`: 1 for a perfect checkerboard.
    fn checkerboard(&self) -> f64 {
        let sign = |f: usize| {
            if (f % self.n + f / self.n).is_multiple_of(2) {
                1.0
            } else {
                -1.0
            }
        };
        let signed: f64 = self
            .errors
            .iter()
            .enumerate()
            .map(|(f, e)| sign(f) * e)
            .sum();
        signed.abs() / self.errors.iter().map(|e| e.abs()).sum::<f64>()
    }

    fn rms(&self, values: impl Iterator<Item = f64>) -> f64 {
        let (sum, n) = values.fold((0.0, 0), |(sum, n), v| (sum + v * v, n + 1));
        f64::sqrt(sum / f64::from(n)) / field::AMPLITUDE
    }

    fn picture(&self) -> Figure {
        let mesh = &self.solved.built;
        let corners = |a: u32| {
            let [x, y, _] = mesh.mesh.nodes[a as usize];
            [x, y]
        };
        let faces = &mesh.fractures.faces;
        let mpa = 1e-6;
        let mut figure = Figure::new(
            &format!("e13_{}", self.choice.replace(' ', "_")),
            "",
            &format!(
                "Normal traction {} on a through-going fracture of {} × {} faces.",
                self.choice, self.n, self.n
            ),
            Axis::linear("x [m]").range(0.0, 1.0),
            Axis::linear("y [m]").range(0.0, 1.0),
        );
        let span = field::AMPLITUDE * 1.2;
        figure.cells = Some(Cells {
            colors: Colors::Diverging,
            label: "t_N [MPa]".into(),
            quads: faces.iter().map(|f| f.minus.nodes.map(corners)).collect(),
            values: self
                .solved
                .tractions
                .iter()
                .step_by(3)
                .map(|t| mpa * t)
                .collect(),
            range: [-field::COMPRESSION - span, -field::COMPRESSION + span].map(|t| mpa * t),
        });
        figure.equal_aspect = true;
        figure
    }
}

fn order_figure(rows: &[Row]) -> Figure {
    let mut figure = Figure::new(
        "e13_convergence",
        "",
        "Error of the normal traction (L2, and its jumps over edges) and of the displacement against mesh size.",
        Axis::log("h [m]"),
        Axis::log("relative error"),
    );
    for (choice, _) in CHOICES {
        let mut add = |what: &str, value: &dyn Fn(&Row) -> f64| {
            let own = rows.iter().filter(|r| r.choice == choice);
            let points = own.map(|r| [r.h(), value(r)]).collect();
            let name = format!("{what}, {choice}");
            figure
                .series
                .push(Series::new(&name, Mark::LinePoints, points));
        };
        add("t_N", &Row::l2);
        add("jumps of t_N", &Row::roughness);
        add("u", &|r| r.solved.u_error);
    }
    figure
}

/// dim ker B of cracks whose tips are not split.
fn kernels(findings: &mut Findings) -> anyhow::Result<()> {
    let mut table = Table::new(
        "e13_kernels",
        "Tractions that no displacement sees on embedded cracks: without H their systems are singular and have no solution \
         to show.",
        &["scene", "faces", "dim ker B", "with H"],
    );
    for name in CRACKS {
        let scene = named(name).with_context(|| format!("no scene {name}"))?;
        let body = scene.small_scene()?.build()?;
        let kernel = body.audit().kernel;
        let bare = kernel
            .dimension
            .context("the small scene is too large to count its kernel")?;
        table.push([
            name.into(),
            body.fractures.faces.len().into(),
            bare.into(),
            kernel.stabilized_dimension.into(),
        ]);
        findings.checks.push(
            Check::holds(
                format!("{name}: tractions in the kernel without and with H"),
                "some, none",
                format!("{bare}, {}", kernel.stabilized_dimension),
                bare > 0 && kernel.stabilized_dimension == 0,
            )
            .closed_form(),
        );
    }
    findings.tables.push(table);
    Ok(())
}

impl Experiment for CheckerboardTractions {
    fn id(&self) -> &'static str {
        "e13"
    }

    fn title(&self) -> &'static str {
        "Tractions without and with stabilization"
    }

    fn question(&self) -> &'static str {
        "Do tractions alternate from face to face without H, are they smooth with it, and does H cost an order?"
    }

    fn setup(&self) -> &'static str {
        "A block of N³ cells, 1 m wide, cut through, every face in stick, E = 25 GPa, ν = 0.25; nodes shifted by up to 20 % of a \
         cell at random, within the plane on the fracture. Displacements below and above and tractions on the sides are \
         those of u = ∇φ/(2G), φ harmonic, and of 20 MPa of compression: t_N = −20 MPa + 5 MPa cos(πx + 0.7) cos(πy + 0.3). \
         Errors at the centres of faces over 5 MPa. The fracture cuts the block, so that B has full rank and the system \
         without H a solution; on embedded cracks it has none, and their kernels are counted. The same for two planes that \
         cross and for N × N columns one cell wide."
    }

    fn expect(&self) -> &'static str {
        "Without H the tractions carry a checkerboard that refinement does not remove as it should; with H it is gone, t_N \
         converges with order 1 at least, and the displacement is as good as before. Where fractures cross and stick, neighbours across \
         the junctions cost tractions a tenth at most, and columns one cell wide take no more iterations with exact S_u as they become more; around AMG they \
         take more from 8 × 8 to 12 × 12, and hardly more beyond."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let sizes: &[usize] = match level {
            Level::Smoke => &[4, 8, 12],
            Level::Paper => &[4, 8, 12, 16, 20],
        };
        let mut findings = Findings::default();
        findings.set("N", sizes.to_vec());
        let mut rows = Vec::new();
        let total = CHOICES.len() * sizes.len();
        for choice in 0..CHOICES.len() {
            for n in sizes {
                let step = Step::Progress {
                    stage: "meshes",
                    done: rows.len(),
                    total,
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                rows.push(Row::new(choice, *n)?);
            }
        }
        let mut table = Table::new(
            "e13_errors",
            "Errors of t_N over its amplitude: L2, jumps over edges, share that alternates from face to face (1 = a perfect \
             checkerboard); error of u.",
            &[
                "choice",
                "N",
                "n_u",
                "t_N",
                "jumps of t_N",
                "checkerboard",
                "u",
                "n_it",
            ],
        );
        for row in &rows {
            table.push([
                row.choice.into(),
                row.n.into(),
                row.solved.n_u.into(),
                row.l2().into(),
                row.roughness().into(),
                row.checkerboard().into(),
                row.solved.u_error.into(),
                row.solved.iterations.into(),
            ]);
        }
        let mut orders = Table::new(
            "e13_orders",
            "Orders of the least-squares lines.",
            &["choice", "t_N", "jumps of t_N", "u"],
        );
        let mut found = Vec::new();
        for (choice, _) in CHOICES {
            let own: Vec<&Row> = rows.iter().filter(|r| r.choice == choice).collect();
            let h: Vec<f64> = own.iter().map(|r| r.h()).collect();
            let order = |value: &dyn Fn(&Row) -> f64| {
                fitted(&h, &own.iter().map(|r| value(r)).collect::<Vec<_>>())
            };
            let three = [
                order(&Row::l2),
                order(&Row::roughness),
                order(&|r: &Row| r.solved.u_error),
            ];
            let [t, jumps, u] = three.map(Cell::Real);
            orders.push([choice.into(), t, jumps, u]);
            if let Some(last) = own.last() {
                found.push((three, last.l2(), last.roughness(), last.solved.u_error));
            }
        }
        if let [without, with] = &found[..] {
            findings
                .checks
                .push(Check::at_least("order of t_N with H", 1.0, with.0[0]));
            findings.checks.push(Check::at_least(
                "finest mesh: jumps of the error without H over those with H",
                3.0,
                without.2 / with.2,
            ));
            findings.checks.push(Check::close(
                "finest mesh: error of u with H over that without",
                1.0,
                with.3 / without.3,
                0.1,
            ));
        }
        for row in rows.iter().filter(|r| r.n == SHOWN) {
            findings.figures.push(row.picture());
        }
        findings.figures.push(order_figure(&rows));
        findings.tables.push(table);
        findings.tables.push(orders);
        kernels(&mut findings)?;
        junctions::add(level, &mut findings)?;
        Ok(findings)
    }
}
