//! Claim: every experiment holds at the smoke level and gives the numbers that are committed in `expected/`.
#![allow(clippy::unwrap_used)]

mod csv;

use csv::cells;
use fracas_experiments::list::EXPERIMENTS;
use fracas_experiments::report::{Experiment, Level};
use fracas_solvers::Silent;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Numbers agree to this, relative (or absolute below 1e-3): what another direct solver or processor may change.
const TOLERANCE: f64 = 1e-6;

/// Iterations, and what is computed from them, agree to one and this share of them: the residual that ends an iteration crosses the
/// tolerance sooner or later where another processor rounds otherwise.
const COUNTS: f64 = 0.1;

/// Iterations of SQMR around multigrid in f32 agree to this: its residuals go up and down, and where they cross the tolerance is chance.
const WILD: f64 = 0.3;

/// Iterations until the error is small (e24) agree to this: an estimate near its limit asks for a pass more.
const PASSES: f64 = 1.0;

/// What e04b finds best by a count that others reach within one or two: any of them may stand there.
const BEST: [&str; 4] = ["C", "cycle, precision", "Krylov", "c_app"];

/// Errors against a known solution agree to this, relative: an iteration in f32 that ends early differs in the sixth digit on
/// another processor. So do overlaps, which are what is left of jumps.
const ERRORS: f64 = 1e-4;

/// What an application of multigrid costs, and the size of its levels, agree to this: one node may go to another aggregate.
const LEVELS: f64 = 1e-2;

/// Bounds that hold with the error bars of an iteration agree to this.
const BOUNDS: f64 = 1e-3;

/// Algebraic errors, and error bars, agree to this factor; one below [`ROUNDING`] says only that.
const ORDER: f64 = 10.0;

/// Relative errors of f64, and bounds, that mean nothing.
const ROUNDING: f64 = 1e-12;

/// Experiments that take a quarter of a minute or more. They begin first, so that no core waits for one of them at the end.
const LONG: [&str; 5] = ["e04b", "e09", "e22", "e24", "e26"];

/// What a row says of the others of its numbers.
#[derive(Clone, Copy)]
struct Row {
    /// n_it that it expects, where it counts any.
    iterations: Option<f64>,
    /// Share to which its iterations agree.
    counts: f64,
}

fn agree(column: &str, expected: &str, found: &str, row: Row) -> bool {
    let (Ok(a), Ok(b)) = (expected.parse::<f64>(), found.parse::<f64>()) else {
        return expected == found;
    };
    let is = |prefixes: &[&str]| prefixes.iter().any(|prefix| column.starts_with(prefix));
    let most = if is(&["algebraic error", "error bar"]) {
        // falls by orders of magnitude per iteration
        return a.max(b) <= ORDER * a.min(b).max(ROUNDING);
    } else if is(&["n_it"]) {
        row.counts * a + 1.0
    } else if is(&["error", "largest overlap"]) {
        ERRORS * a.abs()
    } else if is(&["c_app", "complexity"]) {
        LEVELS * a.abs()
    } else if is(&["proved"]) {
        BOUNDS * a.abs().max(ROUNDING)
    } else if is(&["C_s"]) {
        // n_it (1 + c_app): one iteration more or less, and c_app as other numbers
        let one = row.iterations.map_or(0.0, |n| a.abs() / n);
        (row.counts * a.abs() + one) * (1.0 + LEVELS)
    } else {
        TOLERANCE * a.abs().max(1e-3)
    };
    (a - b).abs() <= most
}

#[test]
fn smoke_experiments_hold_and_give_the_committed_numbers() {
    let mut experiments: Vec<_> = EXPERIMENTS.iter().collect();
    let known = |id: &&str| experiments.iter().any(|e| e.id() == *id);
    assert!(LONG.iter().all(known), "{LONG:?}");
    experiments.sort_by_key(|experiment| !LONG.contains(&experiment.id()));
    let (next, wrong) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let work = || {
        while let Some(experiment) = experiments.get(next.fetch_add(1, Ordering::Relaxed)) {
            let found = differences(**experiment);
            wrong.lock().unwrap().extend(found);
        }
    };
    // most of them keep one core busy
    std::thread::scope(|scope| {
        scope.spawn(work);
        scope.spawn(work);
    });
    let mut wrong = wrong.into_inner().unwrap();
    wrong.sort();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Checks that fail and numbers that are others.
fn differences(experiment: &dyn Experiment) -> Vec<String> {
    let findings = experiment.run(Level::Smoke, &mut Silent).unwrap();
    let id = experiment.id();
    let failed = findings.checks.iter().filter(|check| !check.pass);
    let failed = failed.map(|check| {
        format!(
            "{id}: {} ({} expected, {} found)",
            check.claim, check.expected, check.ours
        )
    });
    let mut wrong: Vec<String> = failed.collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("expected")
        .join(id);
    for table in &findings.tables {
        let file = folder.join(format!("{}.csv", table.id));
        let expected = std::fs::read_to_string(&file).unwrap();
        compare(&file, &expected, &table.to_csv(), &mut wrong);
    }
    wrong
}

/// Adds a line for every number that differs from that of the file.
fn compare(file: &Path, expected: &str, found: &str, wrong: &mut Vec<String>) {
    let rows = [expected, found].map(|table| table.lines().count());
    if rows[0] != rows[1] {
        wrong.push(format!(
            "{}: {} lines expected, {} found",
            file.display(),
            rows[0],
            rows[1]
        ));
        return;
    }
    let names = cells(expected.lines().next().unwrap());
    let table = file.file_stem().unwrap_or_default();
    let count = names.iter().position(|name| *name == "n_it");
    for (line, (e, f)) in expected.lines().zip(found.lines()).enumerate() {
        let row = Row {
            iterations: count.and_then(|column| cells(e)[column].parse().ok()),
            counts: match () {
                () if table == "e24_iterations" => PASSES,
                () if cells(e).iter().any(|cell| cell == "sqmr") => WILD,
                () => COUNTS,
            },
        };
        for (column, (e, f)) in names.iter().zip(cells(e).iter().zip(&cells(f))) {
            let is_chosen = table == "e04b_best" && BEST.contains(&column.as_str());
            if !is_chosen && !agree(column, e, f, row) {
                wrong.push(format!(
                    "{}:{} column {column}: {e} expected, {f} found",
                    file.display(),
                    line + 1
                ));
            }
        }
    }
}
