//! Claim: a state belongs to one mesh, one numbering and one scene.

use fracas::io::Fingerprint;
use fracas::scene::named;

#[test]
fn mesh_numbering_and_scene_are_told_apart() {
    let scene = named("patch").unwrap().scene().unwrap();
    let build = |set: &[&str]| scene.with_overrides(set).unwrap().build().unwrap();
    let body = build(&[]);
    let own = Fingerprint::new(&body, "scene");
    assert_eq!(own, Fingerprint::new(&build(&[]), "scene"));
    for set in ["mesh.x.cells=6", "mesh.y.to=1.5 m", "boundary.0.hold=fixed"] {
        assert_ne!(
            own.mesh,
            Fingerprint::new(&build(&[set]), "scene").mesh,
            "{set}"
        );
    }
    let mut turned = body.clone();
    turned.fractures.faces[2].frame.swap(1, 2);
    assert_ne!(own.mesh, Fingerprint::new(&turned, "scene").mesh);
    let other = Fingerprint::new(&body, "Scene");
    assert!(other.mesh == own.mesh && other.scene != own.scene);
}
