//! Settings of the search for contact states, on runs.

use super::sweep::{Count, Row, sweep};
use crate::report::Level;
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, Rounds, gallery};
use fracas_solvers::{Observer, Silent};

/// Scenes that go through states.
const FEW: [&str; 3] = ["cycle", "crossing", "inclined_crack"];

fn bodies(level: Level) -> anyhow::Result<Vec<(String, Body)>> {
    let mut bodies = Vec::new();
    for scene in gallery() {
        if level == Level::Smoke && !FEW.contains(&scene.name) {
            continue;
        }
        let body = scene.small_scene()?.build()?;
        if body.friction.iter().all(Option::is_some) {
            bodies.push((scene.name.to_owned(), body));
        }
    }
    Ok(bodies)
}

fn count(body: &Body, rounds: Rounds) -> anyhow::Result<Option<Count>> {
    let mut body = body.clone();
    body.solver.rounds = rounds;
    let (mut n_it, mut krylov) = (0, 0);
    let end = Simulation::new(&body)?.run(&mut Silent, |_, _, done| {
        n_it += done.record.active_it;
        krylov += done.record.lin_it;
    });
    let cost = krylov as f64;
    Ok(end.is_ok().then_some(Count { n_it, cost }))
}

/// Rounds of contact states.
pub(super) fn rows(level: Level, observer: &mut dyn Observer) -> anyhow::Result<Vec<Row>> {
    let bodies = bodies(level)?;
    let names: Vec<String> = bodies.iter().map(|(name, _)| name.clone()).collect();
    let run = |k: usize, rounds: Rounds| count(&bodies[k].1, rounds);
    sweep("rounds", Rounds::default(), &names, run, observer)
}
