//! Files that Gmsh itself wrote.

use crate::scenes::{assert_same, folder};
use fracas::scene::{Body, Scene};
use std::path::Path;

const SCENE: &str = r#"title = "Two crossing faults from Gmsh"

[mesh]
file = "FILE"
unit = "10 m"

[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25

[[material]]
name = "layer"
volume = "soft layer"
young = "2 GPa"
poisson = 0.3

[[fracture]]
name = "fault"
surface = "fault"

[[fracture]]
name = "crossing"
surface = "crossing upper"

[[boundary]]
surface = ["bottom", 7]
hold = "fixed"

[[boundary]]
surface = "top"
pressure = "10 MPa"
"#;

fn read(file: &str) -> Body {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/gmsh");
    let text = SCENE.replace("FILE", file);
    let name = data.join("scene.toml").display().to_string();
    Scene::from_toml(&text, &name).unwrap().build().unwrap()
}

#[test]
fn the_four_forms_of_a_mesh_are_one_body() {
    let body = read("crossing_22_ascii.msh");
    // 7 x 4 x 7 nodes; 9 lines of nodes across y with one more copy, but three more where the faults cross
    assert_eq!(body.mesh.nodes.len(), 196 + 4 * (3 + 3 + 3));
    assert_eq!(body.mesh.elements.len(), 6 * 3 * 6);
    let layer = body.mesh.regions.iter().filter(|r| **r == 1).count();
    assert_eq!(layer, 6 * 3 * 2);
    let [fault, crossing] = [0, 1].map(|fracture| {
        let faces = body.fractures.faces.iter();
        let faces: Vec<_> = faces.filter(|f| f.fracture == fracture).collect();
        let area: f64 = faces.iter().map(|f| f.area).sum();
        (faces.len(), area, faces[0].frame[0])
    });
    assert_eq!((fault.0, crossing.0), (12, 12));
    // 3 by 2 and 2 by 2 units of 10 m
    assert!((fault.1 - 600.0).abs() < 1e-9 && (crossing.1 - 400.0).abs() < 1e-9);
    for (n, axis) in [(fault.2, 0), (crossing.2, 2)] {
        (0..3).for_each(|d| assert!((n[d] - f64::from(u8::from(d == axis))).abs() < 1e-12));
    }
    for face in &body.fractures.faces {
        // the minus side lies behind the normal
        for (side, sign) in [(face.minus, -1.0), (face.plus, 1.0)] {
            let corners = body.mesh.elements[side.element as usize];
            let corners = corners.map(|n| body.mesh.nodes[n as usize]);
            let mean = [0, 1, 2].map(|d: usize| corners.iter().map(|x| x[d]).sum::<f64>() / 8.0);
            let ahead: f64 = (0..3)
                .map(|d| face.frame[0][d] * (mean[d] - face.center[d]))
                .sum();
            assert!(sign * ahead > 0.0);
        }
    }
    assert_eq!(
        body.tractions.iter().map(|t| t.faces.len()).sum::<usize>(),
        18
    );
    for other in [
        "crossing_22_binary.msh",
        "crossing_41_ascii.msh",
        "crossing_41_binary.msh",
    ] {
        assert_same(&body, &read(other));
    }
    // the corner between the faults is a body of its own
    let audit = body.audit();
    assert_eq!(audit.bodies.len(), 2);
    assert_eq!(audit.fractures[0].junction_edges, 3);
}

#[test]
fn a_path_starts_at_the_folder_of_the_scene_and_sets_reach_the_names() {
    let here = folder("paths");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/gmsh");
    std::fs::create_dir_all(here.join("meshes")).unwrap();
    std::fs::copy(
        data.join("crossing_41_binary.msh"),
        here.join("meshes/m.msh"),
    )
    .unwrap();
    let path = here.join("scene.toml");
    std::fs::write(&path, SCENE.replace("FILE", "meshes/m.msh")).unwrap();
    let scene = Scene::load(&path).unwrap();
    assert_same(&scene.build().unwrap(), &read("crossing_22_ascii.msh"));
    // what is written reads back from anywhere
    let elsewhere = Scene::from_toml(&scene.to_toml().unwrap(), "/nowhere/s.toml").unwrap();
    assert_same(&scene.build().unwrap(), &elsewhere.build().unwrap());
    let one = scene
        .with_overrides(&[
            "fracture.crossing.surface=fault",
            "fracture.fault.surface=4",
        ])
        .unwrap();
    let body = one.build().unwrap();
    assert!((body.fractures.faces[0].frame[0][2] - 1.0).abs() < 1e-12);
    let flipped = scene.with_overrides(&["fracture.fault.flip=true"]).unwrap();
    let n = flipped.build().unwrap().fractures.faces[0].frame[0];
    assert!((n[0] + 1.0).abs() < 1e-12, "{n:?}");
    // both surfaces in one fracture: the crossing line has four faces of it, and no edge of H
    let text = SCENE.replace("FILE", "meshes/m.msh");
    let text = text.replace(
        "\n[[fracture]]\nname = \"crossing\"\nsurface = \"crossing upper\"\n",
        "",
    );
    let text = text.replace(
        "surface = \"fault\"",
        "surface = [\"fault\", \"crossing upper\"]",
    );
    std::fs::write(&path, text).unwrap();
    let body = Scene::load(&path).unwrap().build().unwrap();
    assert_eq!(body.fractures.faces.len(), 24);
    assert_eq!(body.fractures.names, ["fault"]);
    assert_eq!(body.mesh.nodes.len(), 232);
}
