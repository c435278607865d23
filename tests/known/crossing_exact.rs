//! Claim: fractures that cross pass uniform stress exactly while they stick, and move as blocks where one of them slides or opens.

use fracas::analytic::{BlockSliding, SlidingState};
use fracas::contact::ContactState;
use fracas::mesh::FractureFace;
use fracas::nonlinear::{FaceFields, Simulation, State};
use fracas::scene::{Body, History, Scene};
use fracas_solvers::Silent;
use std::fmt::Write;

fn body(toml: &str) -> Body {
    let scene = Scene::from_toml(toml, "crossing.toml").unwrap();
    scene.build().unwrap()
}

/// Every accepted step to the end.
fn run(body: &Body, mut visit: impl FnMut(&State, &FaceFields)) {
    let mut simulation = Simulation::new(body).unwrap();
    let end = simulation.run(&mut Silent, |simulation, _, done| {
        visit(&done.state, &simulation.face_fields(&done.state));
    });
    end.unwrap();
}

/// Pressures on x+, y+, z+ against rollers on the sides opposite [Pa].
const PRESSURES: [f64; 3] = [12e6, 20e6, 31e6];

/// Grid lines across x that leave two cells to every arm of the fractures, and one [m].
const FINE: &str = "'0 m', '0.25 m', '0.5 m', '1 m', '1.5 m', '1.75 m', '2 m', '2.5 m', '3 m'";
const COARSE: &str = "'0 m', '0.5 m', '1.5 m', '2 m', '3 m'";

/// A box of 3 × 2 × 4 m under three pressures, its fractures too strong to slip.
fn patch(x: &str, map: &str, fractures: &[(&str, &str)], solver: &str) -> String {
    let cells = x.matches(',').count();
    let mut toml = format!(
        "title = 'Patch'\n[mesh]\nx = {{ lines = [{x}] }}\ny = {{ from = '0 m', to = '2 m', cells = {cells} }}\nz = {{ from = '0 m', to = '4 m', cells = 8 }}\n",
    );
    toml += map;
    toml += "[[material]]\nname = 'rock'\nyoung = '25 GPa'\npoisson = 0.25\n";
    for (k, (plane, rest)) in fractures.iter().enumerate() {
        let _ = writeln!(
            toml,
            "[[fracture]]\nname = 'f{k}'\nplane = '{plane}'\n{rest}\nfriction_angle = '45 deg'\ncohesion = '1 GPa'"
        );
    }
    for (axis, pressure) in ["x", "y", "z"].into_iter().zip(PRESSURES) {
        let _ = writeln!(
            toml,
            "[[boundary]]\nside = '{axis}-'\nhold = 'roller'\n[[boundary]]\nside = '{axis}+'\npressure = '{pressure} Pa'"
        );
    }
    toml + "[solver]\ntolerance = 1e-13\n" + solver
}

/// σ·n in the frame of a face.
fn resolved(face: &FractureFace, sigma: [[f64; 3]; 3]) -> [f64; 3] {
    let n = face.frame[0];
    let on = sigma.map(|row| (0..3).map(|k| row[k] * n[k]).sum::<f64>());
    face.frame
        .map(|e| (0..3).map(|k| e[k] * on[k]).sum::<f64>())
}

/// Three fractures that end inside the box and cross each other in (1.5, 1, 2) m.
const THREE_CLOSED: [(&str, &str); 3] = [
    (
        "x",
        "at = '1.5 m'\ny = ['0.5 m', '1.5 m']\nz = ['1 m', '3 m']",
    ),
    ("y", "at = '1 m'\nx = ['0.5 m', '2 m']\nz = ['1 m', '3 m']"),
    (
        "z",
        "at = '2 m'\nx = ['0.5 m', '2 m']\ny = ['0.5 m', '1.5 m']",
    ),
];

#[test]
fn an_arm_of_one_cell_leaves_tractions_free_and_the_audit_says_so() {
    // the edges where fractures cross have no H, and the tips of such an arm do not move
    let coarse = body(&patch(COARSE, "", &THREE_CLOSED, ""));
    assert_eq!(coarse.audit().kernel.stabilized_dimension, 6);
    run(&coarse, |state, fields| {
        assert!(state.states.iter().all(|s| *s == ContactState::Stick));
        let moved = state.u.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
        assert!(fields.jump.iter().all(|g| g.abs() < 1e-10 * moved));
    });
}

