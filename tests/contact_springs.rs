//! Claim: springs in place of multipliers approach the same answers, a penalty as 1/κ, updated multipliers to a tolerance.
#![allow(clippy::unwrap_used)]

use fracas::nonlinear::{FaceFields, Simulation, State, StepRecord};
use fracas::scene::{Body, Scene};
use fracas_solvers::Silent;

fn body(toml: &str, overrides: &[&str]) -> Body {
    let scene = Scene::from_toml(toml, "scene.toml").unwrap();
    scene.with_overrides(overrides).unwrap().build().unwrap()
}

/// Runs to the end; what `visit` sees is every accepted step.
fn run(body: &Body, mut visit: impl FnMut(&State, &FaceFields, &StepRecord)) {
    let mut simulation = Simulation::new(body).unwrap();
    let mut state = simulation.initial_state();
    while !simulation.is_finished(&state) || state.step == 0 {
        let done = match simulation.advance(&state, &mut Silent) {
            Ok(done) => done,
            Err(failure) => panic!("{failure}"),
        };
        state = done.state;
        visit(&state, &simulation.face_fields(&state), &done.record);
    }
}

/// Two blocks of heights 1 and 2 m, only u_x(z) free, sheared forth and back at the top.
const SLIDING: &str = r#"
title = "Block sliding"
[mesh]
x = { from = "0 m", to = "1 m", cells = 1 }
y = { from = "0 m", to = "1 m", cells = 1 }
z = { from = "0 m", to = "3 m", cells = 6 }
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "cut"
plane = "z"
at = "1 m"
friction_angle = "30 deg"
cohesion = "1 MPa"
[initial_stress]
constant = { xx = "-10 MPa", yy = "-10 MPa", zz = "-10 MPa" }
[[boundary]]
side = "x-"
displacement = { y = "0 m", z = "0 m" }
[[boundary]]
side = "x+"
displacement = { y = "0 m", z = "0 m" }
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
displacement = { x = "6 mm", y = "0 m", z = "0 m" }
history = [["0 s", 0.0], ["1 s", 1.0], ["3 s", -1.0], ["5 s", 1.0]]
[time]
end = "5 s"
steps = 20
[solver]
tolerance = 1e-13
"#;

/// A block on a plane of 45 deg that is pushed down and cannot but slide.
const PASSING: &str = r#"
title = "Passing crack"
[mesh]
x = { from = "-1 m", to = "1 m", cells = 6 }
y = { from = "0 m", to = "1 m", cells = 2 }
z = { from = "-2 m", to = "2 m", cells = 8 }
[mesh.map.incline]
plane = "z"
along = "x"
tilt = "45 deg"
fade = true
pivot = ["0 m", "0.5 m", "0 m"]
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.2
[[fracture]]
name = "cut"
plane = "z"
at = "0 m"
friction_angle = "30 deg"
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
displacement = { z = "-0.1 m" }
[solver]
tolerance = 1e-11
"#;

/// Closed, sliding, open and back.
const CYCLE: &str = r#"
title = "Cycle of states"
[mesh]
x = { from = "-4 m", to = "4 m", cells = 4 }
y = { from = "0 m", to = "20 m", cells = 5 }
z = { from = "0 m", to = "20 m", cells = 5 }
[[material]]
name = "rock"
young = "5 GPa"
poisson = 0.25
[[fracture]]
name = "cut"
plane = "x"
at = "0 m"
friction_angle = "30 deg"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
displacement = { x = "-1 mm" }
history = [["0 s", 1.0], ["5 s", -1.0], ["10 s", 1.0]]
[[boundary]]
side = "x+"
displacement = { z = "1 mm", y = "0 m" }
history = [["0 s", 0.0], ["2 s", 1.0], ["8 s", 1.0], ["10 s", 0.0]]
[time]
end = "10 s"
steps = 10
"#;

/// Largest error of shear traction, relative to the limit, and of slip, relative to its largest, along the loop.
fn errors_of_the_loop(method: &str) -> [f64; 2] {
    let body = body(SLIDING, &["solver.tolerance=1e-10", method]);
    let (g, height) = (1e10, 3.0);
    let limit = 1e6 + 1e7 * 30f64.to_radians().tan();
    let (mut slip, mut errors) = (0.0, [0.0, 0.0]);
    run(&body, |state, fields, _| {
        let top = 6e-3 * body.histories[1].at(state.time);
        let tau = (g * (top - slip) / height).clamp(-limit, limit);
        slip = top - tau * height / g;
        let e = body.fractures.faces[0].frame;
        let along_x = |v: &[f64]| (0..3).map(|k| v[k] * e[k][0]).sum::<f64>();
        let (t, s) = (along_x(&fields.traction), along_x(&fields.jump));
        errors = [
            f64::max(errors[0], (t - tau).abs() / limit),
            f64::max(errors[1], (s - slip).abs() / (6e-3 - limit * height / g)),
        ];
    });
    errors
}

