//! Claim: a crack that holds a given volume of fluid does so at the pressure that is known, and stays closed below the stress
//! that closes it.

use crate::plane_strain::{pieces, solved};
use crate::tips::fine_tips;
use fracas::analytic::{LineCrack, PennyCrack, Rock};
use fracas::contact::ContactState;
use fracas::scene::{Body, named};

const ROCK: Rock = Rock {
    young: 25e9,
    poisson: 0.25,
};

/// Thickness of the scene of the line crack [m].
const THICKNESS: f64 = 0.2;

/// A crack scene with cells of s²/2 at the tips that grow by e^s, closed by a stress, opened by a pressure [Pa].
fn body(scene: &str, axes: &[&str], s: f64, closing: f64, pressure: f64) -> Body {
    let mut sets = fine_tips(axes, s);
    sets.push(format!("fracture.0.pressure={pressure} Pa"));
    for component in ["xx", "yy", "zz"] {
        sets.push(format!("initial_stress.constant.{component}=-{closing} Pa"));
    }
    sets.push("solver.tolerance=1e-11".into());
    let scene = named(scene).unwrap().scene().unwrap();
    scene.with_overrides(&sets).unwrap().build().unwrap()
}

/// Volume at a pressure that opens all of it.
fn volume(scene: &str, axes: &[&str], s: f64, closing: f64, pressure: f64) -> f64 {
    let body = body(scene, axes, s, closing, pressure);
    let faces = pieces(&body, &solved(&body), 0, [1.0, 0.0]);
    assert!(faces.iter().all(|p| p.state == ContactState::Open));
    faces.iter().map(|p| p.area * p.jump[0]).sum()
}

/// The pressure at which a crack holds a volume, by two secant steps from twice and four times the stress that closes it.
fn pressure_of(held: f64, closing: f64, volume: impl Fn(f64) -> f64) -> f64 {
    let (mut p0, mut p1) = (2.0 * closing, 4.0 * closing);
    let (mut v0, mut v1) = (volume(p0), volume(p1));
    for _ in 0..2 {
        let next = p1 + (held - v1) * (p1 - p0) / (v1 - v0);
        (p0, v0) = (p1, v1);
        (p1, v1) = (next, volume(next));
        if (v1 / held - 1.0).abs() < 1e-8 {
            return p1;
        }
    }
    panic!("no pressure holds {held}: {v1} at {p1} Pa");
}

#[test]
fn a_line_crack_holds_its_volume_at_the_known_pressure() {
    let closing = 5e6;
    // V per thickness that 3 MPa above the closing stress hold
    let held = LineCrack {
        rock: ROCK,
        half_length: 1.0,
        pressure: 3e6,
    }
    .volume();
    let errors = [0.42, 0.3].map(|s| {
        let at = |p| volume("line_crack", &["x", "z"], s, closing, p) / THICKNESS;
        let pressure = pressure_of(held, closing, at);
        let exact = LineCrack::of_volume(ROCK, 1.0, held).pressure;
        (pressure - closing) / exact - 1.0
    });
    println!("line crack, pressure at a volume: {errors:.4?}");
    // a conforming body is too stiff
    assert!(errors[1] > 0.0 && errors[1] < 0.051, "{errors:?}");
    assert!(errors[0] / errors[1] > 1.7, "{errors:?}");
}

#[test]
fn a_penny_crack_holds_its_volume_at_the_known_pressure() {
    let errors = [0.6, 0.42].map(|s| {
        // the scene is a quarter of the disc
        let found = 4.0 * volume("penny_crack", &["x", "y", "z"], s, 0.0, 2e6);
        2e6 / PennyCrack::of_volume(ROCK, 1.0, found).pressure - 1.0
    });
    println!("penny crack, pressure at a volume: {errors:.4?}");
    assert!(errors[1] > 0.0 && errors[1] < 0.155, "{errors:?}");
    assert!(errors[0] / errors[1] > 1.5, "{errors:?}");
}

#[test]
fn volume_is_proportional_to_the_pressure_above_the_closing_stress() {
    let at = |closing, p| volume("line_crack", &["x", "z"], 0.6, closing, p);
    let reference = at(0.0, 1e6);
    for (closing, p) in [(0.0, 2e6), (0.0, 1e3), (4e6, 5e6), (4e6, 4.1e6)] {
        let ratio = at(closing, p) / reference * 1e6 / (p - closing);
        assert!((ratio - 1.0).abs() < 1e-9, "{closing} {p}: {ratio}");
    }
}

#[test]
fn below_the_closing_stress_a_crack_stays_closed_and_carries_the_difference() {
    let body = body("line_crack", &["x", "z"], 0.6, 5e6, 4e6);
    for piece in pieces(&body, &solved(&body), 0, [1.0, 0.0]) {
        assert_eq!(piece.state, ContactState::Stick);
        let at = piece.middle();
        assert!((piece.traction[0] + 1e6).abs() < 1.0, "{at}: {piece:?}");
        assert!(piece.jump[0].abs() < 1e-12, "{at}: {piece:?}");
    }
}