#[test]
fn crossing_fractures_that_stick_pass_a_uniform_stress() {
    let flat = "";
    let bent = "[mesh.map.distort]\namplitude = 0.15\nseed = 5\n[mesh.map.incline]\nplane = 'x'\ntilt = '20 deg'\npivot = ['1.5 m', '1 m', '2 m']\nfade = true\n";
    let x: &[_] = &[("x", "at = '1.5 m'"), ("z", "at = '2 m'")];
    let closed_x: &[_] = &[
        ("x", "at = '1.5 m'\nz = ['1 m', '3 m']"),
        ("z", "at = '2 m'\nx = ['0.5 m', '2 m']"),
    ];
    let t: &[_] = &[
        ("x", "at = '1.5 m'\nz = ['1 m', '3 m']"),
        ("z", "at = '2 m'\nx = ['1.5 m', '3 m']"),
    ];
    let three: &[_] = &[
        ("x", "at = '1.5 m'"),
        ("y", "at = '1 m'"),
        ("z", "at = '2 m'"),
    ];
    let three_closed: &[_] = &THREE_CLOSED;
    let sigma = [0, 1, 2]
        .map(|i: usize| [0, 1, 2].map(|j: usize| if i == j { -PRESSURES[i] } else { 0.0 }));
    for (name, fractures) in [
        ("X", x),
        ("closed X", closed_x),
        ("T", t),
        ("three", three),
        ("three closed", three_closed),
    ] {
        for (map, solver) in [
            (flat, "inner = 'exact'\n"),
            (bent, "inner = 'exact'\n"),
            (bent, "inner = 'geometric'\n"),
        ] {
            let body = body(&patch(FINE, map, fractures, solver));
            assert_eq!(body.audit().kernel.stabilized_dimension, 0, "{name}");
            run(&body, |state, fields| {
                assert!(state.states.iter().all(|s| *s == ContactState::Stick));
                let moved = state.u.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
                let (mut traction, mut jump) = (0.0f64, 0.0f64);
                for (f, face) in body.fractures.faces.iter().enumerate() {
                    for (k, exact) in resolved(face, sigma).into_iter().enumerate() {
                        traction = traction.max((fields.traction[3 * f + k] - exact).abs());
                        jump = jump.max(fields.jump[3 * f + k].abs());
                    }
                }
                let errors = [traction / PRESSURES[2], jump / moved];
                println!("{name} {solver}: {errors:?}");
                assert!(
                    errors.iter().all(|e| *e < 1e-10),
                    "{name} {solver}: {errors:?}"
                );
            });
        }
    }
}

/// A weak horizontal plane z = 1 m and a strong one of 70° dip that crosses it, sheared forth and back; only u_x(z) is free.
const WEAK_PLANE: &str = r#"
title = "A plane that slides through another"
[mesh]
x = { from = "-1.5 m", to = "1.5 m", cells = 6 }
y = { from = "0 m", to = "1 m", cells = 2 }
z = { from = "0 m", to = "3 m", cells = 6 }
[mesh.map.incline]
plane = "x"
tilt = "20 deg"
pivot = ["0 m", "0.5 m", "1 m"]
fade = true
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "weak"
plane = "z"
at = "1 m"
friction_angle = "10 deg"
[[fracture]]
name = "strong"
plane = "x"
at = "0 m"
friction_angle = "40 deg"
[initial_stress]
constant = { xx = "-10 MPa", yy = "-10 MPa", zz = "-10 MPa" }
[[boundary]]
side = "x-"
displacement = { y = "0 m", z = "0 m" }
[[boundary]]
side = "x-"
pressure = "10 MPa"
[[boundary]]
side = "x+"
displacement = { y = "0 m", z = "0 m" }
[[boundary]]
side = "x+"
pressure = "10 MPa"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
displacement = { x = "2 mm", y = "0 m", z = "0 m" }
history = [["0 s", 0.0], ["1 s", 1.0], ["3 s", -1.0]]
[time]
end = "3 s"
steps = 6
[solver]
tolerance = 1e-13
"#;

