//! Claim: friction takes energy on every face of every step, and what faces take is the dissipation of the step.

use fracas::mesh::FractureFace;
use fracas::nonlinear::Simulation;
use fracas::scene::named;
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// Whatever the friction and how far states are judged: no face of an accepted step gives energy.
#[test]
fn no_face_gains_by_friction_and_together_they_are_the_dissipation() {
    let random = &mut Random::new(7);
    let mut slipped = 0;
    for seed in 0..16 {
        let (angle, tolerance) = (random.between(15.0, 40.0), random.scale(1e-6, 1e-3));
        let mut own = vec![
            format!("fracture.0.friction_angle={angle} deg"),
            format!("solver.state_tolerance={tolerance}"),
            "solver.unstable=arrest".into(),
        ];
        if seed % 2 == 1 {
            let (dynamic, distance) = (0.3 * angle, random.scale(1e-3, 1e-1));
            own.push(format!("fracture.0.dynamic_friction_angle={dynamic} deg"));
            own.push(format!("fracture.0.weakening_distance={distance} m"));
        }
        let scene = named(["cycle", "crossing"][seed / 2 % 2]).unwrap();
        let scene = scene.small_scene().unwrap().with_overrides(&own).unwrap();
        let body = scene.build().unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        while !simulation.is_finished(&state) || state.step == 0 {
            let Ok(done) = simulation.advance(&state, &mut Silent) else {
                break;
            };
            let after = done.state;
            let of_faces: Vec<f64> = simulation.slip_work(&state, &after).collect();
            let total = simulation.energy(&state, &after).dissipation;
            // what rounding makes of γ' − γ
            let worth = |(f, face): (usize, &FractureFace)| {
                let of = |v: &[f64], i: usize| v[i].hypot(v[i + 1]);
                face.area * of(&after.t, 3 * f + 1) * of(&after.slip, 2 * f)
            };
            let worth = simulation.problem().faces().iter().enumerate().map(worth);
            let zero = 8.0 * f64::EPSILON * worth.fold(0.0, f64::max);
            assert!(of_faces.iter().all(|d| *d >= -zero), "{seed}: {of_faces:?}");
            assert!((of_faces.iter().sum::<f64>() - total).abs() <= 1e-12 * total);
            slipped += of_faces.iter().filter(|d| **d > zero).count();
            state = after;
        }
    }
    assert!(slipped > 0, "nothing slips");
}
