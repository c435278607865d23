//! Claim: stick, slip and opening reproduce answers that are known exactly.

use crate::scenes::{CYCLE, PASSING, SLIDING, body, run};
use fracas::contact::ContactState;
use fracas::nonlinear::Simulation;
use fracas_solvers::Silent;

#[test]
fn a_sliding_block_follows_its_hysteresis_loop() {
    let body = body(SLIDING, &[]);
    let (g, height) = (1e10, 3.0);
    let limit = 1e6 + 1e7 * 30f64.to_radians().tan();
    let (mut slip, mut work, mut before) = (0.0, 0.0, (0.0, 0.0));
    run(&body, |state, fields, _| {
        let top = 6e-3 * body.histories[1].at(state.time);
        // elastic predictor τ = G (U − slip)/H, held at the limit
        let tau = (g * (top - slip) / height).clamp(-limit, limit);
        slip = top - tau * height / g;
        assert!(
            (fields.traction[0] + 1e7).abs() < 1e-5,
            "{:?}",
            fields.traction
        );
        // t1 of a plane z lies in the plane: compare as vectors along x
        let e = body.fractures.faces[0].frame;
        let along_x = |v: &[f64]| (0..3).map(|k| v[k] * e[k][0]).sum::<f64>();
        let (t, s) = (along_x(&fields.traction), along_x(&fields.jump));
        assert!(
            (t - tau).abs() < 1e-9 * limit,
            "t = {}: {t} against {tau}",
            state.time
        );
        assert!(
            (s - slip).abs() < 1e-11,
            "t = {}: {s} against {slip}",
            state.time
        );
        if state.time > 1.0 {
            work += t * (s - before.1);
        }
        before = (t, s);
    });
    // 4 τ_L (U_m − τ_L H/G) per cycle
    let cycle = 4.0 * limit * (6e-3 - limit * height / g);
    assert!(
        (work - cycle).abs() < 1e-9 * cycle,
        "{work} against {cycle}"
    );
}

#[test]
fn a_block_that_weakens_faster_than_the_rock_is_stiff_finds_its_only_state() {
    let (g, height, end) = (1e10, 3.0, 6e-3);
    for (distance, steps) in [(1e-4, 1), (1e-4, 20), (2e-3, 7)] {
        let body = body(
            SLIDING,
            &[
                "fracture.0.cohesion=0 MPa",
                "fracture.0.dynamic_friction_angle=10 deg",
                &format!("fracture.0.weakening_distance={distance} m"),
                &format!("time.steps={steps}"),
                "time.end=1 s",
                "solver.unstable=arrest",
            ],
        );
        run(&body, |state, fields, _| {
            let e = body.fractures.faces[0].frame;
            let along_x = |v: &[f64]| (0..3).map(|k| v[k] * e[k][0]).sum::<f64>();
            let (t, slip) = (along_x(&fields.traction), along_x(&fields.jump));
            // equilibrium of the column, and the limit at this slip
            let top = end * state.time;
            assert!((t - g * (top - slip) / height).abs() < 1e-6 * g * end / height);
            let angle = 30.0 - 20.0 * (slip / distance).min(1.0);
            let limit = 1e7 * f64::to_radians(angle).tan();
            assert!(
                t < limit * (1.0 + 1e-6),
                "{distance} {steps}: {t} over {limit}"
            );
            if state.time == 1.0 {
                let residual = 1e7 * 10f64.to_radians().tan();
                assert!(
                    (t - residual).abs() < 1e-6 * residual,
                    "{distance} {steps}: {t}"
                );
            }
        });
    }
}

#[test]
fn a_block_on_a_steep_plane_slides_without_traction() {
    let body = body(PASSING, &[]);
    run(&body, |_, fields, record| {
        assert_eq!(record.faces[0], 0, "nothing sticks");
        for (f, slip) in fields.slip.iter().enumerate() {
            assert!((slip - 0.1 * 2f64.sqrt()).abs() < 1e-7, "face {f}: {slip}");
            let t = &fields.traction[3 * f..][..3];
            assert!(t.iter().all(|t| t.abs() < 1e3), "face {f}: {t:?}");
        }
    });
}

