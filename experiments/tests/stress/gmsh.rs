//! Mutated mesh files: refused, or a body; one that only lost or gained an end is refused, or the same body.

use crate::mutation::{Change, mutate};
use crate::room::{Verdict, count, scratch, trial};
use fracas::scene::{Body, Scene};
use std::path::Path;

const SCENE: &str = r#"title = "mesh file"
[mesh]
file = "m.msh"
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "fault"
surface = "fault"
[[boundary]]
surface = "bottom"
hold = "fixed"
"#;

const FILES: [&str; 4] = [
    "crossing_22_ascii.msh",
    "crossing_22_binary.msh",
    "crossing_41_ascii.msh",
    "crossing_41_binary.msh",
];

#[test]
fn mutated_meshes_are_refused_or_bodies() {
    let folder = scratch("gmsh");
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/gmsh");
    let file = folder.join("m.msh");
    let name = folder.join("scene.toml").display().to_string();
    let body = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        Scene::from_toml(SCENE, &name).ok()?.build().ok()
    };
    let bases: Vec<(Vec<u8>, Body)> = FILES
        .iter()
        .map(|f| {
            let bytes = std::fs::read(data.join(f)).unwrap();
            let body = body(&bytes).unwrap();
            (bytes, body)
        })
        .collect();
    trial("meshes", count(0.1, 3_000), |g| {
        let (base, whole) = &bases[g.below(bases.len())];
        let (bytes, change) = mutate(base, g);
        match body(&bytes) {
            None => Verdict::Refused,
            Some(body) if change == Change::Other || same(&body, whole) => Verdict::Taken,
            Some(_) => Verdict::Finding(format!(
                "{change:?} of {} to {} bytes is taken for another body",
                base.len(),
                bytes.len()
            )),
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

fn same(a: &Body, b: &Body) -> bool {
    a.mesh.nodes == b.mesh.nodes
        && a.mesh.elements == b.mesh.elements
        && a.fractures.faces.len() == b.fractures.faces.len()
        && a.prescribed() == b.prescribed()
}
