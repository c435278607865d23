//! Claim: springs in place of multipliers approach the same answers, a penalty as 1/κ, updated multipliers to a tolerance.

use crate::scenes::{CYCLE, PASSING, SLIDING, body, run};
use fracas::nonlinear::{Simulation, State, StepRecord};
use fracas::scene::Scene;
use fracas_solvers::Silent;

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

/// Cohesion alone holds a block that nothing presses: t_N is 0 to rounding, and a further step of Newton's may open its faces.
#[test]
fn a_block_that_nothing_presses_ends_where_the_residual_says_too() {
    let scene = |measure: &str| {
        let own = [
            "mesh.x.cells=2",
            "mesh.y.cells=2",
            "initial_stress.constant={ zz = '0 Pa' }",
            "boundary.3.history=[['0 s', 0.0], ['4 s', 0.0], ['5 s', 0.2]]",
            "time.steps=10",
            "solver.tolerance=1e-8",
            "solver.method={penalty={factor=1e3}}",
            measure,
        ];
        let (mut slip, mut faces) = (0.0, [0; 4]);
        run(&body(SLIDING, &own), |_, _, record| {
            (slip, faces) = (record.slip_max, record.faces);
        });
        (slip, faces)
    };
    let [error, residual] = ["error", "residual"].map(|m| scene(&format!("solver.measure={m}")));
    assert_eq!(error.1, residual.1);
    // 1.2 mm at the top, 1 MPa over G = 10 GPa along 3 m
    for (slip, _) in [error, residual] {
        assert!((slip - 0.9e-3).abs() < 1e-8, "{slip}");
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

/// Layers of contrast 100 with a crossing of two fractures with cohesion, pressed together from above after they were pulled apart from the side.
const COHESIVE: &str = r#"
title = "c"
[mesh]
x = { from = "0 m", to = "6.0 m", cells = 6 }
y = { from = "0 m", to = "3.0 m", cells = 3 }
z = { from = "0 m", to = "5.0 m", cells = 5 }
[[material]]
name = "m0"
young = "52432478333.53859 Pa"
poisson = 0.38
layers = [["0.0 m", "3.0 m"]]
[[material]]
name = "m1"
young = "467849463.389883 Pa"
poisson = 0.37
layers = [["3.0 m", "5.0 m"]]
[[material]]
name = "b"
young = "10860126050.458942 Pa"
poisson = 0.2
boxes = [{ x = ["0 m", "2.0 m"], y = ["0 m", "2.0 m"], z = ["0 m", "2.0 m"] }]
[[fracture]]
name = "f"
plane = "x"
at = "2.0 m"
friction_angle = "10.0 deg"
cohesion = "29797 Pa"
[[fracture]]
name = "k"
plane = "z"
at = "2.0 m"
friction_angle = "10.0 deg"
cohesion = "417640 Pa"
[[boundary]]
side = "z-"
hold = "roller"
[[boundary]]
side = "x-"
hold = "roller"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "x+"
pressure = "686740 Pa"
[[boundary]]
side = "z+"
pressure = "120436 Pa"
history = [["0 s", 0.0], ["1 s", 1.04], ["2 s", 0.031], ["3 s", 1.127], ["4 s", 1.051], ["5 s", 0.389]]
[time]
end = "1 s"
steps = 1
"#;

#[test]
fn faces_whose_iterates_open_and_close_keep_the_cohesion_that_the_law_gives_them() {
    let largest = |method: &str| {
        let steps = steps(COHESIVE, method);
        let state = &steps.last().unwrap().1;
        assert!(!state.torn.contains(&true), "{method}");
        let slip = state.slip.chunks_exact(2).map(|s| s[0].hypot(s[1]));
        slip.fold(0.0, f64::max)
    };
    let multipliers = largest("lagrange");
    for method in [
        "{augmented_lagrangian={}}",
        "{penalty={}}",
        "{penalty={factor=1e3}}",
    ] {
        let slip = largest(method);
        let off = (slip / multipliers - 1.0).abs();
        assert!(off < 0.05, "{method}: {slip} m beside {multipliers} m");
    }
}