#[test]
fn a_weak_plane_slides_through_a_strong_one() {
    let body = body(WEAK_PLANE);
    let blocks = BlockSliding {
        shear: 10e9,
        heights: [1.0, 2.0],
        friction_angle: 10f64.to_radians(),
        cohesion: 0.0,
        compression: 10e6,
    };
    let mut now = SlidingState::default();
    let (mut slid, mut states) = (0.0f64, [0; 2]);
    run(&body, |state, fields| {
        let top = 2e-3 * body.histories[state_history(&body)].at(state.time);
        now = blocks.moved(now, top);
        slid = slid.max(now.slip.abs());
        let p = blocks.compression;
        let tau = now.traction;
        let sigma = [[-p, 0.0, tau], [0.0, -p, 0.0], [tau, 0.0, -p]];
        for (f, face) in body.fractures.faces.iter().enumerate() {
            let weak = face.fracture == 0;
            let exact_jump = face.frame.map(|e| if weak { now.slip * e[0] } else { 0.0 });
            let exact = resolved(face, sigma);
            for k in 0..3 {
                let [t, g] = [fields.traction[3 * f + k], fields.jump[3 * f + k]];
                assert!((t - exact[k]).abs() < 1e-9 * p, "{f} {k}: {t} {}", exact[k]);
                assert!(
                    (g - exact_jump[k]).abs() < 1e-9 * 2e-3,
                    "{f} {k}: {g} {}",
                    exact_jump[k]
                );
            }
            match state.states[f] {
                ContactState::Stick => states[0] += usize::from(weak),
                _ => {
                    assert!(weak, "the strong plane sticks");
                    states[1] += 1;
                }
            }
        }
    });
    assert!(
        slid > 1e-3 && states[0] > 0 && states[1] > 0,
        "{slid} {states:?}"
    );
}

/// Number of the history that moves the top: the only one that changes.
fn state_history(body: &Body) -> usize {
    let moves = |h: &History| (h.at(0.0) - h.at(1.0)).abs() > 0.5;
    body.histories.iter().position(moves).unwrap()
}

/// The upper blocks of a crossing, pressed together along x and lifted.
const LIFTED: &str = r#"
title = "A plane that opens through another"
[mesh]
x = { from = "-1.5 m", to = "1.5 m", cells = 6 }
y = { from = "0 m", to = "1 m", cells = 2 }
z = { from = "0 m", to = "3 m", cells = 6 }
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "opening"
plane = "z"
at = "1 m"
friction_angle = "10 deg"
[[fracture]]
name = "closed"
plane = "x"
at = "0 m"
friction_angle = "40 deg"
[[boundary]]
side = "x-"
hold = "roller"
[[boundary]]
side = "x+"
pressure = "10 MPa"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "z-"
hold = "roller"
[[boundary]]
side = "z+"
displacement = { z = "5 mm" }
[solver]
tolerance = 1e-13
"#;

#[test]
fn a_plane_opens_through_a_closed_one() {
    let body = body(LIFTED);
    // plane strain, σ_zz = 0: ε_zz = ν (1 + ν) p/E in both layers
    let gap = 5e-3 - 0.25 * 1.25 * 10e6 / 25e9 * 3.0;
    run(&body, |state, fields| {
        for (f, face) in body.fractures.faces.iter().enumerate() {
            let opens = face.fracture == 0;
            let expected = [ContactState::Stick, ContactState::Open][usize::from(opens)];
            assert_eq!(state.states[f], expected);
            let exact = [if opens { 0.0 } else { -10e6 }, 0.0, 0.0];
            for k in 0..3 {
                let jump = if opens && k == 0 { gap } else { 0.0 };
                let [t, g] = [fields.traction[3 * f + k], fields.jump[3 * f + k]];
                assert!((t - exact[k]).abs() < 1e-10 * 10e6, "{f} {k}: {t}");
                assert!((g - jump).abs() < 1e-10 * gap, "{f} {k}: {g} {jump}");
            }
        }
    });
}
