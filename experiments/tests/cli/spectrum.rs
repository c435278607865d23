//! Claim: no eigenvalue lies outside of what is not claimed of it; what a verdict rests on stands beside it.

use crate::run::{fracas, scratch, write};
use std::path::PathBuf;

const GENERAL: &str = "%%MatrixMarket matrix coordinate real general\n";

/// A = diag(2, −½), B = (1 1)ᵀ and H: S_u = [3 1; 1 ½] is definite for C = 1, A is not.
fn two_springs(h: f64) -> PathBuf {
    let folder = scratch(&format!("two-springs-{h}"));
    for (file, text) in [
        ("A.mtx", format!("{GENERAL}2 2 2\n1 1 2\n2 2 -0.5\n")),
        ("B1.mtx", format!("{GENERAL}2 1 2\n1 1 1\n2 1 1\n")),
        ("H.mtx", format!("{GENERAL}1 1 1\n1 1 {h}\n")),
    ] {
        write(&folder.join(file), &text);
    }
    folder
}

#[test]
fn an_indefinite_stiffness_is_a_hypothesis_that_fails_and_no_eigenvalue_outside() {
    for (h, expected) in [(5.0, -7.0), (0.0, 3.0)] {
        let folder = two_springs(h);
        let system = folder.to_str().unwrap();
        let arguments = ["spectrum", "--system", system, "--augmentation", "global"];
        let ran = fracas(&[&arguments[..], &["--json", "-"]].concat());
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        let found = report["eigenvalues"]["re"].as_array().unwrap();
        let mut sorted = [1.0, 1.0, expected];
        sorted.sort_by(f64::total_cmp);
        for (found, expected) in found.iter().zip(sorted) {
            assert!(
                (found.as_f64().unwrap() - expected).abs() < 1e-9,
                "{report}"
            );
        }
        assert!(report["contained"].is_null(), "{report}");
        assert_eq!(report["bounds"]["theorem"], "none");
        let hypotheses = report["hypotheses"].as_array().unwrap();
        let failing = hypotheses.iter().filter(|h| h["holds"] == false);
        let failing: Vec<_> = failing.map(|h| h["statement"].as_str().unwrap()).collect();
        assert_eq!(failing, ["A ⪰ 0"]);
        let ran = fracas(&arguments);
        let verdict = "hypothesis fails: A is indefinite (λ_min ≤ -5.0e-1";
        assert!(
            ran.status == 0 && ran.stdout.contains(verdict),
            "{}",
            ran.stdout
        );
        assert!(ran.stdout.contains("A ⪰ 0 FAILS"), "{}", ran.stdout);
    }
}

#[test]
fn hypotheses_that_hold_stand_beside_the_verdict() {
    let ran = fracas(&["spectrum", "patch"]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    for part in [
        "A ⪰ 0 holds",
        "S̃_u ≻ 0 holds",
        "every eigenvalue lies inside",
    ] {
        assert!(ran.stdout.contains(part), "{part}: {}", ran.stdout);
    }
}
