//! e09: error against work, by tolerance, precision, inner solver and mesh.

mod narrow;
mod run;
mod sample;

use crate::clock::REPETITIONS;
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas_solvers::multigrid::Precision;
use fracas_solvers::{Observer, Step};
use run::{Method, Reference, Row, body, reference, rows};
use sample::Sample;
use std::ops::ControlFlow;

/// How much work does a digit cost?
#[derive(Debug)]
pub struct WorkPrecision;

/// The scene: mapped cells, layers of contrast 10, two inclined fractures and a flat one that crosses them.
const SCENE: &str = "layered_crossing";

/// Cells per axis, and those of the finest mesh, which each divides.
const SMOKE: (&[usize], usize) = (&[8, 16], 32);

/// The same in print: 0.1 and 0.8 million unknowns against 6.4 million.
const PAPER: (&[usize], usize) = (&[16, 32, 64], 128);

const TOLERANCES: [f64; 8] = [0.5, 1e-1, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12];

/// Of the solution on the same mesh, and of that on the finest one.
const REFERENCE: [f64; 2] = [1e-13, 1e-9];

/// Cells per axis up to which S_u is factorized.
const FACTORIZED: usize = 32;

/// Iterations that f32 inside may cost more than f64.
const MORE: f64 = 2.0;

/// A method on a mesh.
struct Curve {
    cells: usize,
    n: usize,
    method: Method,
    rows: Vec<Row>,
}

fn table() -> Table {
    Table::new(
        "e09_work_precision",
        "RACP, GMRES(100), flexible where f32 is inside. Algebraic error: against the same mesh solved to 1e-13, \
         displacements and tractions; error: against the finest mesh, displacements at shared nodes off the fractures; relative, ℓ². X: \
         the tolerance was not met, errors are those of what was reached. Processor time of one thread, of a solve the least of three; set-up counts assembly.",
        &[
            "cells",
            "n",
            "method",
            "tolerance",
            "n_it",
            "C_s",
            "algebraic error u",
            "algebraic error t",
            "error u",
            "set-up [s]",
            "solve [s]",
        ],
    )
}

/// A line per method of one mesh.
fn figure(
    id: &str,
    caption: &str,
    x: Axis,
    y: Axis,
    curves: &[&Curve],
    point: impl Fn(&Row) -> [f64; 2],
) -> Figure {
    let mut figure = Figure::new(id, "", caption, x, y);
    for (tone, method) in Method::ALL.into_iter().enumerate() {
        for curve in curves.iter().filter(|c| c.method == method) {
            let points: Vec<[f64; 2]> = curve.rows.iter().map(&point).collect();
            figure = figure.with(Series::new(method.name(), Mark::LinePoints, points).tone(tone));
        }
    }
    figure
}

/// Error against the finest mesh of one method, a line per mesh.
fn meshes_figure(level: Level, curves: &[Curve]) -> Figure {
    let x = match level {
        Level::Smoke => "C_s × unknowns",
        Level::Paper => "processor time [s]",
    };
    let mut figure = Figure::new(
        "e09_meshes",
        "",
        "Error of the displacements against the finest mesh over work, a line per mesh, tolerances from 0.5 to 1e-12, geometric multigrid with f32 inside. \
         Where a line turns flat the error is that of the mesh and further iterations are wasted.",
        Axis::log(x),
        Axis::log("error of u"),
    );
    let method = Method::Geometric(Precision::F32);
    for curve in curves.iter().filter(|c| c.method == method) {
        let points = curve.rows.iter().map(|row| {
            let work = match level {
                Level::Smoke => row.cost * curve.n as f64,
                Level::Paper => row.setup + row.solve,
            };
            [work, row.total]
        });
        let name = format!("{}³ cells", curve.cells);
        figure = figure.with(Series::new(&name, Mark::LinePoints, points.collect()));
    }
    figure
}

fn checks(curves: &[Curve]) -> Vec<Check> {
    let of = |method: Method| curves.iter().filter(move |c| c.method == method);
    let count = |row: &Row| match row.met {
        true => row.iterations as f64,
        false => f64::INFINITY,
    };
    let more = |inner: fn(Precision) -> Method| {
        let pairs = of(inner(Precision::F32)).zip(of(inner(Precision::F64)));
        let rows = pairs.flat_map(|(a, b)| a.rows.iter().zip(&b.rows));
        rows.filter(|(a, _)| a.tolerance > 1e-11)
            .fold(0.0_f64, |most, (a, b)| most.max(count(a) - count(b)))
    };
    let geometric = Method::Geometric(Precision::F32);
    let finest = |method: Method| of(method).next_back().and_then(|c| c.rows.last());
    let at = |curve: &Curve, tolerance: f64| {
        let row = curve.rows.iter().find(|r| r.tolerance == tolerance);
        row.map_or(f64::NAN, |r| r.total)
    };
    let totals: Vec<f64> = of(geometric).map(|c| at(c, 1e-10)).collect();
    let slack = of(geometric)
        .map(|c| at(c, 1e-6) / at(c, 1e-10))
        .fold(0.0, f64::max);
    vec![
        Check::at_most(
            "geometric, f32 inside: iterations more than f64, any mesh, to 1e-10",
            MORE,
            more(Method::Geometric),
        ),
        Check::at_most(
            "AMG, f32 inside: iterations more than f64, any mesh, to 1e-10",
            MORE,
            more(Method::Algebraic),
        ),
        Check::at_most(
            "geometric, f32 inside: algebraic error of u asked for 1e-12",
            1e-9,
            finest(geometric).map_or(f64::NAN, |r| r.algebraic[0]),
        ),
        Check::at_least(
            "all f32: algebraic error of u asked for 1e-12",
            1e-8,
            finest(Method::AllSingle).map_or(f64::NAN, |r| r.algebraic[0]),
        ),
        Check::at_most(
            "error against the finest mesh at 1e-6 over that at 1e-10",
            1.01,
            slack,
        ),
        Check::at_least(
            "error of the coarsest mesh over that of the next",
            1.5,
            totals[0] / totals[1],
        ),
    ]
}

