//! e27: what ranks gain, measured on 1, 2 and 4 of them, and to thousands by a model of messages.

mod division;
mod measured;
mod model;

use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use crate::scenes::with_cells;
use division::{Division, divide, shell};
use fracas::scene::named;
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::Observer;
use measured::{Run, SCENE, Times, Who};
use model::{Model, NETWORK, Wire};

/// What do many ranks gain?
#[derive(Debug)]
pub struct Ranks;

/// Cells per axis of the bodies that are divided, and the most parts.
const fn divided_at(level: Level) -> (&'static [usize], usize) {
    match level {
        Level::Smoke => (&[16, 24], 32),
        Level::Paper => (&[24, 48, 72], 512),
    }
}

/// Cells per axis with which one and two ranks solve, and of about half as many for one rank.
const fn solved_at(level: Level) -> [usize; 2] {
    match level {
        Level::Smoke => [24, 16],
        Level::Paper => [72, 56],
    }
}

/// Displacements of the test of scalability of the lecture (M. Ferronato, SNA'25).
const PUBLISHED: f64 = 73_042_971.0;

/// Least gain of a second rank. Unit: 1.
const GAIN: f64 = 1.7;

/// Most iterations over those of one rank: aggregates of GAMG end where the rows of a rank end. Unit: 1.
const MORE: f64 = 1.1;

/// Most memory of each of two ranks over that of one. Unit: 1.
const MEMORY: f64 = 0.75;

/// How far the model may be from what an iteration took on two ranks. Unit: 1.
const OFF: f64 = 0.25;

/// Ranks of the curves: powers of two to 4,096.
const POWERS: std::ops::RangeInclusive<u32> = 0..=12;

/// As many threads as this machine runs at once.
fn cores() -> f64 {
    std::thread::available_parallelism().map_or(1.0, |n| n.get() as f64)
}

impl Experiment for Ranks {
    fn id(&self) -> &'static str {
        "e27"
    }

    fn title(&self) -> &'static str {
        "Scaling over ranks, measured and modelled"
    }

    fn question(&self) -> &'static str {
        "What does a second rank gain in time and memory, and what would messages cost 4,096 of them?"
    }

    fn setup(&self) -> &'static str {
        "`layered_crossing`, divided by METIS as the engine `petsc` divides it: ghosts and neighbours of the parts. In a build with PETSc it is then solved on \
         1, 2 and 4 ranks (1e-8, RACP around GAMG) and by one process with two threads, each a process of its own, with the times of a product, of M⁻¹, of \
         sums and of messages. Paper 72³ cells, smoke 24³; one rank solves about half as many, too. A model of the cost of messages gives weak and strong \
         scaling to 4,096 ranks, with the wire of this machine and with an assumed network of 2 µs and 10 GB/s."
    }

    fn expect(&self) -> &'static str {
        "The lecture shows weak and strong scaling of RACP with Chronos on 73,042,971 displacements as pictures; their numbers are not printed, so that nothing \
         stands beside the curves. Ours: a tenth more iterations at most, a second rank that gains 1.7 in products, in M⁻¹ and in the whole, and a model within a quarter of what \
         an iteration takes on two ranks."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word()).set("scene", SCENE);
        let divisions = divisions(level)?;
        let surface = divisions.iter().flat_map(|(_, all)| all);
        let surface = surface.map(Division::over_cube).fold(0.0, f64::max);
        divided(&divisions, surface, &mut findings);
        match measured::program() {
            Err(why) => findings.notes.push(format!(
                "No times and no curves: {why}. docs/clusters.md has those of a machine with two cores."
            )),
            Ok(program) => {
                let [cells, half] = solved_at(level);
                let solves = [
                    (Who::Ranks(1), half),
                    (Who::Ranks(1), cells),
                    (Who::Ranks(2), cells),
                    (Who::Ranks(4), cells),
                    (Who::Threads(2), cells),
                ];
                let runs: Result<Vec<_>, _> = solves
                    .iter()
                    .map(|(who, cells)| {
                        observer.say(&format_args!("{} on {cells}³ cells", who.name()));
                        measured::solve(&program, *who, *cells)
                    })
                    .collect();
                match runs {
                    Ok(runs) => times(&runs, surface, level, &mut findings)?,
                    Err(why) => findings.notes.push(format!("No times and no curves: {why}.")),
                }
            }
        }
        Ok(findings)
    }
}

/// Bodies in 2, 4, 8, … parts.
fn divisions(level: Level) -> anyhow::Result<Vec<(usize, Vec<Division>)>> {
    let scene = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
    let scene = scene.scene()?;
    let (sizes, most) = divided_at(level);
    let mut all = Vec::new();
    for cells in sizes {
        let body = with_cells(&scene, [*cells; 3])?.build()?;
        let parts = (1..).map(|k| 1 << k).take_while(|parts| *parts <= most);
        let divisions: Result<Vec<_>, _> = parts.map(|parts| divide(&body, parts)).collect();
        all.push((*cells, divisions?));
    }
    Ok(all)
}

