//! Claim: a measure of a row is of that row: its own keys, right-hand side and state, whatever stood in the rows before it.
#![allow(clippy::unwrap_used)]

use crate::run::{fracas, scratch, write};
use crate::study::{column, rows};
use std::path::{Path, PathBuf};

const BLOCK: &str = r#"
title = "block"
mesh.x = { from = "0 m", to = "4 m", cells = 4 }
mesh.y = { from = "0 m", to = "4 m", cells = 4 }
mesh.z = { from = "0 m", to = "4 m", cells = 4 }
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.25
[[fracture]]
name = "f"
plane = "x"
at = "2 m"
y = ["0 m", "2 m"]
friction_angle = "30 deg"
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
traction = { x = "1 MPa", z = "-3 MPa" }
"#;

/// A folder with a scene `block.toml` and a study beside it.
fn study_of_block(name: &str, study: &str) -> (PathBuf, String) {
    let folder = scratch(name);
    write(&folder.join("block.toml"), BLOCK);
    let file = folder.join("study.toml");
    write(&file, &format!("title = 't'\nquestion = 'q'\n{study}"));
    (folder, file.to_str().unwrap().to_owned())
}

fn ran(name: &str, study: &str) -> Vec<Vec<String>> {
    let (folder, file) = study_of_block(name, study);
    let out = folder.join("out");
    let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
    assert!([0, 4].contains(&ran.status), "{}", ran.stderr);
    rows(&out)
}

fn numbers(rows: &[Vec<String>], name: &str) -> Vec<f64> {
    let fields = column(rows, name);
    fields.iter().map(|field| field.parse().unwrap()).collect()
}

const FINEST: &str = r#"
counts = "published"
tolerance_of = "residual"
measures = ["mesh_error"]
[finest]
set = { "mesh.x.cells" = 8, "mesh.y.cells" = 8, "mesh.z.cells" = 8 }
tolerance = 1e-10
[axes]
scene = ["block.toml"]
"#;

#[test]
fn the_finest_mesh_has_the_keys_of_the_row() {
    // displacements go with 1/E, so that errors relative to them stay
    let set = r#"set = { "material.0.young" = ["10 GPa", "20 GPa"], "material.0.poisson" = [0.25, 0.45] }"#;
    let both = numbers(
        &ran("study-finest", &format!("{FINEST}{set}")),
        "mesh_error",
    );
    let alone = r#"set = { "material.0.poisson" = [0.45] }"#;
    let alone = numbers(
        &ran("study-finest-alone", &format!("{FINEST}{alone}")),
        "mesh_error",
    );
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-6 * b;
    assert!(same(both[0], both[1]) && same(both[2], both[3]), "{both:?}");
    assert!(same(both[2], alone[0]), "{both:?} beside {alone:?}");
    assert!(both[2] > 1.5 * both[0], "{both:?}");
    // a mesh that is refined is not finer than the finest one
    let refined = numbers(
        &ran("study-finest-refined", &format!("{FINEST}refine = [1, 2]")),
        "mesh_error",
    );
    assert!(
        same(refined[0], both[0]) && refined[1] < 1e-6,
        "{refined:?}"
    );
}

#[test]
fn errors_are_of_the_equations_of_the_row() {
    let axes = r#"
counts = "published"
tolerance_of = "residual"
measures = ["algebraic_u", "algebraic_t"]
[axes]
scene = ["block.toml"]
tolerance = [1e-10]
"#;
    for of in [
        r#"rhs = ["system", "sin", "ones"]"#,
        r#"state = ["stick", "slip:0.5", "open:0.5"]"#,
    ] {
        let rows = ran("study-algebraic", &format!("{axes}{of}"));
        for name in ["algebraic_u", "algebraic_t"] {
            let errors = numbers(&rows, name);
            assert!(
                errors.iter().all(|e| *e > 0.0 && *e < 1e-8),
                "{of}: {errors:?}"
            );
        }
    }
    let other = ran("study-finest-rhs", &format!("{FINEST}rhs = [\"sin\"]"));
    assert_eq!(column(&other, "mesh_error"), [""]);
    let why = &column(&other, "reason")[0];
    assert!(why.contains("under its own loads"), "{why}");
}

