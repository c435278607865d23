//! Claim: Maxwell creep follows its closed forms: relaxation and creep to the last digits at any step, rock and creeping rock in series to
//! order 2, a cavity under pressure as it widens for ever.

use fracas::nonlinear::{Simulation, State};
use fracas::scene::{Body, Scene};
use fracas_solvers::Silent;
use std::fmt::Write;

/// G = 4 GPa, ν = 1/4, η = 2e17 Pa·s: τ = 5e7 s.
const SHEAR: f64 = 4e9;
const ETA: f64 = 2e17;
const TAU: f64 = ETA / SHEAR;

fn body(toml: &str) -> Body {
    Scene::from_toml(toml, "creep.toml")
        .unwrap()
        .build()
        .unwrap()
}

/// All states of a run, and the set-ups of each step.
fn run(body: &Body) -> (Vec<State>, Vec<usize>) {
    let mut simulation = Simulation::new(body).unwrap();
    let (mut states, mut setups) = (vec![simulation.initial_state()], Vec::new());
    while states.len() == 1 || !simulation.is_finished(&states[states.len() - 1]) {
        let accepted = simulation
            .advance(&states[states.len() - 1], &mut Silent)
            .unwrap();
        setups.push(accepted.record.setups);
        states.push(accepted.state);
    }
    (states, setups)
}

/// A layer of 2 × 1 × 3 m that shears along x: held in y and z on its sides, glued along a plane at half height. `elastic` is the height of a
/// layer below that does not creep [m].
fn layer(elastic: f64, steps: usize, end: f64, more: &str) -> String {
    let mut toml = format!(
        "title = 'Layer'\n[mesh]\nx = {{ from = '0 m', to = '2 m', cells = 2 }}\ny = {{ from = '0 m', to = '1 m', cells = 1 }}\n\
         z = {{ from = '0 m', to = '3 m', cells = 6 }}\n\
         [[material]]\nname = 'salt'\nyoung = '10 GPa'\npoisson = 0.25\nviscosity = '{ETA} Pa*s'\n\
         [[fracture]]\nname = 'plane'\nplane = 'z'\nat = '1.5 m'\ncohesion = '1000 GPa'\nfriction_angle = '30 deg'\n\
         [time]\nend = '{end} s'\nsteps = {steps}\n[solver]\ntolerance = 1e-12\n"
    );
    if elastic > 0.0 {
        let _ = writeln!(
            toml,
            "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\nlayers = [['0 m', '{elastic} m']]"
        );
    }
    toml += "[[boundary]]\nside = 'z-'\nhold = 'fixed'\n";
    for side in ["x-", "x+"] {
        let _ = writeln!(
            toml,
            "[[boundary]]\nside = '{side}'\ndisplacement = {{ y = '0 m', z = '0 m' }}"
        );
    }
    for side in ["y-", "y+"] {
        let _ = writeln!(toml, "[[boundary]]\nside = '{side}'\nhold = 'roller'");
    }
    toml + more
}

/// Shear by 1e-4 from time 0 on.
const HELD: &str =
    "[[boundary]]\nside = 'z+'\ndisplacement = { x = '0.3 mm', y = '0 m', z = '0 m' }\n";

/// Mean shear traction of the plane, with its sign along x.
fn shear(body: &Body, state: &State) -> f64 {
    let faces = body.fractures.faces.iter().zip(state.t.chunks_exact(3));
    let along = faces.map(|(face, t)| t[1] * face.frame[1][0] + t[2] * face.frame[2][0]);
    along.sum::<f64>() / body.fractures.faces.len() as f64
}

#[test]
fn shear_relaxes_as_it_must_at_steps_of_any_length() {
    for steps in [1, 3, 40] {
        let body = body(&layer(0.0, steps, 6.0 * TAU, HELD));
        let (states, setups) = run(&body);
        for state in &states[1..] {
            let exact = SHEAR * 1e-4 * (-state.time / TAU).exp();
            let found = shear(&body, state);
            assert!(
                (found - exact).abs() <= 1e-9 * SHEAR * 1e-4,
                "{steps} steps, {} s: {found} {exact}",
                state.time
            );
        }
        // one set-up for rock at time 0, one for all steps of one length
        assert_eq!(setups.iter().sum::<usize>(), 2, "{setups:?}");
        assert_eq!(setups[..2], [1, 1], "{setups:?}");
    }
}

