//! Claim: what one asks every day is answered: a scene to begin with, the residuals of a solve, where a report came from, what a
//! body is made of, what the shell and `man` should know, and whatever the program chose by itself.

use crate::run::{fracas, scratch};
use fracas::scene::{Scene, gallery};
use serde_json::Value;

#[test]
fn scene_prints_a_file_that_reads_back_as_the_scene() {
    for known in gallery() {
        let ran = fracas(&["scene", known.name]);
        assert_eq!((ran.status, ran.stdout.as_str()), (0, known.toml));
        let read = Scene::from_toml(&ran.stdout, "own.toml").unwrap();
        assert_eq!(read.title(), known.scene().unwrap().title());
    }
    let ran = fracas(&["scene", "crosing"]);
    assert_eq!(ran.status, 2);
    assert!(
        ran.stderr.contains("did you mean `crossing`?"),
        "{}",
        ran.stderr
    );
}

const SMALL: [&str; 6] = [
    "--set",
    "mesh.x.cells=8",
    "--set",
    "mesh.y.cells=4",
    "--set",
    "mesh.z.cells=8",
];

#[test]
fn a_report_says_where_it_came_from_and_lines_come_beside_it() {
    let folder = scratch("everyday-report");
    for command in ["solve", "spectrum"] {
        let file = folder.join(format!("{command}.json"));
        let json = file.to_str().unwrap();
        let ran = fracas(&[&[command, "crossing", "--json", json][..], &SMALL].concat());
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        assert!(ran.stdout.starts_with("outcome") || ran.stdout.starts_with("method"));
        let report: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        assert_eq!(report["scene"], "crossing");
        assert!(report["system"].is_null());
        assert_eq!(report["overrides"].as_array().unwrap().len(), 3);
        assert_eq!(report["version"], env!("CARGO_PKG_VERSION"));
        assert!(report["features"].is_array() && report["instructions"].is_string());
        let piped = fracas(&[&[command, "crossing", "--json", "-"][..], &SMALL].concat());
        assert!(
            serde_json::from_str::<Value>(&piped.stdout).is_ok(),
            "{}",
            piped.stdout
        );
    }
}

#[test]
fn the_history_has_a_row_for_every_iteration() {
    let file = scratch("everyday-history").join("residuals.csv");
    let ran = fracas(
        &[
            &[
                "solve",
                "crossing",
                "--inner",
                "amg",
                "--measure",
                "residual",
                "--json",
                "-",
            ][..],
            &["--history", file.to_str().unwrap()],
            &SMALL,
        ]
        .concat(),
    );
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    let csv = std::fs::read_to_string(&file).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("iteration,residual"));
    let rows: Vec<(u64, f64)> = lines
        .map(|line| {
            let (iteration, residual) = line.split_once(',').unwrap();
            (iteration.parse().unwrap(), residual.parse().unwrap())
        })
        .collect();
    let iterations = report["iterations"].as_u64().unwrap();
    assert_eq!(rows.first(), Some(&(0, 1.0)));
    assert!(rows.iter().map(|r| r.0).eq(0..=iterations), "{csv}");
    assert!(rows.last().unwrap().1 <= 1e-8);
}

#[test]
fn what_the_program_chooses_is_said() {
    let few = fracas(&[&["solve", "crossing"][..], &SMALL].concat());
    assert!(
        few.stdout.contains("inner: exact, because about"),
        "{}",
        few.stdout
    );
    let many = fracas(&["solve", "crossing"]);
    assert!(
        many.stdout.contains("inner: geometric, because"),
        "{}",
        many.stdout
    );
    let asked = fracas(&[&["solve", "crossing", "--inner", "exact"][..], &SMALL].concat());
    assert!(!asked.stdout.contains("because"), "{}", asked.stdout);
    let flexible = ["solve", "crossing", "--inner", "amg", "--krylov", "gmres"];
    let flexible = fracas(&[&flexible[..], &SMALL].concat());
    let sentence = "krylov: fgmres:100 in place of gmres:100, because M⁻¹ with amg";
    assert!(flexible.stdout.contains(sentence), "{}", flexible.stdout);
}

#[test]
fn check_tells_what_a_body_is_made_of_and_what_loads_it() {
    let ran = fracas(&["check", "cycle"]);
    // a box of 8 × 20 × 20 m
    for sentence in ["3200.000000 m^3, E = ", "held        ", "moved       "] {
        assert!(ran.stdout.contains(sentence), "{sentence}: {}", ran.stdout);
    }
}

#[test]
fn shells_and_man_know_every_command() {
    let bash = fracas(&["completions", "bash"]);
    assert!(bash.status == 0 && bash.stdout.contains("--augmentation"));
    let folder = scratch("everyday-manual");
    let ran = fracas(&["manual", "--out", folder.to_str().unwrap()]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    for command in ["solve", "spectrum", "run", "check", "scene"] {
        let page = std::fs::read_to_string(folder.join(format!("fracas-{command}.1"))).unwrap();
        assert!(page.contains(".TH"), "{command}");
    }
    let version = fracas(&["--version"]);
    assert!(
        version.stdout.contains("instructions"),
        "{}",
        version.stdout
    );
}
