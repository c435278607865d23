//! Claim: scenes come by name or by file, with values replaced, and what is wrong with them is said with its line.

use crate::run::{fracas, scratch, write};
use serde_json::Value;

const SMALL: [&str; 6] = [
    "--set",
    "mesh.x.cells=8",
    "--set",
    "mesh.y.cells=2",
    "--set",
    "mesh.z.cells=8",
];

fn json(arguments: &[&str]) -> (i32, Value) {
    let ran = fracas(&[arguments, &["--json", "-"]].concat());
    (
        ran.status,
        serde_json::from_str(&ran.stdout).unwrap_or_else(|e| panic!("{e}: {}", ran.stderr)),
    )
}

#[test]
fn every_scene_of_the_gallery_is_listed() {
    let ran = fracas(&["list"]);
    assert_eq!(ran.status, 0);
    for scene in fracas::scene::gallery() {
        let line = ran
            .stdout
            .lines()
            .find(|l| l.trim_start().starts_with(scene.name));
        assert!(
            line.is_some_and(|l| l.contains(scene.question) && l.contains(scene.expected)),
            "{}",
            scene.name
        );
    }
}

#[test]
fn an_exported_scene_solves_and_analyses_like_the_scene_itself() {
    let folder = scratch("export").join("deep/er");
    let out = folder.to_str().unwrap();
    let ran = fracas(&[&["export", "crossing", "--out", out][..], &SMALL].concat());
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let audit = fracas(&["check", "--system", out]);
    assert!(
        audit.status == 0 && !audit.stdout.contains("finding"),
        "{}",
        audit.stdout
    );
    for command in ["solve", "spectrum"] {
        let (status, of_scene) = json(&[&[command, "crossing"][..], &SMALL].concat());
        let (_, of_folder) = json(&[command, "--system", out]);
        assert_eq!(status, 0);
        for key in ["n_u", "n_t", "iterations", "c_min", "c_max", "n_at_one"] {
            assert_eq!(of_scene.get(key), of_folder.get(key), "{command}: {key}");
        }
    }
}

#[test]
fn spectrum_reports_its_keys_and_draws() {
    let figure = scratch("spectrum").join("spectrum.svg");
    let plot = figure.to_str().unwrap();
    let (status, report) = json(
        &[
            &["spectrum", "crossing", "--inner", "jacobi", "--plot", plot][..],
            &SMALL,
        ]
        .concat(),
    );
    assert_eq!(status, 0);
    for key in [
        "n_u",
        "n_t",
        "augmentation",
        "inner",
        "c_min",
        "c_max",
        "cond_A",
        "cond_S_u",
        "real_min",
        "real_max",
        "re_min",
        "re_max",
        "im_max",
        "n_complex",
        "n_at_one",
        "n_at_half",
        "contained",
        "delta",
        "Delta",
        "eta",
        "region",
        "certified",
        "inf_sup",
    ] {
        assert!(report.get(key).is_some(), "no key {key}");
    }
    for key in [
        "theorem",
        "alpha_u",
        "beta_u",
        "alpha_t",
        "beta_t",
        "real_low",
        "real_high",
        "re_low",
        "re_high",
        "im_max",
    ] {
        assert!(report["bounds"].get(key).is_some(), "no key bounds.{key}");
    }
    let n = report["n_u"].as_u64().unwrap() + report["n_t"].as_u64().unwrap();
    for part in ["re", "im"] {
        assert_eq!(
            report["eigenvalues"][part].as_array().unwrap().len() as u64,
            n
        );
    }
    assert!(
        std::fs::read_to_string(&figure)
            .unwrap()
            .starts_with("<svg")
    );
    let rows = std::fs::read_to_string(figure.with_extension("csv")).unwrap();
    assert!(
        rows.lines()
            .filter(|l| l.contains("eigenvalues,points,"))
            .count() as u64
            == n
    );
}

#[test]
fn check_audits_without_solving() {
    let ran = fracas(&["check", "floating"]);
    assert!(
        ran.status == 0 && ran.stdout.contains("A is singular"),
        "{}",
        ran.stdout
    );
}

#[test]
fn the_schema_is_json() {
    let schema: Value = serde_json::from_str(&fracas(&["schema"]).stdout).unwrap();
    assert!(schema["properties"].get("mesh").is_some());
}

#[test]
fn bad_scenes_are_refused_with_their_line() {
    let refused = |arguments: &[&str], parts: &[&str]| {
        let ran = fracas(arguments);
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.stderr);
        assert!(
            parts.iter().all(|p| ran.stderr.contains(p)),
            "{arguments:?}: {}",
            ran.stderr
        );
        assert!(!ran.stderr.contains("panicked") && ran.stderr.contains("error: "));
    };
    refused(&["check", "crosing"], &["did you mean `crossing`?"]);
    refused(&["check", "/no/such.toml"], &["/no/such.toml"]);
    // 4e8 nodes can be numbered; nobody has 1.7 TB for the blocks
    refused(
        &[
            "spectrum",
            "patch",
            "--set",
            "mesh.x.cells=1000",
            "--set",
            "mesh.y.cells=640",
            "--set",
            "mesh.z.cells=640",
        ],
        &["grid nodes take about", "use fewer cells"],
    );
    refused(
        &["check", "crossing", "--set", "mesh.x.cels=3"],
        &["unknown key `cels`", "did you mean `cells`"],
    );
    refused(
        &["solve", "crossing", "--stabilization", "-1"],
        &["the factor is a number ≥ 0"],
    );
    refused(&["solve", "crossing", "--augmentation", "locl"], &["locl"]);
    refused(&["solve", "crossing", "--inner", "amgg"], &["amgg"]);
    refused(
        &["spectrum", "floating", "--augmentation", "exact"],
        &["needs a positive definite A"],
    );
    let file = scratch("scene").join("bad.toml");
    write(
        &file,
        "title = \"x\"\n[mesh.x]\nfrom = \"0 m\"\nto = \"1 kg\"\ncells = 2\n",
    );
    refused(&["check", file.to_str().unwrap()], &["bad.toml:4"]);
}