#[test]
fn under_a_constant_load_strain_grows_with_time() {
    // τ0 at the top, and a force b along x: γ = (τ0 + b (3 − z)) (1/G + t/η), which one-dimensional elements meet at their nodes
    for (name, load, stress, force) in [
        ("traction", "traction = { x = '2 MPa' }", 2e6, 0.0),
        ("weight", "traction = { x = '0 Pa' }", 0.0, 5e5),
    ] {
        let more = format!("[body_force]\nx = '{force} Pa/m'\n[[boundary]]\nside = 'z+'\n{load}\n");
        let toml = layer(0.0, 4, 30.0 * TAU, &more);
        let body = body(&toml);
        let (states, _) = run(&body);
        let simulation = Simulation::new(&body).unwrap();
        for state in &states[1..] {
            let u = simulation.displacement(state);
            let flowed = 1.0 / SHEAR + state.time / ETA;
            let top = (stress * 3.0 + force * 4.5) * flowed;
            for (x, u) in body.mesh.nodes.iter().zip(u.chunks_exact(3)) {
                let exact = (stress * x[2] + force * (3.0 * x[2] - 0.5 * x[2] * x[2])) * flowed;
                assert!(
                    (u[0] - exact).abs() <= 1e-8 * top && u[2].abs() <= 1e-8 * top,
                    "{name} at {x:?}, {} s: {u:?} {exact}",
                    state.time
                );
            }
        }
    }
}

/// Relative error of the traction at the end of rock and creeping rock in series, which relax together as
/// `e^(−t h_c/(η (h_c + h_e)/G))`.
fn in_series(steps: usize, end: f64) -> (f64, Vec<f64>) {
    let body = body(&layer(2.0, steps, end, HELD));
    let (states, _) = run(&body);
    let tractions: Vec<f64> = states[1..].iter().map(|s| shear(&body, s)).collect();
    let exact = SHEAR * 1e-4 * (-end / TAU / 3.0).exp();
    ((tractions[steps] - exact).abs() / exact, tractions)
}

#[test]
fn rock_and_creeping_rock_in_series_relax_to_order_two_and_without_overshoot() {
    let errors: Vec<f64> = [4, 8, 16, 32].map(|n| in_series(n, 2.0 * TAU).0).to_vec();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.9..2.1).contains(&order), "{errors:?}: order {order}");
    }
    assert!(errors[3] < 1e-4, "{errors:?}");
    // five and 500 relaxation times at once
    for end in [20.0, 2000.0] {
        let (_, tractions) = in_series(4, end * TAU);
        for pair in tractions.windows(2) {
            assert!(pair[1] >= 0.0 && pair[1] < pair[0], "{tractions:?}");
        }
    }
}

