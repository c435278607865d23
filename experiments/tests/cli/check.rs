//! Claim: `check` says what is singular, why and where, and exports say what their tractions mean.

use crate::run::{fracas, scratch, write};
use fracas_operators::Dense;
use fracas_operators::matrix_market::{read_dense, read_sparse};

/// Two layers of elements on both sides of a fracture through x = 1 m, without boundary conditions.
const BASE: &str = r#"
title = "two slabs"
[mesh]
x = { from = "0 m", to = "2 m", cells = 2 }
y = { from = "0 m", to = "3 m", cells = 3 }
z = { from = "0 m", to = "3 m", cells = 3 }
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "joint"
plane = "x"
at = "1 m"
"#;

/// BASE with holds on sides and keys replaced.
fn scene(name: &str, holds: &[(&str, &str)], replaced: &[(&str, &str)]) -> String {
    let mut text = BASE.to_owned();
    for (old, new) in replaced {
        assert!(text.contains(old), "{old}");
        text = text.replace(old, new);
    }
    for (side, hold) in holds {
        text += &format!("[[boundary]]\nside = \"{side}\"\nhold = \"{hold}\"\n");
    }
    let file = scratch(&format!("check-{name}")).join("scene.toml");
    write(&file, &text);
    file.display().to_string()
}

fn said(file: &str, status: i32, sentences: &[&str]) {
    let ran = fracas(&["check", file]);
    let text = ran.stdout + &ran.stderr;
    assert_eq!(ran.status, status, "{text}");
    for sentence in sentences {
        assert!(text.contains(sentence), "`{sentence}` is not in\n{text}");
    }
}

#[test]
fn bodies_that_nothing_holds_are_bad_input() {
    said(
        &scene("free", &[], &[]),
        2,
        &[
            "error: body 0 (9 elements around (0.500000, 1.500000, 1.500000) m) is not held",
            "6 rigid motions are free, nothing is prescribed along x, y, z",
        ],
    );
    said(
        &scene("roller", &[("z-", "roller")], &[]),
        2,
        &["3 rigid motions are free, nothing is prescribed along x, y"],
    );
}

#[test]
fn fractures_outside_are_bad_input() {
    for (at, sentence) in [
        ("3 m", "leaves the box: x = 3 m is outside [0 m, 2 m]"),
        ("2 m", "lies on the boundary x = 2 m"),
        (
            "0.7 m",
            "x = 0.7 m is not a grid line; the nearest are 0 m and 1 m",
        ),
    ] {
        let file = scene(at, &[("x-", "fixed")], &[("\"1 m\"", &format!("{at:?}"))]);
        said(&file, 2, &["scene.toml:14:6: fracture \"joint\"", sentence]);
    }
}