#[test]
fn reference_errors_count_prescribed_displacements() {
    // the body is moved and little strained: relative to what moves it, errors would be a thousand times too small
    let moved = BLOCK.replace(
        "hold = \"fixed\"",
        "displacement = { x = \"1 m\", y = \"0 m\", z = \"0 m\" }",
    );
    let error = |reference: bool| {
        let (folder, file) = study_of_block(
            "study-moved",
            &format!(
                "reference = {reference}\nmeasures = ['error_u']\n[axes]\nscene = ['block.toml']\ntolerance = [1e-3]\n"
            ),
        );
        write(&folder.join("block.toml"), &moved);
        let out = folder.join("out");
        let ran = fracas(&["study", &file, "--out", out.to_str().unwrap()]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        numbers(&rows(&out), "error_u")[0]
    };
    let (estimate, true_error) = (error(false), error(true));
    let ratio = estimate / true_error;
    assert!(
        (0.3..10.0).contains(&ratio),
        "{estimate} estimated, {true_error} true"
    );
}

#[test]
fn parts_measure_what_they_ask_for() {
    let part = |name: &str, measure: &str| {
        format!("[[axes]]\npart = '{name}'\nscene = ['block.toml']\nmeasures = ['{measure}']\n")
    };
    let rows = ran(
        "study-parts",
        &[part("a", "cond_S_u"), part("b", "cond_S_u_scaled")].concat(),
    );
    let empty = |name: &str| {
        column(&rows, name)
            .iter()
            .map(String::is_empty)
            .collect::<Vec<_>>()
    };
    assert_eq!(empty("cond_S_u"), [false, true]);
    assert_eq!(empty("cond_S_u_scaled"), [true, false]);
}

#[test]
fn the_quality_of_both_approximations_is_what_spectrum_prints() {
    let study = r#"
measures = ["delta_min", "delta_max", "eta"]
[axes]
scene = ["block.toml"]
inner = ["exact", "ssor", "amg"]
"#;
    let rows = ran("study-quality", study);
    let found = ["delta_min", "delta_max", "eta"].map(|name| numbers(&rows, name));
    assert!(found[0][1] < found[1][1] && found[2][1] > 0.0, "{found:?}");
    let (folder, _) = study_of_block("study-quality-beside", study);
    let scene = folder.join("block.toml");
    for (k, inner) in ["exact", "ssor", "amg"].iter().enumerate() {
        let scene = scene.to_str().unwrap();
        let ran = fracas(&["spectrum", scene, "--inner", inner, "--json", "-"]);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        let report: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        for (of, key) in found.iter().zip(["delta", "Delta", "eta"]) {
            let printed = report[key].as_f64().unwrap();
            assert!((of[k] - printed).abs() <= 1e-12 * printed, "{inner} {key}");
        }
    }
}

#[test]
fn nothing_is_outside_or_inside_where_nothing_is_proved() {
    let study = r#"
measures = ["outside", "outside_printed", "contained"]
[axes]
scene = ["block.toml"]
method = ["racp", "simple"]
[[check]]
claim = "inside"
of = "outside"
max = 0
"#;
    let rows = ran("study-outside", study);
    assert_eq!(column(&rows, "contained"), ["yes", ""]);
    assert_eq!(column(&rows, "outside"), ["0", ""]);
    assert_eq!(column(&rows, "outside_printed")[1], "");
}

#[test]
fn rows_of_a_scene_that_has_changed_are_not_gone_on_with() {
    let study = "[axes]\nscene = ['block.toml']\ntolerance = [1e-4, 1e-8]\n";
    let (folder, file) = study_of_block("study-edited", study);
    let out = folder.join("out");
    let arguments = ["study", &file, "--out", out.to_str().unwrap()];
    assert_eq!(fracas(&arguments).status, 0);
    let whole = std::fs::read_to_string(out.join("rows.csv")).unwrap();
    // as if the process had been killed after the first row
    let first: String = whole
        .lines()
        .take(2)
        .map(|line| format!("{line}\n"))
        .collect();
    let cut = |scene: &str| {
        write(&out.join("rows.csv"), &first);
        write(&folder.join("block.toml"), scene);
        fracas(&arguments)
    };
    let other = cut(&BLOCK.replace("10 GPa", "11 GPa"));
    assert_eq!(other.status, 2);
    let sentence = "block.toml has changed since rows of";
    assert!(other.stderr.contains(sentence), "{}", other.stderr);
    assert_eq!(
        std::fs::read_to_string(out.join("rows.csv")).unwrap(),
        first
    );
    let commented = cut(&format!("# a note\n{BLOCK}"));
    assert_eq!(commented.status, 0, "{}", commented.stderr);
    assert_eq!(rows(&out).len(), 3);
}

#[test]
fn scenes_of_one_file_name_have_curves_of_their_own() {
    let folder = scratch("study-names");
    for (name, cells) in [("a", 4), ("b", 6)] {
        std::fs::create_dir(folder.join(name)).unwrap();
        let scene = BLOCK.replace("cells = 4", &format!("cells = {cells}"));
        write(&folder.join(name).join("s.toml"), &scene);
    }
    let file = folder.join("study.toml");
    let study = "title = 't'\nquestion = 'q'\nmeasures = ['n_it']\n[axes]\nscene = ['a/s.toml', 'b/s.toml']\ntolerance = [1e-4, 1e-8]\n[[figure]]\nid = 'one'\nx = 'tolerance'\ny = 'n_it'\nlog_x = true\n[[figure]]\nid = 'bars'\nx = 'scene'\ny = 'n_it'\n";
    write(&file, study);
    let out = folder.join("out");
    let ran = fracas(&[
        "study",
        file.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let figure = |name: &str| std::fs::read_to_string(out.join("figures").join(Path::new(name)));
    let curves = figure("one.csv").unwrap();
    assert!(
        curves.contains("\na/s,") && curves.contains("\nb/s,"),
        "{curves}"
    );
    let bars = figure("bars.svg").unwrap();
    assert!(bars.contains("a/s") && bars.contains("b/s"));
}
