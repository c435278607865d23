//! e08: time, memory and iterations without an assembled A, from a hundred thousand unknowns up.

mod run;

use crate::measure::TOLERANCE;
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas_solvers::saddle::Racp;
use fracas_solvers::{Observer, Step};
use run::{Inner, Row, Run};
use std::ops::ControlFlow;

/// What does an unknown cost?
#[derive(Debug)]
pub struct Size;

/// The scene: layers of contrast 10, two fractures of 60° dip and a flat one that crosses them.
const SCENE: &str = "layered_crossing";

/// Cells per axis, multiples of 8, so that the fractures lie on grid planes.
const SMOKE: [usize; 2] = [16, 24];

/// From 0.1 to 9 million unknowns.
const PAPER: [usize; 5] = [32, 48, 72, 96, 144];

/// The size of the lecture's largest system, 73.0 M displacements and 10.6 M tractions: a network of joints in bricks.
const LARGEST: (&str, [usize; 3], &[&str]) = (
    "analogue_c",
    [272, 260, 288],
    &["fracture.joint_x.every=9", "fracture.joint_y.every=9"],
);

/// Unknowns up to which RACP with algebraic multigrid on the assembled matrix stands beside.
const ASSEMBLED: usize = 1_500_000;

/// Unknowns up to which one thread runs, too.
const ONE_THREAD: usize = 3_500_000;

/// Largest growth of n_it from the first to the last mesh of [`SCENE`].
const GROWTH: f64 = 2.0;

/// Largest n_it.
const MOST: f64 = 20.0;

/// Time per unknown on the largest mesh over that at half a million unknowns.
const FLAT: f64 = 1.5;

/// Memory of the assembled path over that of the matrix-free one, same mesh.
const LEANER: f64 = 3.0;

/// One mesh.
struct Mesh {
    scene: &'static str,
    cells: [usize; 3],
    more: &'static [&'static str],
}

impl Mesh {
    fn overrides(&self) -> Vec<String> {
        let axes = ["x", "y", "z"].iter().zip(self.cells);
        let cells = axes.map(|(axis, n)| format!("mesh.{axis}.cells={n}"));
        let more = self.more.iter().map(|text| (*text).to_owned());
        cells.chain(more).collect()
    }
}

/// The runs of one level, largest last.
fn runs(level: Level) -> Vec<(Mesh, Inner, usize)> {
    let cube = |n: usize| Mesh {
        scene: SCENE,
        cells: [n; 3],
        more: &[],
    };
    let sizes: &[usize] = match level {
        Level::Smoke => &SMOKE,
        Level::Paper => &PAPER,
    };
    let mut runs = Vec::new();
    for n in sizes {
        let unknowns = 3 * (n + 1).pow(3);
        for (inner, threads, limit) in [
            (Inner::Geometric, 1, ONE_THREAD),
            (Inner::Geometric, 2, usize::MAX),
            (Inner::Algebraic, 1, ASSEMBLED),
            (Inner::Algebraic, 2, ASSEMBLED),
        ] {
            if unknowns <= limit {
                runs.push((cube(*n), inner, threads));
            }
        }
    }
    if level == Level::Paper {
        let (scene, cells, more) = LARGEST;
        let mesh = Mesh { scene, cells, more };
        runs.push((mesh, Inner::Geometric, 2));
    }
    runs
}

fn table() -> Table {
    Table::new(
        "e08_size",
        "RACP to a true relative residual of 1e-8 under the load of the scene. Geometric multigrid assembles no A, \
         algebraic multigrid starts from the assembled matrix; set-up counts assembly. Time per unknown: set-up and solve.",
        &[
            "scene",
            "cells",
            "n",
            "n_u",
            "n_t",
            "inner",
            "threads",
            "Krylov",
            "n_it",
            "mesh [s]",
            "set-up [s]",
            "solve [s]",
            "time per unknown [µs]",
            "memory [MiB]",
            "memory per unknown [B]",
        ],
    )
}

fn cells(mesh: &Mesh, inner: Inner, threads: usize, row: &Row, level: Level) -> Vec<Cell> {
    // clocks and memory at paper level only: equal runs of the smoke level give equal bytes
    let clock = |value: f64| match level {
        Level::Paper => value.into(),
        Level::Smoke => Cell::Missing,
    };
    let [x, y, z] = mesh.cells;
    let n = row.n_u + row.n_t;
    let memory = row.memory.map(|bytes| bytes as f64);
    let memory = |unit: f64| memory.map_or(Cell::Missing, |bytes| clock(bytes / unit));
    vec![
        mesh.scene.into(),
        format!("{x} × {y} × {z}").into(),
        n.into(),
        row.n_u.into(),
        row.n_t.into(),
        inner.name().into(),
        threads.into(),
        row.krylov.clone().into(),
        row.iterations.map_or(Cell::Failed, Cell::from),
        clock(row.mesh),
        clock(row.setup),
        clock(row.solve),
        clock(1e6 * row.per_unknown()),
        memory(f64::from(1 << 20)),
        memory(n as f64),
    ]
}

