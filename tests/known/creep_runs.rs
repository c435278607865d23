//! Claim: beside a fault that slips, the energy of a body that creeps closes; a run goes on from any checkpoint to the last bit; one
//! preconditioner serves as long as steps have one length.

use fracas::io::{Checkpoints, Fingerprint, read_checkpoint};
use fracas::nonlinear::{Simulation, State};
use fracas::scene::{Body, Scene};
use fracas_solvers::Silent;

/// A vertical fault through depleting blocks of unlike height under a layer that creeps.
fn scene(solver: &str) -> String {
    let mut toml = "title = 'Fault under salt'\n\
        [mesh]\nx = { from = '-600 m', to = '600 m', cells = 8 }\ny = { from = '0 m', to = '150 m', cells = 1 }\n\
        z = { from = '-3200 m', to = '-2000 m', cells = 8 }\n\
        [[material]]\nname = 'rock'\nyoung = '20 GPa'\npoisson = 0.2\n\
        [[material]]\nname = 'salt'\nyoung = '40 GPa'\npoisson = 0.3\nviscosity = '1e17 Pa*s'\nlayers = [['-2450 m', '-2150 m']]\n"
        .to_string();
    for (name, x, z) in [
        ("left", [-600, 0], [-2900, -2450]),
        ("right", [0, 600], [-2750, -2450]),
    ] {
        toml += &format!(
            "[[material]]\nname = '{name}'\nyoung = '11 GPa'\npoisson = 0.15\nboxes = [{{ x = ['{} m', '{} m'], z = ['{} m', '{} m'] }}]\n\
             pressure_change = '-20 MPa'\nbiot = 0.9\npressure_history = [['0 s', 0], ['1.26e8 s', 1], ['1.9e8 s', 0.2]]\n",
            x[0], x[1], z[0], z[1]
        );
    }
    toml += "[[fracture]]\nname = 'fault'\nplane = 'x'\nat = '0 m'\nz = ['-3050 m', '-2450 m']\nfriction_angle = '9 deg'\n\
        [initial_stress]\nconstant = { xx = '-35 MPa', yy = '-38 MPa', zz = '-46 MPa' }\nreference = '-2000 m'\n\
        [time]\nend = '1.9e8 s'\nsteps = 6\n";
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml + "[[boundary]]\nside = 'z+'\npressure = '46 MPa'\n[solver]\n" + solver
}

fn body(solver: &str) -> Body {
    Scene::from_toml(&scene(solver), "fault.toml")
        .unwrap()
        .build()
        .unwrap()
}

#[test]
fn energy_closes_and_set_ups_follow_the_length_of_steps() {
    let body = body("tolerance = 1e-10");
    let mut simulation = Simulation::new(&body).unwrap();
    let mut state = simulation.initial_state();
    let (mut dissipated, mut slipped, mut moved) = (0.0, 0.0, 0.0);
    let mut last = f64::NAN;
    while state.step == 0 || !simulation.is_finished(&state) {
        let accepted = simulation.advance(&state, &mut Silent).unwrap();
        let next = accepted.state;
        let energy = simulation.energy(&state, &next);
        let size = energy.external_work.abs() + energy.elastic_energy;
        assert!(energy.error.abs() <= 1e-8 * size, "{energy:?}");
        assert!(energy.creep_dissipation >= 0.0, "{energy:?}");
        // one fault: its row is what the energy of the step says
        let faults = simulation.faults(&state, &next);
        let [fault] = &faults[..] else {
            panic!("{faults:?}")
        };
        let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * size;
        assert!(
            close(fault.released, energy.contact_work),
            "{fault:?} {energy:?}"
        );
        assert!(
            close(fault.dissipated, energy.dissipation),
            "{fault:?} {energy:?}"
        );
        // G between 4.8 and 8.3 GPa
        let by_slip = fault.moment
            / (body.fractures.faces.iter().map(|f| f.area).sum::<f64>()
                * fault.slip_mean.max(1e-30));
        assert!(
            fault.moment == 0.0 || (4.7e9..8.4e9).contains(&by_slip),
            "{fault:?}"
        );
        assert!(
            fault.moment_step >= 0.0 && fault.chi_max <= 1.0 + 1e-6,
            "{fault:?}"
        );
        assert_eq!(fault.slip_max, accepted.record.slip_max);
        dissipated += energy.creep_dissipation;
        slipped += energy.dissipation;
        moved += accepted.record.slip_max;
        let dt = accepted.record.dt;
        let is_same = (dt - last).abs() <= 1e-9 * dt && accepted.record.cuts == 0;
        let allowed = if is_same { 1 } else { 2 };
        assert!(
            accepted.record.setups <= allowed,
            "step {}: {:?}",
            state.step,
            accepted.record
        );
        last = dt;
        state = next;
    }
    assert!(
        dissipated > 0.0 && slipped > 0.0 && moved > 0.0,
        "{dissipated} {slipped} {moved}"
    );
}

#[test]
fn a_run_goes_on_from_any_checkpoint_to_the_last_bit() {
    let folder = std::env::temp_dir().join(format!("fracas-creep-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for solver in [
        "",
        "inner = 'geometric'",
        "inner = 'amg'",
        "method = { penalty = {} }",
    ] {
        let body = body(solver);
        let fingerprint = Fingerprint::new(&body, solver);
        let checkpoints = Checkpoints::new(folder.clone(), fingerprint);
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        while state.step == 0 || !simulation.is_finished(&state) {
            let path = checkpoints.save(&state).unwrap();
            let read: State = read_checkpoint(&path, fingerprint).unwrap();
            assert_eq!(read, state);
            let again = Simulation::new(&body).unwrap().advance(&read, &mut Silent);
            let accepted = simulation.advance(&state, &mut Silent).unwrap();
            let again = again.unwrap();
            let bits =
                |s: &State| -> Vec<u64> { s.u.iter().chain(&s.t).map(|v| v.to_bits()).collect() };
            assert_eq!(
                bits(&again.state),
                bits(&accepted.state),
                "{solver}, step {}",
                state.step
            );
            assert_eq!(again.state, accepted.state, "{solver}, step {}", state.step);
            state = accepted.state;
        }
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn salt_at_rest_stays_at_rest_and_stress_that_is_not_isotropic_in_it_creeps() {
    let rest = scene("").replace("pressure_change = '-20 MPa'", "pressure_change = '0 MPa'");
    for isotropic in [true, false] {
        let toml = match isotropic {
            true => rest.replace(
                "layers = [['-2450 m', '-2150 m']]",
                "layers = [['-2450 m', '-2150 m']]\nisotropic_stress = true",
            ),
            false => rest.clone(),
        };
        let body = Scene::from_toml(&toml, "rest.toml")
            .unwrap()
            .build()
            .unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        while state.step == 0 || !simulation.is_finished(&state) {
            state = simulation.advance(&state, &mut Silent).unwrap().state;
        }
        let moved = state.u.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        assert_eq!(moved < 1e-9, isotropic, "{moved} m");
    }
}
