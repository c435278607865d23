//! Claim: a scene with a mesh from Gmsh goes through every command, and geometric multigrid says that it needs a grid.

#![allow(clippy::unwrap_used, reason = "a test that cannot copy its mesh fails")]

use crate::run::{fracas, scratch, write};
use serde_json::Value;
use std::path::{Path, PathBuf};

const SCENE: &str = r#"title = "Two crossing faults from Gmsh"

[mesh]
file = "m.msh"

[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25

[[fracture]]
name = "fault"
surface = "fault"

[[fracture]]
name = "crossing"
surface = "crossing upper"

[[boundary]]
surface = "bottom"
hold = "fixed"

[[boundary]]
surface = "top"
pressure = "10 MPa"
"#;

/// The scene beside a file that Gmsh wrote.
fn scene(name: &str) -> PathBuf {
    let folder = scratch(name);
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/gmsh");
    std::fs::copy(data.join("crossing_41_binary.msh"), folder.join("m.msh")).unwrap();
    write(&folder.join("scene.toml"), SCENE);
    folder
}

#[test]
fn every_command_takes_it() {
    let folder = scene("gmsh");
    let path = folder.join("scene.toml");
    let path = path.to_str().unwrap();
    let checked = fracas(&["check", path]);
    assert_eq!(checked.status, 0, "{}", checked.stderr);
    for line in [
        "mesh        108 elements, 232 nodes (36 copies on fractures)",
        "fracture    \"fault\": 12 faces, 6.000000 m^2, 4 tip nodes, 3 junction edges",
    ] {
        assert!(checked.stdout.contains(line), "{}", checked.stdout);
    }
    let out = folder.join("system");
    let exported = fracas(&["export", path, "--out", out.to_str().unwrap()]);
    assert_eq!(exported.status, 0, "{}", exported.stderr);
    let json = |arguments: &[&str]| -> Value {
        let ran = fracas(&[arguments, &["--json", "-"]].concat());
        assert_eq!(ran.status, 0, "{}", ran.stderr);
        serde_json::from_str(&ran.stdout).unwrap()
    };
    let spectrum = json(&["spectrum", path]);
    assert_eq!(spectrum["contained"], true);
    assert_eq!(spectrum["n_t"], 72);
    let solved = json(&["solve", path, "--inner", "auto"]);
    assert_eq!(solved["outcome"], "converged");
    assert_eq!(solved["inner"], "exact");
    let noted = solved["findings"].to_string();
    assert!(
        noted.contains("displacements are no more than 5000"),
        "{noted}"
    );
}

#[test]
fn what_cannot_be_is_said_in_a_sentence_with_status_two() {
    let folder = scene("gmsh-refused");
    let path = folder.join("scene.toml");
    let path = path.to_str().unwrap();
    let geometric = fracas(&["solve", path, "--inner", "geometric"]);
    assert_eq!(geometric.status, 2);
    assert!(
        geometric
            .stderr
            .contains("needs a mesh that is a grid, and the mesh of this scene comes from a file"),
        "{}",
        geometric.stderr
    );
    let inner = ["--set", "solver.inner='geometric'"];
    let friction = ["fault", "crossing"].map(|f| format!("fracture.{f}.friction_angle='30 deg'"));
    let friction = ["--set", &friction[0], "--set", &friction[1]];
    let ran = fracas(&[&["run", path], &inner[..], &friction].concat());
    assert_eq!(ran.status, 2, "{}", ran.stderr);
    assert!(
        ran.stderr.contains("the mesh has no grid"),
        "{}",
        ran.stderr
    );
    let typo = fracas(&["check", path, "--set", "fracture.fault.surface=falut"]);
    assert_eq!(typo.status, 2);
    assert!(
        typo.stderr
            .contains("has no physical surface \"falut\", did you mean \"fault\"?"),
        "{}",
        typo.stderr
    );
    let mesh = std::fs::read(folder.join("m.msh")).unwrap();
    std::fs::write(folder.join("m.msh"), &mesh[..mesh.len() / 2]).unwrap();
    for command in ["check", "solve", "spectrum"] {
        let truncated = fracas(&[command, path]);
        assert_eq!(truncated.status, 2);
        assert!(
            truncated.stderr.contains("the file is truncated"),
            "{}",
            truncated.stderr
        );
    }
}
