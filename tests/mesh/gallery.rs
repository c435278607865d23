//! Claim: every scene of the gallery builds, is held, and has the size and character that its text says.

use fracas::mesh::{Audit, Hold};
use fracas::scene::{Scene, gallery, named};

fn small(name: &str) -> Audit {
    named(name)
        .unwrap()
        .small_scene()
        .unwrap()
        .build()
        .unwrap()
        .audit()
}

fn full(name: &str) -> Audit {
    let audit = named(name)
        .unwrap()
        .scene()
        .unwrap()
        .build()
        .unwrap()
        .audit();
    println!("{name}\n{audit}");
    audit
}

#[test]
fn every_scene_builds_small_and_reads_back_from_its_own_toml() {
    for entry in gallery() {
        let scene = entry.small_scene().unwrap();
        let body = scene.build().unwrap();
        let audit = body.audit();
        assert!(audit.n_t > 0 && audit.n_u > audit.n_t, "{}", entry.name);
        assert!(audit.n_u < 6000, "{}: {}", entry.name, audit.n_u);
        assert!(audit.min_jacobian > 0.0);
        assert_eq!(audit.kernel.stabilized_dimension, 0, "{}", entry.name);
        let again = Scene::from_toml(&scene.to_toml().unwrap(), "again.toml").unwrap();
        assert_eq!(again.sections(), scene.sections(), "{}", entry.name);
        assert_eq!(again.build().unwrap().mesh, body.mesh);
    }
}

#[test]
fn checkerboard_has_two_n_minus_one_modes_per_component() {
    for (cells, n) in [(6, 4), (12, 8)] {
        let scene = named("checkerboard").unwrap().scene().unwrap();
        let sets = ["x", "y", "z"].map(|d| format!("mesh.{d}.cells={cells}"));
        let kernel = scene
            .with_overrides(&sets)
            .unwrap()
            .build()
            .unwrap()
            .audit()
            .kernel;
        assert_eq!(kernel.dimension, Some(3 * (2 * n - 1)));
        assert_eq!(kernel.stabilized_dimension, 0);
    }
}

#[test]
fn floating_blocks_make_a_singular_and_nothing_else() {
    let audit = small("floating");
    let holds: Vec<Hold> = audit.bodies.iter().map(|b| b.hold).collect();
    assert_eq!(holds, [Hold::Boundary, Hold::Fractures, Hold::Fractures]);
    assert_eq!(audit.kernel_of_a(), 12);
    assert!(!audit.a_is_regular());
}

#[test]
fn crossings_have_junctions() {
    for name in ["crossing", "tee"] {
        let audit = small(name);
        assert!(
            audit.fractures.iter().all(|f| f.junction_edges == 4),
            "{name}: {:?}",
            audit.fractures
        );
        assert!(audit.a_is_regular());
    }
}

#[test]
fn analogues_have_the_published_ratio_and_character() {
    // published: n_t/n_u = 6336/218790, 6936/194208, 167799/379983
    for (name, ratio, regular) in [
        ("analogue_a", 6336.0 / 218790.0, false),
        ("analogue_b", 6936.0 / 194208.0, true),
        ("analogue_c", 167799.0 / 379983.0, true),
        ("analogue_c_blocks", 167799.0 / 379983.0, true),
    ] {
        let audit = full(name);
        let ours = audit.n_t as f64 / audit.n_u as f64;
        assert!(
            (ours / ratio - 1.0).abs() < 0.03,
            "{name}: {ours} against {ratio}"
        );
        assert!(audit.n_u >= 20_000, "{name}: {}", audit.n_u);
        assert_eq!(audit.a_is_regular(), regular, "{name}");
    }
}

#[test]
fn layers_and_shapes_are_what_they_say() {
    let body = named("layered")
        .unwrap()
        .small_scene()
        .unwrap()
        .build()
        .unwrap();
    let soft = body.mesh.regions.iter().filter(|r| **r == 1).count();
    assert_eq!(soft, 72); // two of six layers of 36
    assert_eq!(body.materials[0].young / body.materials[1].young, 1e3);
    let ratio = small("stretched").aspect_ratio;
    assert!((ratio - 50.0).abs() < 1e-9, "{ratio}");
}