#[test]
fn a_slab_of_one_element_between_rollers_is_told_and_goes_on() {
    let holds = [("x-", "fixed"), ("y-", "roller"), ("y+", "roller")];
    let file = scene(
        "slab",
        &holds,
        &[
            (
                "to = \"3 m\", cells = 3 }\nz",
                "to = \"1 m\", cells = 1 }\nz",
            ),
            (
                "at = \"1 m\"",
                "at = \"1 m\"\n[[boundary]]\nside = \"x+\"\ntraction = { x = \"-1 MPa\" }",
            ),
        ],
    );
    said(
        &file,
        0,
        &[
            "rank        dim ker B = 3\n",
            "1 traction mode pushes on prescribed displacements or tips only and keeps the initial stress",
            "\"joint\" on 3 faces, first face 0 at (1.000000, 0.500000, 0.500000) m: t_1 acts on prescribed displacements only",
            "a uniform traction along y on this patch does no work",
        ],
    );
    let file = file.as_str();
    let solved = fracas(&["solve", file]);
    assert_eq!(solved.status, 0, "{}", solved.stderr);
    let said = "warning: 1 traction mode(s) push on";
    assert!(solved.stderr.contains(said), "{}", solved.stderr);
    // what has to factorize the Schur complement cannot, and says where
    let refused = fracas(&["solve", file, "--method", "mcp"]);
    assert_eq!(refused.status, 2, "{}", refused.stderr);
    assert!(
        refused.stderr.contains("(row 8, counted from 1)"),
        "{}",
        refused.stderr
    );
    for method in ["direct", "mcp"] {
        let refused = fracas(&["solve", file, "--method", method]);
        assert_eq!(refused.status, 2, "{method}: {}", refused.stderr);
        let last = refused.stderr.lines().last().unwrap();
        assert!(
            last.starts_with("error: ")
                && last.contains("1 traction mode(s) push on prescribed displacements")
                && !last.contains("unconstrained bodies"),
            "{method}: {last}"
        );
    }
    let out = scratch("slab-run");
    let out = out.join("out");
    let ran = fracas(&[
        "run",
        file,
        "--set",
        "fracture.0.friction_angle=30 deg",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert!(
        ran.stderr.contains("warning: 1 traction mode(s) push on"),
        "{}",
        ran.stderr
    );
    let log = std::fs::read_to_string(out.join("log.jsonl")).unwrap();
    assert!(log.contains("\"event\":\"warning\""), "{log}");
}

#[test]
fn a_fracture_of_one_face_is_told() {
    let spans = "at = \"1 m\"\ny = [\"1 m\", \"2 m\"]\nz = [\"1 m\", \"2 m\"]";
    said(
        &scene("face", &[("x-", "fixed")], &[("at = \"1 m\"", spans)]),
        0,
        &[
            "3 traction modes push on prescribed displacements or tips only",
            "\"joint\" on 1 face, first face 0 at (1.000000, 1.500000, 1.500000) m: all four corners are tips",
        ],
    );
}

#[test]
fn a_fracture_that_needs_stabilization_says_so() {
    let holds = ["x-", "x+", "y-", "y+", "z-", "z+"].map(|side| (side, "roller"));
    said(
        &scene("rollers", &holds, &[]),
        0,
        &[
            "singular without stabilization, regular with it",
            "this patch has 9 tractions along y but 8 free jumps: stabilization is needed",
        ],
    );
}

/// Column 3f + k of B1 holds ±frame_k[c] ∫N_a, so its entries along c sum in size to 2 · area · |frame_k[c]|.
#[test]
fn exported_frames_are_those_of_the_coupling() {
    let map = "[mesh.map.rotate]\naxis = \"y\"\nangle = \"20 deg\"\n[[material]]";
    let file = scene("frames", &[("x-", "fixed")], &[("[[material]]", map)]);
    let out = scratch("check-export");
    let ran = fracas(&["export", &file, "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let faces: Dense<f64> = read_dense(&out.join("faces.mtx")).unwrap();
    let coords: Dense<f64> = read_dense(&out.join("coords.mtx")).unwrap();
    let b = read_sparse(&out.join("B1.mtx")).unwrap().matrix;
    let n_t = b.cols();
    assert_eq!(faces.column(0), vec![0.0; n_t / 3]);
    let mut sums = vec![[0.0; 3]; n_t];
    let mut moments = vec![[0.0; 3]; n_t];
    for (value, (row, column)) in b.iter() {
        let (row, column) = (row as usize, column as usize);
        sums[column][coords.entry(row, 3) as usize] += value.abs();
        for d in 0..3 {
            moments[column][d] += value.abs() * coords.entry(row, d);
        }
    }
    for (column, sum) in sums.iter().enumerate() {
        let (f, k) = (column / 3, column % 3);
        let total: f64 = sum.iter().sum();
        for d in 0..3 {
            let frame = faces.entry(f, 5 + 3 * k + d);
            let area = faces.entry(f, 4);
            assert!(
                (sum[d] - 2.0 * area * frame.abs()).abs() < 1e-12,
                "{column} {d}"
            );
            let center = moments[column][d] / total;
            assert!(
                (center - faces.entry(f, 1 + d)).abs() < 1e-12,
                "{column} {d}"
            );
        }
    }
    let manifest = std::fs::read_to_string(out.join("manifest.json")).unwrap();
    for line in ["\"step\": 0,", "\"newton\": 0,", "\"units\": \"SI\","] {
        assert!(manifest.contains(line), "{manifest}");
    }
    let audit = fracas(&["check", "--system", out.to_str().unwrap()]);
    assert!(!audit.stdout.contains("faces.mtx"), "{}", audit.stdout);
}

#[test]
fn a_newton_step_of_a_run_is_exported_and_solves() {
    let out = scratch("export-newton");
    let out = out.to_str().unwrap();
    let small = [
        "--set",
        "mesh.x.cells=4",
        "--set",
        "mesh.y.cells=2",
        "--set",
        "mesh.z.cells=2",
    ];
    let export = |step: &str, newton: &str| {
        let mut arguments = vec![
            "export", "cycle", "--out", out, "--step", step, "--newton", newton,
        ];
        arguments.extend(small);
        fracas(&arguments)
    };
    let ran = export("8", "1");
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let manifest = std::fs::read_to_string(format!("{out}/manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(
        (&manifest["step"], &manifest["newton"]),
        (&8.into(), &1.into())
    );
    let states = manifest["states"].as_array().unwrap();
    assert_eq!(states.len(), 4, "{manifest}");
    assert!(
        states.iter().any(|s| *s != 0),
        "all faces stick: {manifest}"
    );
    assert!(std::path::Path::new(&format!("{out}/B2.mtx")).is_file());
    let solved = fracas(&["solve", "--system", out]);
    assert_eq!(solved.status, 0, "{}", solved.stderr);
    let late = export("99", "0");
    assert_eq!(late.status, 2);
    assert!(late.stderr.contains("steps 0 to 40"), "{}", late.stderr);
    let many = export("8", "500");
    assert_eq!(many.status, 2);
    assert!(many.stderr.contains("no number 500"), "{}", many.stderr);
    let alone = fracas(&["export", "cycle", "--out", out, "--newton", "1"]);
    assert_eq!(alone.status, 2);
}

#[test]
fn remarks_on_friction_are_those_of_a_run() {
    let with = |dynamic: &str| {
        let angle = format!("fracture.0.dynamic_friction_angle={dynamic}");
        fracas(&[
            "check",
            "cycle",
            "--set",
            "fracture.0.weakening_distance=5 mm",
            "--set",
            "initial_stress.constant.xx=-10 MPa",
            "--set",
            &angle,
        ])
    };
    for (dynamic, sentence) in [
        ("35 deg", "strengthens with slip"),
        ("10 deg", "weakens: slip runs away beyond a half-length of"),
    ] {
        let ran = with(dynamic);
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        let told = ran
            .stdout
            .lines()
            .any(|line| line.starts_with("warning     fracture ") && line.contains(sentence));
        assert!(told, "{dynamic}: {}", ran.stdout);
    }
    let quiet = with("29.9 deg");
    assert!(!quiet.stdout.contains("warning"), "{}", quiet.stdout);
    let line = "\": 30 deg, down to 29.9 deg over 0.005 m of slip\n";
    assert!(quiet.stdout.contains(line), "{}", quiet.stdout);
}

#[test]
fn friction_of_a_profile_is_told_with_its_ends_on_the_faces() {
    // centres of the faces lie between 1 m and 19 m
    let profile =
        "fracture.0.profile=[{z=\"0 m\",cohesion=\"0 MPa\"},{z=\"20 m\",cohesion=\"2 MPa\"}]";
    let ran = fracas(&["check", "cycle", "--set", profile]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let told = ran.stdout.contains("\": 30 deg, cohesion 0.1 to 1.9 MPa\n");
    assert!(told, "{}", ran.stdout);
}

#[test]
fn what_is_refused_leaves_no_folder() {
    let base = scratch("refused");
    let out = base.join("deep/er");
    let path = out.to_str().unwrap();
    let springs = "solver.method={ penalty = { factor = 100 } }";
    for (arguments, sentence) in [
        (
            &["export", "cycle", "--step", "10", "--set", springs][..],
            "has no saddle point",
        ),
        (&["export", "crosing"], "did you mean `crossing`?"),
        (
            &["run", &scene("refused-run", &[("x-", "fixed")], &[])],
            "has neither friction_angle nor cohesion",
        ),
    ] {
        let ran = fracas(&[arguments, &["--out", path]].concat());
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.stderr);
        assert!(
            ran.stderr.contains(sentence) && !ran.stderr.contains("step 0"),
            "{arguments:?}: {}",
            ran.stderr
        );
        assert!(!base.join("deep").exists(), "{arguments:?}");
    }
}

#[test]
fn an_export_stays_out_of_the_folder_of_a_run() {
    let out = scratch("export-into-run");
    write(&out.join("history.csv"), "step\n");
    let ran = fracas(&["export", "patch", "--out", out.to_str().unwrap()]);
    assert_eq!(ran.status, 2);
    assert!(ran.stderr.contains("holds a run"), "{}", ran.stderr);
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
}
