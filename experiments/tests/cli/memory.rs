//! Claim: a run of a body that sticks takes little more memory than the solution of its one linear system.
#![allow(clippy::unwrap_used, reason = "a test that cannot read a report fails")]

use crate::run::{fracas, scratch};
use serde_json::Value;

/// Peak of `run` over that of `solve`: fields, states and what is written beside the same hierarchy and basis. Unit: 1.
const MOST: f64 = 1.3;

#[test]
fn a_run_in_stick_takes_little_more_memory_than_a_solve() {
    let peak = |json: &str| -> f64 {
        let value: Value = serde_json::from_str(json).unwrap();
        value["peak_memory_bytes"].as_f64().unwrap()
    };
    for (scene, cells) in [("analogue_a", 32), ("stretched", 48)] {
        let sets = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells={cells}"));
        let sets: Vec<&str> = sets.iter().flat_map(|s| ["--set", s]).collect();
        let solve = ["solve", scene, "--inner", "geometric", "--json", "-"];
        let solved = fracas(&[&solve[..], &sets].concat());
        assert_eq!(solved.status, 0, "{}", solved.stderr);
        let out = scratch(&format!("memory-{scene}"));
        let run = ["run", scene, "--set", "solver.inner='geometric'"];
        let to = ["--out", out.to_str().unwrap()];
        let ran = fracas(&[&run[..], &sets, &to].concat());
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        let json = std::fs::read_to_string(out.join("run.json")).unwrap();
        let (of_run, of_solve) = (peak(&json), peak(&solved.stdout));
        assert!(
            of_run <= MOST * of_solve,
            "{scene}: {:.0} MiB, {:.0} MiB",
            of_run / 1048576.0,
            of_solve / 1048576.0
        );
        std::fs::remove_dir_all(out).unwrap();
    }
}