impl Experiment for WorkPrecision {
    fn id(&self) -> &'static str {
        "e09"
    }

    fn title(&self) -> &'static str {
        "Error against work"
    }

    fn question(&self) -> &'static str {
        "How much time does a digit cost, with which inner solver and precision, and from where on does only a finer mesh help?"
    }

    fn setup(&self) -> &'static str {
        "`layered_crossing` (mapped cells, layers of contrast 10, three crossing fractures), every face in stick, nested meshes; \
         RACP around exact S_u, AMG and geometric multigrid; digits: f64 throughout, f32 inside an iteration in f64, f32 \
         throughout. Tolerances from 0.5 to 1e-12 of the true residual. One thread, processor time (paper level)."
    }

    fn expect(&self) -> &'static str {
        "Digits cost iterations in proportion, whatever is inside. f32 inside costs at most two iterations more; f32 \
         throughout ends at its rounding times the condition. The mesh leaves an error of 1e-2 to 1e-3, so from a tolerance of about 1e-4 \
         on work buys digits of the discrete solution alone, and a finer mesh those of the body."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        let ((meshes, fine), repetitions) = match level {
            Level::Smoke => (SMOKE, 1),
            Level::Paper => (PAPER, REPETITIONS),
        };
        findings
            .set("scene", SCENE)
            .set("level", level.word())
            .set("finest mesh", fine);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
        let finest = body(SCENE, fine)?;
        let Reference { u, residual, .. } = reference(&finest, REFERENCE[1])?;
        findings.notes.push(format!(
            "The solution on {fine}³ cells has a relative residual of {residual:.0e}."
        ));
        let sample = Sample::new(&finest, fine, &u);
        drop((finest, u));
        let (mut table, mut curves) = (table(), Vec::new());
        let total = meshes.len() * Method::ALL.len();
        for (k, cells) in meshes.iter().copied().enumerate() {
            let body = body(SCENE, cells)?;
            let reference = reference(&body, REFERENCE[0])?;
            findings.notes.push(format!(
                "The reference on {cells}³ cells has a relative residual of {:.0e}.",
                reference.residual
            ));
            let n = reference.u.len() + reference.t.len();
            for (m, method) in Method::ALL.into_iter().enumerate() {
                let step = Step::Progress {
                    stage: method.name(),
                    done: k * Method::ALL.len() + m,
                    total,
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                if method == Method::Exact && cells > FACTORIZED {
                    continue;
                }
                let rows = pool.install(|| {
                    rows(&body, method, &TOLERANCES, repetitions, &reference, &sample)
                })?;
                for row in &rows {
                    let met = |cell: Cell| if row.met { cell } else { Cell::Failed };
                    let measured = |value: f64| match level {
                        Level::Paper => value.into(),
                        Level::Smoke => Cell::Missing,
                    };
                    table.push([
                        cells.into(),
                        n.into(),
                        method.name().into(),
                        row.tolerance.into(),
                        met(row.iterations.into()),
                        met(row.cost.into()),
                        row.algebraic[0].into(),
                        row.algebraic[1].into(),
                        row.total.into(),
                        measured(row.setup),
                        measured(row.solve),
                    ]);
                }
                curves.push(Curve {
                    cells,
                    n,
                    method,
                    rows,
                });
            }
        }
        let largest = meshes.last().copied().unwrap_or(0).min(FACTORIZED);
        let shown: Vec<&Curve> = curves.iter().filter(|c| c.cells == largest).collect();
        let error = "algebraic error of u";
        findings.figures.push(figure(
            "e09_products",
            &format!("Error against the solution of the same mesh over C_s = n_it (1 + c_app), {largest}³ cells, tolerances from 0.5 to 1e-12; a line that ends early no longer fell."),
            Axis::log("C_s"),
            Axis::log(error),
            &shown,
            |row| [row.cost, row.algebraic[0]],
        ));
        if level == Level::Paper {
            findings.figures.push(figure(
                "e09_time",
                &format!("The same over processor time of one thread, set-up (with assembly) and solve, {largest}³ cells."),
                Axis::log("processor time [s]"),
                Axis::log(error),
                &shown,
                |row| [row.setup + row.solve, row.algebraic[0]],
            ));
        }
        findings.figures.push(meshes_figure(level, &curves));
        findings.checks = checks(&curves);
        findings.tables.push(table);
        Ok(findings)
    }
}
