//! Claim: every experiment holds at the smoke level and gives the numbers that are committed in `expected/`.
#![allow(clippy::unwrap_used)]

use fracas_experiments::list::EXPERIMENTS;
use fracas_experiments::report::Level;
use fracas_solvers::Silent;
use std::path::Path;

/// Numbers agree to this, relative (or absolute below 1e-3): what another direct solver or processor may change.
const TOLERANCE: f64 = 1e-6;

/// Iterations, and costs in proportion to them, agree to this or to one iteration: a residual may graze the tolerance.
const COUNTS: f64 = 0.1;

/// Splits a CSV line at commas outside quotes.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            other => cells.last_mut().unwrap().push(other),
        }
    }
    cells
}

fn agree(heading: &str, expected: &str, found: &str) -> bool {
    let count = heading.starts_with("n_it");
    match (expected.parse::<f64>(), found.parse::<f64>()) {
        (Ok(a), Ok(b)) if count => (a - b).abs() <= (COUNTS * a).max(1.0),
        (Ok(a), Ok(b)) if heading.starts_with("C_s") => (a - b).abs() <= COUNTS * a,
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
            let headings = cells(expected.lines().next().unwrap());
            for (line, (e, f)) in expected.lines().zip(found.lines()).enumerate() {
                for (column, (e, f)) in cells(e).iter().zip(&cells(f)).enumerate() {
                    assert!(
                        agree(&headings[column], e, f),
                        "{}:{} column {}: {e} expected, {f} found",
                        file.display(),
                        line + 1,
                        column + 1
                    );
                }
            }
        }
    }
}