/// Table and figure of what ranks have and ask for.
fn divided(divisions: &[(usize, Vec<Division>)], surface: f64, findings: &mut Findings) {
    let mut table = Table::new(
        "e27_divided",
        "Parts of the nodes with a free displacement: the most that a part has, the most of other parts that its rows name, and from how many \
         parts those are.",
        &[
            "cells",
            "parts",
            "nodes",
            "most nodes",
            "most ghosts",
            "neighbours",
            "ghosts / those of a cube",
        ],
    );
    let mut figure = Figure::new(
        "e27_surface",
        "",
        "Ghosts of the part with the most, against the nodes of a part: the surface of a volume, once parts lie inside the body.",
        Axis::log("nodes per part"),
        Axis::log("ghosts"),
    );
    for (cells, all) in divisions {
        let point = |d: &Division| [d.share(), d.ghosts as f64];
        let points = all.iter().map(point).collect();
        figure = figure.with(Series::new(
            &format!("{cells}³ cells"),
            Mark::LinePoints,
            points,
        ));
        for d in all {
            table.push([
                format!("{cells}³").into(),
                d.parts.into(),
                d.nodes.into(),
                d.most.into(),
                d.ghosts.into(),
                d.neighbours.into(),
                d.over_cube().into(),
            ]);
        }
    }
    let ends = divisions
        .iter()
        .flat_map(|(_, all)| all)
        .map(Division::share);
    let [least, most] = [
        ends.clone().fold(f64::INFINITY, f64::min),
        ends.fold(0.0, f64::max),
    ];
    let steps = (0..=32).map(|k| least * (most / least).powf(f64::from(k) / 32.0));
    let cube = steps.map(|n| [n, shell(n)]).collect();
    figure = figure.with(Series::new("a cube in the body", Mark::Dashed, cube));
    findings.figures.push(figure);
    findings.tables.push(table);
    let all = || divisions.iter().flat_map(|(_, all)| all);
    let uneven = all().map(|d| d.most as f64 / d.share()).fold(0.0, f64::max);
    findings.checks.extend([
        Check::at_most(
            "nodes of the largest part over those of the mean",
            1.1,
            uneven,
        ),
        Check::at_most(
            "ghosts of a part over those of a cube of as many nodes",
            2.0,
            surface,
        ),
    ]);
}

/// Tables, curves and claims of what was measured.
fn times(runs: &[Run], surface: f64, level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let [half, one, two, four, threads] = runs else {
        anyhow::bail!("five solves");
    };
    findings.tables.push(solved(runs));
    let of = |run: &Run| (run.times).ok_or_else(|| anyhow::anyhow!("{}: no times", run.who.name()));
    let (of_one, of_two) = (of(one)?, of(two)?);
    let here = Wire {
        message: of_two.message,
        per_byte: of_two.per_byte,
        stage: of_two.sum,
    };
    let work = one.per_iteration() / one.n_u as f64;
    let models = [here, NETWORK].map(|wire| Model {
        work,
        surface,
        wire,
    });
    let predicted = [(two, 2.0), (four, 4.0)].map(|(run, ranks)| {
        let model = models[0].on_cores(run.n_u as f64, ranks, cores().min(ranks));
        (run, model)
    });
    findings.tables.push(beside(&predicted));
    let per_rank = half.n_u as f64;
    // 2 ranks over one: with as many displacements each, and of the same ones
    let weak = 0.5 * half.per_iteration() / per_rank * two.n_u as f64 / two.per_iteration();
    let strong = 0.5 * one.per_iteration() / two.per_iteration();
    curves(&models, per_rank, [weak, strong], findings);
    findings.notes.push(format!(
        "Iterations take {:.2} s with two threads of one process and {:.2} s on two ranks, set-up {:.2} s and {:.2} s. Work that ranks of one machine share the memory's \
         speed for does not halve on two of them; the model takes it as if it did.",
        threads.solve, two.solve, threads.setup, two.setup
    ));
    findings
        .set("message_s", here.message)
        .set("per_byte_s", here.per_byte)
        .set("sum_s", here.stage)
        .set("ghosts_over_cube", surface)
        .set("work_per_displacement_s", work);
    // small bodies are all set-up and cache, and one core has no second rank
    if level == Level::Paper && cores() >= 2.0 {
        let most = two.iterations.max(four.iterations) as f64 / one.iterations as f64;
        let faster = |what: &str, of_one: f64, of_two: f64| {
            let claim = format!("{what}: time of one rank over that of two");
            Check::at_least(claim, GAIN, of_one / of_two)
        };
        let (run, model) = predicted[0];
        findings.checks.extend([
            Check::at_most("iterations on 2 and 4 ranks over those on one", MORE, most),
            Check::at_most(
                "memory of each of two ranks over that of one",
                MEMORY,
                two.peak / one.peak,
            ),
            faster("a product", of_one.product, of_two.product),
            faster("an M⁻¹", of_one.inverse, of_two.inverse),
            faster("assembly, set-up and iterations", one.whole(), two.whole()),
            Check::close(
                "model over measured time of an iteration on two ranks",
                1.0,
                model / run.per_iteration(),
                OFF,
            ),
        ]);
    }
    Ok(())
}

