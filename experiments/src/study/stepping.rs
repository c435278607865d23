//! A row that runs its scene through its load steps.

use super::measured::{Measured, Steps};
use super::outcome::Outcome;
use super::product::Case;
use super::run_files::{krylov_median, lost};
use super::slipping::faults;
use super::solving::Watch;
use crate::rates::{median, quantile};
use anyhow::Context;
use fracas::run::{Outcome as Ending, Run, Taken, holds_run};
use fracas_solvers::Silent;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Folder of the runs of a study.
const RUNS: &str = "runs";

/// File of the systems of a run.
const SYSTEMS: &str = "solver.csv";

/// Folders of this process that do not stay: studies may run at once, and number their rows alike.
static FOLDERS: AtomicUsize = AtomicUsize::new(0);

/// Runs the scene in a folder of its own, from its last checkpoint where it has one; without a place the folder does not stay.
///
/// # Errors
/// Of the scene and of files; a step that fails is an outcome.
pub(super) fn run(
    case: &Case,
    place: Option<&Path>,
    watch: &Watch<'_>,
    measured: &mut Measured,
) -> anyhow::Result<()> {
    let scene = case.scene()?.context("a system folder has no load steps")?;
    let name = case.setting.scene.clone().unwrap_or_default();
    let out = match place {
        Some(place) => place.join(RUNS).join(case.number.to_string()),
        None => {
            let own = FOLDERS.fetch_add(1, Ordering::Relaxed);
            std::env::temp_dir().join(format!("fracas-row-{}-{own}", std::process::id()))
        }
    };
    let goes_on = place.is_some() && holds_run(&out);
    if out.exists() && !goes_on {
        std::fs::remove_dir_all(&out)?;
    }
    let settings = Run {
        restart: goes_on.then(|| out.clone()),
        out: Some(out.clone()),
        fields_every: usize::MAX,
        ..Run::default()
    };
    let start = Instant::now();
    let mut folder = settings.open(&name, scene, &mut Silent)?;
    let mut run = folder.begin(&mut Silent)?;
    let ended = loop {
        if let Taken::Ended(ended) = run.advance(watch, &mut Silent)? {
            break ended;
        }
    };
    let sum = |column: &str| run.history().column(column).sum::<f64>() as usize;
    let at_rest = run.history().column("time_s").filter(|time| *time == 0.0);
    let at_rest = at_rest.count();
    let later = |column: &str| {
        let later = run.history().column(column).skip(at_rest);
        later.map(|count| count as usize).collect()
    };
    let mut steps = Steps {
        steps: run.history().len(),
        rounds_95: quantile(later("active_it"), 0.95),
        newton_median: median(later("newton_it")),
        krylov_median: None,
        lost: None,
        rounds: sum("active_it"),
        newton: sum("newton_it"),
        krylov: sum("lin_it"),
        cuts: sum("cuts"),
        wall_s: start.elapsed().as_secs_f64(),
    };
    measured.steps = Some(steps);
    measured.sizes = Some([run.state().u.len(), run.state().t.len(), 0]);
    let outcome = match ended.outcome {
        Ending::NotConverged => Outcome::IterationLimit,
        Ending::Unstable => Outcome::Breakdown,
        // a wish to stop leaves no row
        Ending::Interrupted => Outcome::CostLimit,
        _ => Outcome::Converged,
    };
    measured.outcome.get_or_insert(outcome);
    measured.reasons.extend(ended.reason.clone());
    run.close(&ended)?;
    drop(folder);
    // files of flow and faults are not written for a scene without them
    let read = |file: &str| match std::fs::read_to_string(out.join(file)) {
        Err(error) if error.kind() == ErrorKind::NotFound && file != SYSTEMS => Ok(String::new()),
        text => text.with_context(|| format!("cannot read {}", out.join(file).display())),
    };
    steps.krylov_median = krylov_median(&read(SYSTEMS)?, at_rest)?;
    steps.lost = lost(&read("flow.csv")?)?;
    measured.steps = Some(steps);
    measured.faults = faults(&read("fault.csv")?)?;
    if place.is_none() {
        std::fs::remove_dir_all(&out)?;
    }
    Ok(())
}
