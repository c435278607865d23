//! Claim: around an exact S_u⁻¹ an iteration that reaches its limit is no end of a run: the Jacobian is factorized, and the run is the same.

use fracas::nonlinear::{Simulation, State};
use fracas::scene::named;
use fracas_solvers::Silent;
use std::collections::BTreeMap;

/// The last state, and how many systems each method solved.
fn run(max_krylov: &str) -> (State, BTreeMap<&'static str, usize>) {
    let scene = named("cycle").unwrap().small_scene().unwrap();
    let body = scene
        .with_overrides(&["solver.inner=exact", max_krylov])
        .unwrap()
        .build()
        .unwrap();
    let (mut last, mut methods) = (None, BTreeMap::new());
    let mut simulation = Simulation::new(&body).unwrap();
    let end = simulation.run(&mut Silent, |_, _, done| {
        for system in &done.linear {
            assert!(
                system.relative_residual <= system.tolerance.max(1e-2),
                "{system:?}"
            );
            *methods.entry(system.krylov).or_default() += 1;
        }
        last = Some(done.state.clone());
    });
    assert!(end.is_ok(), "{max_krylov}: {end:?}");
    (last.unwrap(), methods)
}

#[test]
fn systems_that_no_iteration_solves_are_factorized_and_the_run_is_the_same() {
    let (usual, by) = run("solver.max_krylov=400");
    assert!(!by.contains_key("direct"), "{by:?}");
    let (short, by) = run("solver.max_krylov=2");
    assert!(by["direct"] > 10, "{by:?}");
    assert_eq!(short.states, usual.states);
    for (short, usual) in [(&short.u, &usual.u), (&short.t, &usual.t)] {
        let size = usual.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let apart = short.iter().zip(usual).map(|(a, b)| (a - b).abs());
        let apart = apart.fold(0.0, f64::max) / size;
        assert!(apart <= 1e-6, "{apart}");
    }
}