#[test]
fn faces_go_through_all_states_and_back() {
    let body = body(CYCLE, &[]);
    let mut counts = Vec::new();
    run(&body, |state, fields, record| {
        counts.push(record.faces);
        for (f, s) in state.states.iter().enumerate() {
            match s {
                ContactState::Open => {
                    assert!(fields.jump[3 * f] > -1e-9);
                    assert!(fields.traction[3 * f].abs() < 10.0);
                }
                _ => {
                    assert!(fields.traction[3 * f] < 100.0);
                    assert!(fields.criticality[f] < 1.0 + 1e-4 || fields.tau_limit[f] < 1e3);
                }
            }
        }
    });
    assert_eq!(counts.len(), 11);
    assert!(counts.iter().any(|c| c[3] == 25), "all open: {counts:?}");
    assert!(counts.iter().any(|c| c[2] > 0), "some slip: {counts:?}");
    assert_eq!(counts[10][3], 0, "closed at the end: {counts:?}");
}

/// Gravity balanced by an initial stress, a vertical cut through it.
const GRAVITY: &str = r#"
title = "Gravity in equilibrium"
[mesh]
x = { from = "-500 m", to = "500 m", cells = 4 }
y = { from = "0 m", to = "500 m", cells = 2 }
z = { from = "-1 km", to = "0 m", cells = 8 }
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.25
[[fracture]]
name = "cut"
plane = "x"
at = "0 m"
friction_angle = "30 deg"
[body_force]
z = "-25 kPa/m"
[initial_stress]
gradient = { xx = "12.5 kPa/m", yy = "12.5 kPa/m", zz = "25 kPa/m" }
[[boundary]]
side = "x-"
hold = "roller"
[[boundary]]
side = "x+"
hold = "roller"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "z-"
hold = "roller"
"#;

#[test]
fn gravity_in_equilibrium_moves_a_cut_body_by_what_constant_tractions_miss() {
    let body = body(GRAVITY, &[]);
    run(&body, |state, fields, record| {
        // a column of rock is pressed by ρ g L²/(2 M_c) = 1.04 m under its own weight
        let moved = state.u.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
        assert!(moved < 2e-3, "{moved}");
        assert_eq!(record.faces, [16, 0, 0, 0]);
        for (face, t) in body
            .fractures
            .faces
            .iter()
            .zip(fields.traction.chunks_exact(3))
        {
            let exact = 12.5e3 * face.center[2];
            assert!(
                (t[0] - exact).abs() < 0.02 * 12.5e6,
                "{} against {exact}",
                t[0]
            );
        }
    });
}

#[test]
fn steps_land_on_the_corners_of_histories() {
    // corners at 1, 3 and 5 s; three steps of 5/3 s jump over the first and the second
    let body = body(SLIDING, &["time.steps=3"]);
    let mut times = Vec::new();
    run(&body, |state, _, _| times.push(state.time));
    let expected = [0.0, 1.0, 5.0 / 3.0, 3.0, 10.0 / 3.0, 5.0];
    assert_eq!(times.len(), expected.len(), "{times:?}");
    for (time, expected) in times.iter().zip(expected) {
        assert!((time - expected).abs() < 1e-12, "{times:?}");
    }
}

#[test]
fn the_energy_of_a_sliding_block_goes_into_friction() {
    let body = body(SLIDING, &[]);
    let mut simulation = Simulation::new(&body).unwrap();
    let limit = 1e6 + 1e7 * 30f64.to_radians().tan();
    let cycle = 4.0 * limit * (6e-3 - limit * 3.0 / 1e10);
    // over the closed cycle from 1 s to 5 s the elastic energy returns to where it was
    let (mut dissipated, mut external, mut elastic, mut taken) = (0.0, 0.0, 0.0, 0.0);
    let end = simulation.run(&mut Silent, |simulation, before, done| {
        let energy = simulation.energy(before, &done.state);
        assert!(energy.error.abs() < 1e-9 * cycle, "{energy:?}");
        assert_eq!(energy.pressure_work, 0.0);
        assert!(energy.dissipation >= 0.0, "{energy:?}");
        if before.time >= 1.0 {
            dissipated += energy.dissipation;
            external += energy.external_work;
            elastic += energy.elastic_change;
            taken += energy.contact_work;
        }
    });
    end.unwrap();
    assert!(
        (dissipated - cycle).abs() < 1e-9 * cycle,
        "{dissipated} against {cycle}"
    );
    assert!((external - elastic - taken).abs() < 1e-8 * cycle);
    assert!(elastic.abs() < 1e-9 * cycle, "{elastic}");
    // the steps in which slip begins cost the trapezoidal rule a share of their own length
    assert!(
        (taken - cycle).abs() < 0.2 * cycle,
        "{taken} against {cycle}"
    );
}