/// One quantity of every inner solver and number of threads against n.
fn figure(
    id: &str,
    caption: &str,
    y: &str,
    rows: &[(Run, Row)],
    value: impl Fn(&Row) -> Option<f64>,
) -> Figure {
    let axis = Axis::log("unknowns n");
    let mut figure = Figure::new(id, "", caption, axis, Axis::log(y));
    for (tone, (inner, threads)) in [
        (Inner::Geometric, 2),
        (Inner::Geometric, 1),
        (Inner::Algebraic, 2),
        (Inner::Algebraic, 1),
    ]
    .into_iter()
    .enumerate()
    {
        let points: Vec<[f64; 2]> = rows
            .iter()
            .filter(|(run, _)| run.is(inner, threads))
            .filter_map(|(_, row)| Some([(row.n_u + row.n_t) as f64, value(row)?]))
            .collect();
        if !points.is_empty() {
            let name = format!("{}, threads: {threads}", inner.name());
            figure = figure.with(Series::new(&name, Mark::LinePoints, points).tone(tone));
        }
    }
    figure
}

fn checks(rows: &[(Run, Row)], level: Level) -> Vec<Check> {
    let of = |inner, threads| {
        rows.iter()
            .filter(move |(run, _)| run.is(inner, threads))
            .map(|(_, row)| row)
    };
    let cubes: Vec<&Row> = rows
        .iter()
        .filter(|(run, _)| run.scene == SCENE && run.is(Inner::Geometric, 2))
        .map(|(_, row)| row)
        .collect();
    let mut checks: Vec<Check> = Vec::new();
    if let (Some(first), Some(last)) = (cubes.first(), cubes.last()) {
        checks.push(Check::at_most(
            format!(
                "geometric: n_it at {} unknowns less that at {}",
                last.n(),
                first.n()
            ),
            GROWTH,
            last.count() - first.count(),
        ));
    }
    let most = of(Inner::Geometric, 2).map(Row::count).fold(0.0, f64::max);
    checks.push(Check::at_most("geometric: largest n_it", MOST, most));
    for (one, two) in of(Inner::Geometric, 1).zip(of(Inner::Geometric, 2)) {
        checks.push(Check::equal(
            format!(
                "entries of the solution that differ between 1 and 2 threads at {} unknowns",
                one.n()
            ),
            0,
            one.differences(two),
        ));
    }
    if level == Level::Smoke {
        return checks;
    }
    let middle = cubes.iter().find(|row| row.n() > 300_000);
    if let (Some(middle), Some(last)) = (middle, cubes.last()) {
        checks.push(Check::at_most(
            format!(
                "geometric: time per unknown at {} unknowns over that at {}",
                last.n(),
                middle.n()
            ),
            FLAT,
            last.per_unknown() / middle.per_unknown(),
        ));
    }
    let pair = of(Inner::Algebraic, 2).next_back().and_then(|assembled| {
        let free = of(Inner::Geometric, 2).find(|row| row.n() == assembled.n())?;
        Some((
            assembled.n(),
            assembled.memory? as f64 / free.memory? as f64,
        ))
    });
    if let Some((n, ratio)) = pair {
        checks.push(Check::at_least(
            format!(
                "memory of the assembled path over that of the matrix-free one at {n} unknowns"
            ),
            LEANER,
            ratio,
        ));
    }
    checks
}

impl Experiment for Size {
    fn id(&self) -> &'static str {
        "e08"
    }

    fn title(&self) -> &'static str {
        "Time and memory against the size, without an assembled A"
    }

    fn question(&self) -> &'static str {
        "What does an unknown cost in time and memory when A is never assembled, from a hundred thousand unknowns to the lecture's 73 million?"
    }

    fn setup(&self) -> &'static str {
        "`layered_crossing`, a cube of 8 m with stiff and soft layers, two fractures of 60° dip and a flat one that crosses them, \
         from 32³ to 144³ cells; and, where memory allows, the lecture's largest size on a network of joints (`analogue_c`, 272 × 260 × \
         288 cells). All faces in stick, jump stabilization, true relative residual 1e-8; FGMRES where its basis fits \
         into memory, SQMR where it does not. One and two threads; beside it RACP around algebraic multigrid of the assembled \
         matrix up to a million unknowns."
    }

    fn expect(&self) -> &'static str {
        "Iterations constant within a few (aim: 2), time per unknown flat, memory a small multiple of the vectors: the matrix is what the \
         assembled path spends its memory on. The same bits for one and two threads."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings
            .set("scene", SCENE)
            .set("level", level.word())
            .set("tolerance", TOLERANCE)
            .set("augmentation", Racp::default().augmentation.name());
        let runs = runs(level);
        let total = runs.len();
        let mut table = table();
        let mut rows: Vec<(Run, Row)> = Vec::new();
        for (done, (mesh, inner, threads)) in runs.into_iter().enumerate() {
            let stage = inner.name();
            if observer.observe(&Step::Progress { stage, done, total }) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            let run = Run {
                scene: mesh.scene,
                overrides: mesh.overrides(),
                inner,
                threads,
            };
            match run.measure()? {
                Ok(row) => {
                    table.rows.push(cells(&mesh, inner, threads, &row, level));
                    rows.push((run, row));
                }
                Err(reason) => findings.notes.push(format!("Not run: {reason}.")),
            }
        }
        if level == Level::Paper {
            findings.figures.push(figure(
                "e08_time",
                "Set-up and solve against the number of unknowns.",
                "time [s]",
                &rows,
                |row| Some(row.setup + row.solve),
            ));
            findings.figures.push(figure(
                "e08_memory",
                "Peak memory of mesh, set-up and solve against the number of unknowns.",
                "memory [MiB]",
                &rows,
                |row| Some(row.memory? as f64 / f64::from(1 << 20)),
            ));
        }
        findings.figures.push(figure(
            "e08_iterations",
            "Iterations against the number of unknowns.",
            "n_it",
            &rows,
            |row| row.iterations.map(|n| n as f64),
        ));
        findings.checks = checks(&rows, level);
        findings.tables.push(table);
        Ok(findings)
    }
}