/// A quarter of a ring, radii 1 to 4 m and one cell along z, as a mesh file; cells grow with the radius.
fn ring(radial: usize, around: usize) -> String {
    let node = |i: usize, j: usize, k: usize| 1 + i + (radial + 1) * (j + (around + 1) * k);
    let count = node(radial, around, 1);
    let mut nodes = String::new();
    for k in 0..2 {
        for j in 0..=around {
            for i in 0..=radial {
                let r = 4f64.powf(i as f64 / radial as f64);
                let angle = std::f64::consts::FRAC_PI_2 * j as f64 / around as f64;
                // exact zeros on the planes that are held
                let x = if j == around { 0.0 } else { r * angle.cos() };
                let y = if j == 0 { 0.0 } else { r * angle.sin() };
                let _ = writeln!(nodes, "{} {x} {y} {}", node(i, j, k), 0.2 * k as f64);
            }
        }
    }
    let (mut list, mut n) = (String::new(), 0);
    let mut add = |kind: usize, group: usize, corners: &[usize]| {
        n += 1;
        let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
        let _ = writeln!(list, "{n} {kind} 2 {group} {group} {}", corners.join(" "));
    };
    for j in 0..around {
        for (i, group) in [(0, 1), (radial, 2)] {
            add(
                3,
                group,
                &[
                    node(i, j, 0),
                    node(i, j + 1, 0),
                    node(i, j + 1, 1),
                    node(i, j, 1),
                ],
            );
        }
        for i in 0..radial {
            let square = |k: usize| {
                [
                    node(i, j, k),
                    node(i + 1, j, k),
                    node(i + 1, j + 1, k),
                    node(i, j + 1, k),
                ]
            };
            add(3, 5, &square(0));
            add(3, 6, &square(1));
            add(5, 7, &[square(0), square(1)].concat());
        }
    }
    for i in 0..radial {
        for (j, group) in [(0, 3), (around, 4)] {
            add(
                3,
                group,
                &[
                    node(i, j, 0),
                    node(i + 1, j, 0),
                    node(i + 1, j, 1),
                    node(i, j, 1),
                ],
            );
        }
    }
    let names = ["inner", "outer", "below", "left", "back", "front"];
    let mut groups = String::from("7\n");
    for (k, name) in names.iter().enumerate() {
        let _ = writeln!(groups, "2 {} \"{name}\"", k + 1);
    }
    groups += "3 7 \"salt\"\n";
    format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{groups}$EndPhysicalNames\n$Nodes\n{count}\n{nodes}$EndNodes\n\
         $Elements\n{n}\n{list}$EndElements\n"
    )
}

#[test]
fn a_cavity_under_pressure_widens_for_ever() {
    // u_r = p a²/2r (1/G + t/η), σ as at the start: nothing but shear, whatever ν
    let name = format!("fracas-creep-ring-{}.msh", std::process::id());
    let path = std::env::temp_dir().join(name);
    let mut errors = Vec::new();
    for (radial, around) in [(8, 6), (16, 12)] {
        std::fs::write(&path, ring(radial, around)).unwrap();
        let mut toml = format!(
            "title = 'Cavity'\n[mesh]\nfile = '{}'\n[[material]]\nname = 'salt'\nyoung = '10 GPa'\npoisson = 0.25\nvolume = 'salt'\n\
             viscosity = '{ETA} Pa*s'\n[time]\nend = '{} s'\nsteps = 8\n\
             [[boundary]]\nsurface = 'inner'\npressure = '8 MPa'\n[[boundary]]\nsurface = 'outer'\npressure = '0.5 MPa'\n",
            path.display(),
            8.0 * 0.5 * TAU
        );
        for plane in ["below", "left", "back", "front"] {
            let _ = writeln!(toml, "[[boundary]]\nsurface = '{plane}'\nhold = 'roller'");
        }
        let body = body(&toml);
        let (states, _) = run(&body);
        let simulation = Simulation::new(&body).unwrap();
        let worst = |state: &State| {
            let u = simulation.displacement(state);
            let flowed = 1.0 / SHEAR + state.time / ETA;
            let at = |(x, u): (&[f64; 3], &[f64])| {
                let r = x[0].hypot(x[1]);
                let exact = 8e6 / (2.0 * r) * flowed;
                let radial = (u[0] * x[0] + u[1] * x[1]) / r;
                (radial - exact).abs() / (8e6 / 2.0 * flowed)
            };
            let nodes = body.mesh.nodes.iter().zip(u.chunks_exact(3));
            nodes.map(at).fold(0.0, f64::max)
        };
        errors.push(states[1..].iter().map(worst).fold(0.0, f64::max));
    }
    std::fs::remove_file(&path).unwrap();
    println!("errors of the cavity {errors:?}");
    assert!(errors[1] < 0.01, "{errors:?}");
    assert!(
        errors[0] / errors[1] > 3.0,
        "order 2 in the cells: {errors:?}"
    );
}
