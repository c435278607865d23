//! Claim: every experiment holds at the smoke level and gives the numbers that are committed in `expected/`.
#![allow(clippy::unwrap_used)]

mod csv;

use csv::cells;
use fracas_experiments::list::EXPERIMENTS;
use fracas_experiments::report::Level;
use fracas_solvers::Silent;
use std::path::Path;

/// Numbers agree to this, relative (or absolute below 1e-3): what another direct solver or processor may change.
const TOLERANCE: f64 = 1e-6;

/// Iterations, and what is computed from them, agree to this: the residual that ends an iteration crosses the tolerance one
/// step sooner or later where another processor rounds otherwise.
const COUNTS: f64 = 0.1;

/// Errors against a known solution agree to this, relative: an iteration in f32 that ends early differs in the sixth digit on
/// another processor.
const ERRORS: f64 = 1e-4;

/// Algebraic errors agree to this factor; one below [`ROUNDING`] says only that.
const ORDER: f64 = 10.0;

/// Relative errors of f64 that mean nothing.
const ROUNDING: f64 = 1e-12;

/// `iterations` are those that the row expects, where it counts any.
fn agree(column: &str, expected: &str, found: &str, iterations: Option<f64>) -> bool {
    match (expected.parse::<f64>(), found.parse::<f64>()) {
        (Ok(a), Ok(b)) if column.starts_with("n_it") => (a - b).abs() <= (COUNTS * a).max(1.0),
        // falls by orders of magnitude per iteration
        (Ok(a), Ok(b)) if column.starts_with("algebraic error") => {
            a.max(b) <= ORDER * a.min(b).max(ROUNDING)
        }
        (Ok(a), Ok(b)) if column.starts_with("error") => (a - b).abs() <= ERRORS * a.abs(),
        // n_it (1 + c_app): one iteration more or less, and c_app as other numbers
        (Ok(a), Ok(b)) if column.starts_with("C_s") => {
            let one = iterations.map_or(0.0, |n| a.abs() / n);
            (a - b).abs() <= (COUNTS * a.abs()).max(one) * (1.0 + ERRORS)
        }
        (Ok(a), Ok(b)) => (a - b).abs() <= TOLERANCE * a.abs().max(1e-3),
        _ => expected == found,
    }
}

#[test]
fn smoke_experiments_hold_and_give_the_committed_numbers() {
    for experiment in EXPERIMENTS {
        let findings = experiment.run(Level::Smoke, &mut Silent).unwrap();
        for check in &findings.checks {
            assert!(
                check.pass,
                "{}: {} ({} expected, {} found)",
                experiment.id(),
                check.claim,
                check.expected,
                check.ours
            );
        }
        for table in &findings.tables {
            let file = Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("expected")
                .join(experiment.id())
                .join(format!("{}.csv", table.id));
            let expected = std::fs::read_to_string(&file).unwrap();
            let found = table.to_csv();
            assert_eq!(
                expected.lines().count(),
                found.lines().count(),
                "{}",
                file.display()
            );
            let names = cells(expected.lines().next().unwrap());
            let count = names.iter().position(|name| *name == "n_it");
            for (line, (e, f)) in expected.lines().zip(found.lines()).enumerate() {
                let iterations = count.and_then(|column| cells(e)[column].parse().ok());
                for (column, (e, f)) in names.iter().zip(cells(e).iter().zip(&cells(f))) {
                    assert!(
                        agree(column, e, f, iterations),
                        "{}:{} column {column}: {e} expected, {f} found",
                        file.display(),
                        line + 1
                    );
                }
            }
        }
    }
}
