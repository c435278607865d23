//! Settings of multigrid, on systems with all faces in stick.

use super::sweep::{Count, Row, sweep};
use crate::report::Level;
use fracas::multigrid::Geometric;
use fracas::scene::{gallery, named};
use fracas::solve::{InnerRule, Problem, Solve, StuckBody};
use fracas_solvers::amg::Amg;
use fracas_solvers::saddle::{InnerChoice, Measure, Racp, SaddleMethod};
use fracas_solvers::{Observer, Silent};

/// Small scenes: one rock, layers, flat cells, a crack in a graded mesh, a network.
const FEW: [&str; 5] = [
    "clamped",
    "layered",
    "stretched",
    "inclined_crack",
    "analogue_c_blocks",
];

/// Unknowns at which hierarchies end, so that small bodies have levels.
const GEOMETRIC: usize = 60;
const ALGEBRAIC: usize = 100;

/// Iterations after which there is no solution.
const MOST: usize = 400;

fn problems(level: Level) -> anyhow::Result<Vec<(String, Problem)>> {
    let scenes: Vec<&str> = match level {
        Level::Smoke => FEW.to_vec(),
        Level::Paper => gallery().iter().map(|scene| scene.name).collect(),
    };
    let problem = |name: &str| {
        let scene = named(name).ok_or_else(|| anyhow::anyhow!("no scene {name}"))?;
        let body = StuckBody::of_body(name, scene.small_scene()?.build()?);
        Ok((name.to_owned(), Problem::Body(body)))
    };
    scenes.into_iter().map(problem).collect()
}

/// n_it and C_s with this inner solver.
fn count(problem: &Problem, inner: InnerChoice) -> Option<Count> {
    let settings = Solve {
        method: SaddleMethod::Racp(Racp {
            inner,
            ..Racp::default()
        }),
        inner: InnerRule::Fixed,
        measure: Measure::Residual,
        max_iterations: MOST,
        ..Solve::default()
    };
    let solved = settings.solve(problem, &mut Silent).ok()?;
    Some(Count {
        n_it: solved.iterations,
        cost: solved.c_s?,
    })
}

/// Geometric multigrid, its grids, algebraic multigrid.
pub(super) fn rows(level: Level, observer: &mut dyn Observer) -> anyhow::Result<Vec<Row>> {
    let problems = problems(level)?;
    let names: Vec<String> = problems.iter().map(|(name, _)| name.clone()).collect();
    let deep = Geometric {
        coarsest: GEOMETRIC,
        ..Geometric::default()
    };
    let amg = Amg {
        coarsest: ALGEBRAIC,
        ..Amg::default()
    };
    let geometric =
        |k: usize, settings| Ok(count(&problems[k].1, InnerChoice::Geometric(settings)));
    let grids = |k: usize, lines| geometric(k, Geometric { lines, ..deep });
    let algebraic = |k: usize, settings| Ok(count(&problems[k].1, InnerChoice::Amg(settings)));
    let mut rows = sweep("geometric", deep, &names, geometric, observer)?;
    rows.extend(sweep("grid lines", deep.lines, &names, grids, observer)?);
    rows.extend(sweep("algebraic", amg, &names, algebraic, observer)?);
    Ok(rows)
}
