//! Claim: `fracas solve` solves what it says, reports the true residual, and says by its status whether it converged.

use crate::run::{fracas, system_folder, write};
use fracas_operators::LinearOperator;
use fracas_operators::matrix_market::read_vector;
use fracas_solvers::saddle::SaddleOperator;
use fracas_solvers::saddle::folder::read_folder;
use serde_json::Value;

#[test]
fn the_solution_solves_the_system_and_the_report_has_its_keys() {
    let folder = system_folder("solution");
    let (system, file) = (folder.to_str().unwrap(), folder.join("x.mtx"));
    for method in [
        "racp",
        "mcp",
        "augmented_lagrangian",
        "block_diagonal",
        "block_triangular",
        "simple",
        "direct",
        "direct:faer",
    ] {
        let ran = fracas(&[
            "solve",
            "--system",
            system,
            "--method",
            method,
            "--json",
            "-",
            "--solution",
            file.to_str().unwrap(),
        ]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        let report: Value = serde_json::from_str(&ran.stdout).unwrap();
        for key in [
            "outcome",
            "iterations",
            "relative_residual",
            "method",
            "inner",
            "relaxation",
            "relaxation_degree",
            "krylov",
            "n_u",
            "n_t",
            "n_p",
            "c_app",
            "C_s",
            "setup_s",
            "solve_s",
            "peak_memory_bytes",
            "amg",
            "rhs",
        ] {
            assert!(report.get(key).is_some(), "no key {key}");
        }
        assert_eq!(
            (&report["outcome"], &report["rhs"]),
            (&"converged".into(), &"sin(i)".into())
        );
        let x = read_vector(&file).unwrap();
        let blocks = read_folder(&folder).unwrap().blocks;
        let operator = SaddleOperator::new(&blocks);
        let mut r: Vec<f64> = (1..=6).map(|i| f64::from(i).sin()).collect();
        let norm = r.iter().map(|b| b * b).sum::<f64>().sqrt();
        operator.apply_add(-1.0, &x, &mut r, &mut []);
        let residual = r.iter().map(|b| b * b).sum::<f64>().sqrt() / norm;
        assert!(
            residual < 1e-8
                && (report["relative_residual"].as_f64().unwrap() - residual).abs() < 1e-12
        );
    }
}

#[test]
fn the_right_hand_side_of_the_folder_is_taken_when_there_is_one() {
    let folder = system_folder("rhs");
    write(
        &folder.join("rhs_t.mtx"),
        "%%MatrixMarket matrix array real general\n2 1\n0\n0\n",
    );
    let json = |more: &[&str]| -> Value {
        let ran = fracas(
            &[
                &["solve", "--system", folder.to_str().unwrap(), "--json", "-"],
                more,
            ]
            .concat(),
        );
        serde_json::from_str(&ran.stdout).unwrap()
    };
    assert_eq!(json(&[])["rhs"], "folder");
    assert_eq!(
        (
            json(&[])["iterations"].as_u64(),
            json(&[])["relative_residual"].as_f64()
        ),
        (Some(0), Some(0.0))
    );
    assert_eq!(json(&["--rhs", "ones"])["rhs"], "ones");
    assert_eq!(json(&["--rhs", "sin"])["rhs"], "sin(i)");
}

#[test]
fn not_converging_is_status_3_with_a_report() {
    let folder = system_folder("limit");
    let ran = fracas(&[
        "solve",
        "--system",
        folder.to_str().unwrap(),
        "--max-iterations",
        "0",
        "--json",
        "-",
    ]);
    assert_eq!(ran.status, 3);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["outcome"], "iteration_limit");
    assert!(report["C_s"].is_null() && report["relative_residual"].as_f64() == Some(1.0));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let folder = system_folder("threads");
    let solution = |threads: &str| {
        let file = folder.join(format!("x{threads}.mtx"));
        let ran = fracas(&[
            "--threads",
            threads,
            "solve",
            "--system",
            folder.to_str().unwrap(),
            "--solution",
            file.to_str().unwrap(),
        ]);
        assert_eq!(ran.status, 0);
        std::fs::read(file).unwrap()
    };
    assert_eq!(solution("1"), solution("2"));
}

#[test]
fn settings_of_runs_in_a_scene_are_said_to_be_of_no_use_here() {
    let said = |scene: &str| {
        let ran = fracas(&["solve", scene]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        ran.stdout
            .contains("settings: [solver] of the scene is for `run`")
    };
    assert!(said("inclined_crack"));
    assert!(!said("cycle"));
}
