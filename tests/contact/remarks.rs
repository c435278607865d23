//! Claim: what runs, but perhaps not as meant, is told before it begins.

use fracas::nonlinear::{Remark, friction_remarks};
use fracas::scene::{Scene, named};

fn remarks(overrides: &[&str]) -> Vec<Remark> {
    let scene = named("cycle").unwrap().small_scene().unwrap();
    let given = [
        "fracture.0.weakening_distance=5 mm",
        "initial_stress.constant.xx=-10 MPa",
    ];
    let all: Vec<&str> = given.iter().chain(overrides).copied().collect();
    let body = scene.with_overrides(&all).unwrap().build().unwrap();
    friction_remarks(&body)
}

#[test]
fn a_profile_beside_its_fracture_is_told() {
    let toml = |z: [f64; 2]| {
        let rows = z.map(|z| format!("{{ z = '{z} m', cohesion = '{} MPa' }}", z.abs()));
        format!(
            "title = 'b'\n[mesh]\nx = {{ from = '0 m', to = '2 m', cells = 2 }}\ny = {{ from = '0 m', to = '2 m', cells = 2 }}\nz = {{ from = '-4 m', to = '0 m', cells = 4 }}\n\
             [[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n\
             [[fracture]]\nname = 'F'\nplane = 'x'\nat = '1 m'\nprofile = [{}]\n[[boundary]]\nside = 'z-'\nhold = 'fixed'\n",
            rows.join(", ")
        )
    };
    for (z, told) in [
        ([1.0, 3.0], true),
        ([-3.0, -1.0], false),
        ([-9.0, -3.6], true),
        ([-9.0, -3.0], false),
    ] {
        let body = Scene::from_toml(&toml(z), "b.toml")
            .unwrap()
            .build()
            .unwrap();
        let found = friction_remarks(&body);
        assert_eq!(
            matches!(found[..], [Remark::Beside { .. }]),
            told,
            "{z:?} {found:?}"
        );
    }
}

#[test]
fn strengthening_and_coarse_faces_are_told() {
    let found = remarks(&["fracture.0.dynamic_friction_angle=35 deg"]);
    assert!(
        matches!(found[..], [Remark::Strengthens { .. }]),
        "{found:?}"
    );
    let found = remarks(&["fracture.0.dynamic_friction_angle=10 deg"]);
    let [Remark::Coarse { size, length, .. }] = found[..] else {
        panic!("{found:?}");
    };
    // G = 2 GPa, ν = 0.25, W = (tan 30° − tan 10°) 10 MPa / 5 mm
    let w = (30f64.to_radians().tan() - 10f64.to_radians().tan()) * 1e7 / 5e-3;
    assert!((length - 0.578_887 * 2e9 / (0.75 * w)).abs() < 1e-9 * length);
    assert!(size > 0.2 * length);
    assert!(remarks(&["fracture.0.dynamic_friction_angle=29.9 deg"]).is_empty());
}