/// What an iteration takes in the model [s], and took.
fn beside(predicted: &[(&Run, f64)]) -> Table {
    let mut table = Table::new(
        "e27_predicted",
        "An iteration in the model, from what it takes on one rank and from messages, beside what it took.",
        &["who", "model [ms]", "measured [ms]", "model / measured"],
    );
    for (run, model) in predicted {
        let took = run.per_iteration();
        table.push([
            run.who.name().into(),
            (1e3 * model).into(),
            (1e3 * took).into(),
            (model / took).into(),
        ]);
    }
    table
}

/// Weak and strong scaling in the model, with what two ranks were `measured` to keep.
fn curves(models: &[Model; 2], per_rank: f64, measured: [f64; 2], findings: &mut Findings) {
    let powers = || POWERS.map(|k| f64::from(1u32 << k));
    let names = ["messages of this machine", "assumed network"];
    let mut weak = Figure::new(
        "e27_weak",
        "",
        &format!(
            "Weak scaling of an iteration in the model, {per_rank} displacements on each rank; measured on two ranks of one machine, which share its memory."
        ),
        Axis::log("ranks"),
        Axis::linear("efficiency").range(0.0, 1.05),
    );
    let mut strong = Figure::new(
        "e27_strong",
        "",
        &format!(
            "Strong scaling of an iteration in the model, {PUBLISHED} displacements: time of one rank that had them all over that of many."
        ),
        Axis::log("ranks"),
        Axis::log("speed-up"),
    );
    let mut table = Table::new(
        "e27_model",
        "Efficiency of an iteration in the model, with as many displacements on each rank and of the published size in all, beside that of the two ranks that were measured.",
        &[
            "ranks",
            "weak, this machine",
            "weak, network",
            "weak, measured",
            "strong, this machine",
            "strong, network",
            "strong, measured",
        ],
    );
    for ranks in powers() {
        let [a, b] = models.map(|model| model.weak(per_rank, ranks));
        let [c, d] = models.map(|model| model.strong(PUBLISHED, ranks) / ranks);
        let [weak, strong] = measured.map(|value| Some(value).filter(|_| ranks == 2.0));
        table.push([
            (ranks as usize).into(),
            a.into(),
            b.into(),
            weak.into(),
            c.into(),
            d.into(),
            strong.into(),
        ]);
    }
    for (name, model) in names.iter().zip(models) {
        let points = powers().map(|p| [p, model.weak(per_rank, p)]).collect();
        weak = weak.with(Series::new(name, Mark::LinePoints, points));
        let points = powers().map(|p| [p, model.strong(PUBLISHED, p)]).collect();
        strong = strong.with(Series::new(name, Mark::LinePoints, points));
    }
    weak = weak.with(Series::new(
        "measured",
        Mark::Points,
        vec![[2.0, measured[0]]],
    ));
    let ideal = powers().map(|p| [p, p]).collect();
    strong = strong.with(Series::new("perfect", Mark::Dashed, ideal));
    findings.tables.push(table);
    findings.figures.extend([weak, strong]);
}

/// What every solve took.
fn solved(runs: &[Run]) -> Table {
    let mut table = Table::new(
        "e27_solved",
        "Solves to 1e-8 with GAMG inside, each in processes of its own.",
        &[
            "who",
            "n_u",
            "n_t",
            "ghosts of u",
            "n_it",
            "peak of a rank [MiB]",
            "assembly [s]",
            "set-up [s]",
            "solve [s]",
            "product [ms]",
            "M⁻¹ [ms]",
            "sum [µs]",
            "message [µs]",
            "a byte [ns]",
        ],
    );
    for run in runs {
        let part = |scale: f64, of: fn(&Times) -> f64| {
            Cell::from(run.times.as_ref().map(|t| scale * of(t)))
        };
        table.push([
            run.who.name().into(),
            run.n_u.into(),
            run.n_t.into(),
            run.ghosts.into(),
            run.iterations.into(),
            (run.peak / f64::from(1 << 20)).round().into(),
            run.assembly.into(),
            run.setup.into(),
            run.solve.into(),
            part(1e3, |t| t.product),
            part(1e3, |t| t.inverse),
            part(1e6, |t| t.sum),
            part(1e6, |t| t.message),
            part(1e9, |t| t.per_byte),
        ]);
    }
    table
}