#[test]
fn a_penalty_follows_the_hysteresis_loop_to_first_order() {
    let factors = [1e1, 1e2, 1e3, 1e4, 1e5];
    let errors =
        factors.map(|k| errors_of_the_loop(&format!("solver.method={{penalty={{factor={k}}}}}")));
    println!("{errors:?}");
    for pair in errors.windows(2) {
        for k in 0..2 {
            let order = (pair[0][k] / pair[1][k]).log10();
            assert!((order - 1.0).abs() < 0.1, "{errors:?}");
        }
    }
}

#[test]
fn updated_multipliers_follow_the_hysteresis_loop_to_the_tolerance() {
    for factor in [1.0, 10.0, 100.0] {
        let method = format!("solver.method={{augmented_lagrangian={{factor={factor}}}}}");
        let errors = errors_of_the_loop(&method);
        println!("{factor} {errors:?}");
        assert!(
            errors.iter().all(|e| *e < 1e-5),
            "factor {factor}: {errors:?}"
        );
    }
}

/// Records and states of every step of a scene.
fn steps(toml: &str, method: &str) -> Vec<(StepRecord, State)> {
    let body = body(toml, &[&format!("solver.method={method}")]);
    let mut steps = Vec::new();
    run(&body, |state, _, record| {
        steps.push((*record, state.clone()))
    });
    steps
}

#[test]
fn springs_go_through_the_states_of_multipliers() {
    let exact = steps(CYCLE, "lagrange");
    for method in [
        "{penalty={factor=1e3}}",
        "{augmented_lagrangian={factor=10}}",
    ] {
        let found = steps(CYCLE, method);
        assert_eq!(found.len(), exact.len(), "{method}: no step is cut");
        for (a, b) in exact.iter().zip(&found) {
            assert_eq!(a.0.faces, b.0.faces, "{method} at {} s", a.0.time);
        }
    }
}

#[test]
fn overlap_falls_with_the_stiffness_and_vanishes_with_updates() {
    let most = |method: &str| {
        let overlaps = steps(CYCLE, method)
            .into_iter()
            .map(|(record, _)| record.max_pen);
        overlaps.fold(0.0, f64::max)
    };
    let [soft, stiff] = [1e2, 1e4].map(|k| most(&format!("{{penalty={{factor={k}}}}}")));
    assert!((soft / stiff - 100.0).abs() < 2.0, "{soft:e} {stiff:e}");
    let updated = most("{augmented_lagrangian={factor=10}}");
    // state_tolerance = 1e-6 of the largest jump that the loads could make, about the prescribed 1 mm
    assert!(updated < 5e-9, "{updated:e}");
}

#[test]
fn a_block_slides_on_springs_without_traction() {
    for method in [
        "{penalty={factor=1e3}}",
        "{augmented_lagrangian={factor=1e2}}",
    ] {
        let (record, state) = &steps(PASSING, method)[0];
        assert_eq!(record.faces[0], 0, "{method}: nothing sticks");
        assert!(
            (record.slip_max - 0.1 * 2f64.sqrt()).abs() < 1e-7,
            "{method}"
        );
        assert!(
            state.t.iter().all(|t| t.abs() < 1e3),
            "{method}: {:?}",
            state.t
        );
    }
}

#[test]
fn a_factor_that_is_not_positive_is_refused() {
    let scene = Scene::from_toml(CYCLE, "scene.toml").unwrap();
    for method in [
        "{penalty={factor=0}}",
        "{augmented_lagrangian={max_updates=0}}",
    ] {
        let scene = scene
            .with_overrides(&[&format!("solver.method={method}")])
            .unwrap();
        assert!(scene.build().is_err(), "{method}");
    }
}

#[test]
fn a_restart_from_any_step_gives_the_same_bits() {
    for method in [
        "{penalty={factor=1e3}}",
        "{augmented_lagrangian={factor=10}}",
    ] {
        let body = body(CYCLE, &[&format!("solver.method={method}")]);
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        while state.step == 0 || !simulation.is_finished(&state) {
            let mut again = Simulation::new(&body).unwrap();
            let next = simulation.advance(&state, &mut Silent).unwrap().state;
            let restarted = again.advance(&state, &mut Silent).unwrap().state;
            assert_eq!(next, restarted, "{method}, step {}", state.step);
            state = next;
        }
    }
}
