//! Claim: `fracas solve --explain` says what hinders a solve, and nothing where nothing does.
#![allow(clippy::unwrap_used, reason = "a test that cannot read a report fails")]

use crate::run::{fracas, scratch, system_folder};
use fracas_operators::matrix_market::{read_dense, write_dense};
use fracas_operators::{Dense, LinearOperator};
use serde_json::Value;

fn explained(arguments: &[&str]) -> Value {
    let ran = fracas(&[&["solve"], arguments, &["--explain", "--json", "-"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    report["explain"].clone()
}

#[test]
fn a_scene_is_explained_and_h_is_advised_where_it_exceeds_c() {
    let facts = explained(&["patch", "--augmentation", "local_h"]);
    assert_eq!(facts["c_over_h"]["share_below"], 0.0);
    assert!(facts["c_over_h"]["min"].as_f64().unwrap() >= 1.0);
    assert!(facts["rigid_body"]["free_rows"].as_u64().unwrap() > 0);
    assert_eq!(facts["rigid_body"]["wrong_rows"], 0);
    assert!(facts["rigid_body"]["worst"].as_f64().unwrap() < 1e-10);
    assert!(facts["seen"]["kappa"].as_f64().unwrap() >= 1.0);
    assert!(facts["time"]["inner_s"].as_f64().unwrap() > 0.0);
    let small = ["patch", "--augmentation", "global_times=1e-6", "--method"];
    for (method, rule) in [("racp", "fitted_h"), ("racp:0", "local_h")] {
        let advice = explained(&[&small[..], &[method]].concat())["advice"].clone();
        assert!(advice.as_str().unwrap().contains(rule), "{advice}");
    }
    let ours = explained(&["patch"]);
    // H ≤ 2 blkdiag H, and degree four reaches λ_max(C⁻¹H) = 34.64…
    let asked = ours["c_over_h"]["asked"].as_f64().unwrap();
    assert!(
        (asked - 2.0 / 34.642_953_161_428_54).abs() < 1e-15,
        "{asked}"
    );
    assert_eq!(ours["c_over_h"]["share_below"], 0.0);
}

#[test]
fn geometric_multigrid_is_explained_by_its_own_eigenvalues() {
    let scene = ["crossing:small", "--inner", "geometric"];
    let facts = explained(&scene);
    assert!(facts["amg_levels"].as_u64().unwrap() >= 2);
    assert!(facts["rigid_body"]["free_rows"].as_u64().unwrap() > 0);
    let ran = fracas(&[&["spectrum"], &scene[..], &["--json", "-"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    for (seen, found) in [("modulus_min", "real_min"), ("modulus_max", "real_max")] {
        let [seen, found] = [&facts["seen"][seen], &report[found]].map(|v| v.as_f64().unwrap());
        assert!((seen / found - 1.0).abs() < 0.02, "{seen} {found}");
    }
    let huge = ["mesh.x.cells=400", "mesh.y.cells=400", "mesh.z.cells=400"];
    let sets = huge.iter().flat_map(|set| ["--set", set]);
    let start = ["solve", "crossing", "--inner", "geometric", "--explain"];
    let ran = fracas(&start.into_iter().chain(sets).collect::<Vec<_>>());
    assert_eq!(ran.status, 2, "{}", ran.stderr);
    assert!(
        ran.stderr.contains("ask for no explanation"),
        "{}",
        ran.stderr
    );
}

#[test]
fn a_folder_of_another_code_without_coordinates_is_explained_as_far_as_it_can_be() {
    let folder = system_folder("explain");
    let system = folder.to_str().unwrap();
    let facts = explained(&["--system", system, "--inner", "amg"]);
    assert!(facts["rigid_body"].is_null() && facts["c_over_h"].is_null());
    assert!(facts["amg_levels"].as_u64().unwrap() >= 1);
    assert!(facts["advice"].as_str().unwrap().contains("coords.mtx"));
    let ran = fracas(&["solve", "--system", system, "--explain"]);
    assert!(ran.stdout.contains("no coordinates") && ran.stdout.contains("\nadvice "));
    let plain = fracas(&["solve", "--system", system, "--json", "-"]);
    let report: Value = serde_json::from_str(&plain.stdout).unwrap();
    assert!(report["explain"].is_null());
}

#[test]
fn coordinates_of_another_mesh_are_said() {
    let folder = scratch("explain-misfit").join("system");
    let system = folder.to_str().unwrap();
    assert_eq!(fracas(&["export", "patch", "--out", system]).status, 0);
    let file = folder.join("coords.mtx");
    let table: Dense<f64> = read_dense(&file).unwrap();
    // x three times as long
    let factor = [3.0, 1.0, 1.0, 1.0];
    let stretched = Dense::from_fn(table.shape(), |i, j| table.entry(i, j) * factor[j]);
    write_dense(&file, &stretched).unwrap();
    let advice = explained(&["--system", system])["advice"].clone();
    assert!(
        advice.as_str().unwrap().contains("do not fit A"),
        "{advice}"
    );
}
