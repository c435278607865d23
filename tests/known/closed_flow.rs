//! Claim: closed fractures hold what fluid they have: after long it has the same pressure everywhere, that of its volume, however it came
//! there and whether or not it pushes on rock that moves. On the way there no rock moves: every face carries the initial stress and its own
//! pressure, however much that differs from those beside it.

use fracas::contact::ContactState;
use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// Initial stress of the scenes, in every direction [Pa].
const INITIAL: f64 = -90e6;

/// A scene that the seed alone decides, and the pressure that it ends with [MPa].
fn scene(seed: u64) -> (String, f64) {
    let r = &mut Random::new(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 11);
    let n = r.whole(3, 5);
    let mut toml = String::from("title = 'closed'\n[mesh]\n");
    for axis in ["x", "y", "z"] {
        toml += &format!("{axis} = {{ from = '0 m', to = '{n} m', cells = {n} }}\n");
    }
    toml += "[[material]]\nname = 'rock'\nyoung = '25 GPa'\npoisson = 0.25\n";
    // m³/MPa, and m³
    let (mut held, mut capacity) = (0.0, 0.0);
    let mut fracture = |r: &mut Random, name: &str, plane: &str, area: f64, range: String| {
        let storage = 10f64.powf(r.between(-13.0, -10.0));
        let pressure = r.between(0.0, 5.0);
        capacity += area * storage * 1e6;
        held += area * storage * 1e6 * pressure;
        toml += &format!(
            "[[fracture]]\nname = '{name}'\nplane = '{plane}'\nat = '2 m'\nfriction_angle = '30 deg'\ncohesion = '1 GPa'\n\
             conductivity = '{:e} m3'\ninitial_pressure = '{pressure} MPa'\nstorage = '{storage:e} m/Pa'\n{range}",
            10f64.powf(r.between(-16.0, -11.0)),
        );
    };
    let size = f64::from(n);
    // a row of faces along a fixed side moves nothing
    let stuck = r.chance(0.3);
    match stuck {
        true => fracture(r, "main", "x", size, "z = ['0 m', '1 m']\n".into()),
        false => fracture(r, "main", "x", size * size, String::new()),
    }
    if !stuck && r.chance(0.6) {
        let range = "x = ['1 m', '3 m']\n".to_owned();
        fracture(r, "other", "y", 2.0 * size, range);
    }
    toml += "[fluid]\nviscosity = '1 cP'\n[initial_stress]\n\
             constant = { xx = '-90 MPa', yy = '-90 MPa', zz = '-90 MPa' }\n";
    let hold = if stuck { "fixed" } else { "roller" };
    for side in ["x-", "x+", "y-", "y+", "z-", "z+"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = '{hold}'\n");
    }
    let mut volume = 0.0;
    if r.chance(0.7) {
        volume = capacity * r.between(0.1, 3.0);
        toml += &format!(
            "[[source]]\nfracture = 'main'\nat = ['2 m', '0.5 m', '0.5 m']\nrate = '{:e} m3/s'\n\
             history = [['0 s', 1], ['1 s', 1], ['1.5 s', 0]]\n",
            volume / 1.25
        );
    }
    toml += "[time]\nend = '1e7 s'\nsteps = 4\n";
    let inner = ["auto", "amg", "geometric", "exact"][seed as usize % 4];
    toml += &format!("[solver]\ninner = '{inner}'\n");
    (toml, (held + volume) / capacity)
}

#[test]
fn what_closed_fractures_hold_spreads_evenly_and_none_is_lost() {
    let number = |name: &str, or: u64| std::env::var(name).map_or(or, |s| s.parse().unwrap());
    let first = number("FRACAS_SEED", 0);
    for seed in first..first + number("FRACAS_RUNS", 16) {
        let (text, expected) = scene(seed);
        let body = Scene::from_toml(&text, "closed.toml")
            .and_then(|scene| scene.build())
            .unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        // where a pressure passes the initial stress the rock does move
        let mut opened = false;
        while !simulation.is_finished(&state) || state.step == 0 {
            match simulation.advance(&state, &mut Silent) {
                Ok(step) => state = step.state,
                Err(failure) => panic!("seed {seed}: {}\n{text}", failure.reason),
            }
            opened |= state.states.contains(&ContactState::Open);
            for (t, p) in state.t.chunks_exact(3).zip(&state.p).filter(|_| !opened) {
                let off = t[0] - (INITIAL + p);
                assert!(off.abs() < 1e-6 * -INITIAL, "seed {seed}: {off} Pa\n{text}");
            }
        }
        for p in &state.p {
            assert!(
                (p * 1e-6 - expected).abs() < 1e-6 * expected,
                "seed {seed}: {p} Pa, {expected} MPa expected\n{text}"
            );
        }
    }
}

#[test]
fn a_fluid_that_pushes_on_tips_alone_is_at_rest() {
    for more in ["", "storage = '1e-10 m/Pa'\n"] {
        let toml = format!(
            "title = 'tips'\n[mesh]\nx = {{ from = '0 m', to = '4 m', cells = 4 }}\ny = {{ from = '0 m', to = '2 m', cells = 2 }}\nz = {{ from = '0 m', to = '4 m', cells = 4 }}\n\
             [[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n\
             [[fracture]]\nname = 'f'\nplane = 'x'\nat = '2 m'\ny = ['0 m', '1 m']\nz = ['0 m', '3 m']\nfriction_angle = '30 deg'\nconductivity = '1e-14 m3'\ninitial_pressure = '1 MPa'\n{more}\
             [[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'y-'\nhold = 'fixed'\n\
             [fluid]\nviscosity = '1 cP'\n[time]\nend = '1 s'\nsteps = 1\n"
        );
        let body = Scene::from_toml(&toml, "tips.toml")
            .unwrap()
            .build()
            .unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        while !simulation.is_finished(&state) || state.step == 0 {
            state = simulation.advance(&state, &mut Silent).unwrap().state;
        }
        assert!(
            state.p.iter().all(|p| (p - 1e6).abs() < 1.0),
            "{:?}",
            state.p
        );
        assert!(state.u.iter().all(|u| u.abs() < 1e-12));
    }
}
