//! Claim: depletion slips a displaced frictionless fault by the trapezoid that is known exactly.
#![allow(clippy::unwrap_used)]

use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas_solvers::Silent;
use std::fmt::Write;

/// Half the width and height of the box [m].
const WIDTH: f64 = 4000.0;

/// Lines `0 < x ≤ end` whose spacing grows from h by a quarter each.
fn growing(start: f64, mut h: f64, end: f64) -> Vec<f64> {
    let (mut x, mut lines) = (start, Vec::new());
    while x + 1.75 * h < end {
        x += h;
        lines.push(x);
        h *= 1.25;
    }
    lines.push(end);
    lines
}

fn list(lines: &[f64]) -> String {
    let quoted: Vec<String> = lines.iter().map(|v| format!("'{v} m'")).collect();
    quoted.join(", ")
}

/// A vertical fault between reservoirs 225 m thick that are displaced by 75 m, `cells` of them per 75 m; depleted by 25 MPa.
fn scene(cells: usize) -> String {
    let h = 75.0 / cells as f64;
    let up = growing(225.0, 1.25 * h, WIDTH);
    let right = growing(0.0, h, WIDTH);
    let mirrored = |v: &[f64]| -> Vec<f64> { v.iter().rev().map(|x| -x).collect() };
    let core = (0..=6 * cells).map(|i| -225.0 + h * i as f64);
    let z: Vec<f64> = mirrored(&up).into_iter().chain(core).chain(up).collect();
    let x: Vec<f64> = mirrored(&right)
        .into_iter()
        .chain([0.0])
        .chain(right)
        .collect();
    let mut toml = format!(
        "title = 'Displaced fault'\n[mesh]\nx = {{ lines = [{}] }}\ny = {{ from = '0 m', to = '{} m', cells = 2 }}\nz = {{ lines = [{}] }}\n",
        list(&x),
        2.0 * h,
        list(&z)
    );
    let elastic = "young = '14.95 GPa'\npoisson = 0.15\n";
    let _ = writeln!(toml, "[[material]]\nname = 'rock'\n{elastic}");
    for (name, x, z) in [
        ("left", [-WIDTH, 0.0], [-150.0, 75.0]),
        ("right", [0.0, WIDTH], [-75.0, 150.0]),
    ] {
        let _ = writeln!(
            toml,
            "[[material]]\nname = '{name}'\n{elastic}boxes = [{{ x = [{}], z = [{}] }}]\npressure_change = '-25 MPa'\nbiot = 0.9",
            list(&x),
            list(&z)
        );
    }
    toml += "[[fracture]]\nname = 'fault'\nplane = 'x'\nat = '0 m'\nfriction_angle = '0 deg'\n";
    toml += "[initial_stress]\nconstant = { xx = '-60 MPa', yy = '-60 MPa', zz = '-60 MPa' }\n";
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        let _ = writeln!(toml, "[[boundary]]\nside = '{side}'\nhold = 'roller'");
    }
    toml + "[[boundary]]\nside = 'z+'\npressure = '60 MPa'\n"
}

#[test]
fn slip_is_the_known_trapezoid() {
    let body = Scene::from_toml(&scene(4), "fault.toml")
        .unwrap()
        .build()
        .unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let state = simulation
        .advance(&simulation.initial_state(), &mut Silent)
        .unwrap()
        .state;
    let fields = simulation.face_fields(&state);
    // |δ(z)| = ((1 − 2ν) α |Δp|/G) · clamp(b − |z|, 0, b − a), a = 75 m, b = 150 m
    let slope = (1.0 - 2.0 * 0.15) * 0.9 * 25e6 / 6.5e9;
    let (mut error, mut size, mut peak) = (0.0, 0.0, 0.0f64);
    for (face, slip) in body.fractures.faces.iter().zip(&fields.slip) {
        let exact = slope * (150.0 - face.center[2].abs()).clamp(0.0, 75.0);
        if face.center[2].abs() < 225.0 {
            error += face.area * (slip - exact).powi(2);
            size += face.area * exact.powi(2);
            peak = peak.max(*slip);
        }
    }
    // corners are rounded by half a cell, and the box is finite: 2.4 % and 1.6 % were measured
    assert!(
        (error / size).sqrt() < 0.04,
        "L2 error {:.4}",
        (error / size).sqrt()
    );
    assert!((peak - 0.181_731).abs() < 0.03 * 0.181_731, "peak {peak}");
    let open = fields
        .traction
        .iter()
        .step_by(3)
        .filter(|t| **t > -1e6)
        .count();
    assert_eq!(open, 0, "the fault stays closed");
}
