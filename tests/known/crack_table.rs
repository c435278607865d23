//! Claim: a closed crack slides as its closed form says for other angles, strengths and elastic constants, in one step or in
//! several, and not at all where friction holds it.

use crate::plane_strain::{Piece, pieces, solved};
use crate::tips::fine_tips;
use fracas::analytic::{InclinedCrack, Rock};
use fracas::contact::ContactState;
use fracas::scene::{Body, named};

/// A crack of 2 m at ψ to 100 MPa along z.
fn crack(inclination_deg: f64, friction_deg: f64, cohesion: f64) -> InclinedCrack {
    InclinedCrack {
        rock: Rock {
            young: 25e9,
            poisson: 0.25,
        },
        compression: 100e6,
        inclination: inclination_deg.to_radians(),
        friction_angle: friction_deg.to_radians(),
        cohesion,
        half_length: 1.0,
    }
}

/// Step of the meshes: cells of s²/2 at the tips that grow by e^s. Unit: 1.
const STEP: f64 = 0.3;

/// The scene of the gallery with that crack, leaning to `side` = ±1 of z.
fn body(exact: &InclinedCrack, side: f64, more: &[&str]) -> Body {
    let tip = exact.inclination.cos();
    let mut sets = vec![
        format!("mesh.z.near=['{} m', '{tip} m']", -tip),
        format!("fracture.crack.z=['{} m', '{tip} m']", -tip),
        format!(
            "mesh.map.incline.tilt={} deg",
            side * exact.inclination.to_degrees()
        ),
        format!(
            "fracture.crack.friction_angle={} deg",
            exact.friction_angle.to_degrees()
        ),
        format!("fracture.crack.cohesion={} Pa", exact.cohesion),
        format!("material.rock.young={} Pa", exact.rock.young),
        format!("material.rock.poisson={}", exact.rock.poisson),
    ];
    sets.extend(fine_tips(&["x", "z"], STEP));
    sets.extend(more.iter().map(|s| s.to_string()));
    let scene = named("inclined_crack").unwrap().scene().unwrap();
    scene.with_overrides(&sets).unwrap().build().unwrap()
}

fn found(exact: &InclinedCrack, side: f64, more: &[&str]) -> Vec<Piece> {
    let body = body(exact, side, more);
    let (sin, cos) = exact.inclination.sin_cos();
    let found = pieces(&body, &solved(&body), 0, [side * sin, cos]);
    let area: f64 = found.iter().map(|p| p.area).sum();
    assert!((area - 2.0 * 0.2).abs() < 1e-9, "2 m times 0.2 m: {area}");
    found
}

/// Largest relative errors of slip, normal and shear traction where |s| ≤ 0.8 b.
fn errors(exact: &InclinedCrack, side: f64, pieces: &[Piece]) -> [f64; 3] {
    // t_s = −σ n_z t_z = ∓σ sinψ cosψ, and the left side goes with it
    let sign = -side;
    let mut errors = [0.0f64; 3];
    for piece in pieces.iter().filter(|p| p.middle().abs() <= 0.8) {
        assert_eq!(piece.state, ContactState::Slip, "{piece:?}");
        let [from, to] = piece.span;
        let slip = sign * exact.mean_slip(from, to);
        for (k, (found, exact)) in [
            (piece.jump[1], slip),
            (piece.traction[0], exact.normal_traction()),
            (piece.traction[1], sign * exact.shear_limit()),
        ]
        .into_iter()
        .enumerate()
        {
            errors[k] = errors[k].max((found / exact - 1.0).abs());
        }
    }
    errors
}

#[test]
fn every_angle_and_strength_slides_as_its_closed_form() {
    // side, ψ [deg], θ [deg], c [Pa], ν; bounds of the errors of slip and tractions
    let table = [
        (1.0, 20.0, 10.0, 0.0, 0.25, 0.075, 0.025),
        (1.0, 20.0, 30.0, 5e6, 0.25, 0.07, 0.017),
        (1.0, 35.0, 10.0, 0.0, 0.25, 0.085, 0.026),
        (1.0, 35.0, 30.0, 0.0, 0.25, 0.073, 0.018),
        (-1.0, 20.0, 30.0, 0.0, 0.25, 0.068, 0.021),
        (1.0, 20.0, 30.0, 0.0, 0.0, 0.068, 0.015),
        (1.0, 20.0, 30.0, 0.0, 0.4, 0.09, 0.042),
    ];
    for (side, psi, theta, cohesion, poisson, slip, traction) in table {
        let mut exact = crack(psi, theta, cohesion);
        exact.rock.poisson = poisson;
        let errors = errors(&exact, side, &found(&exact, side, &[]));
        println!("{side} {psi} {theta} {cohesion} {poisson}: {errors:.4?}");
        assert!(
            errors[0] < slip,
            "{side} {psi} {theta} {cohesion} {poisson}: {errors:?}"
        );
        assert!(
            errors[1] < traction && errors[2] < traction,
            "{side} {psi} {theta} {cohesion} {poisson}: {errors:?}"
        );
    }
}

#[test]
fn a_crack_stronger_than_its_angle_sticks_and_shows_the_uniform_stress() {
    // tan 60° = 1.73 > cot 35° = 1.43
    let exact = crack(35.0, 60.0, 0.0);
    assert_eq!(exact.stress_drop(), 0.0);
    let peak = crack(35.0, 0.0, 0.0).peak_slip();
    for piece in found(&exact, 1.0, &[]) {
        assert_eq!(piece.state, ContactState::Stick);
        assert!(
            piece.jump.iter().all(|g| g.abs() < 1e-7 * peak),
            "{piece:?}"
        );
        let [normal, shear] = piece.traction;
        assert!((normal / exact.normal_traction() - 1.0).abs() < 1e-6);
        assert!((shear / -exact.far_shear() - 1.0).abs() < 1e-6);
    }
}

/// Largest difference of jumps and tractions, relative to the largest of each; `scale` multiplies the jumps of `b`.
fn difference(a: &[Piece], b: &[Piece], scale: f64) -> [f64; 2] {
    assert_eq!(a.len(), b.len(), "pieces");
    let (mut difference, mut size) = ([0.0f64; 2], [0.0f64; 2]);
    for (a, b) in a.iter().zip(b) {
        for k in 0..2 {
            for (m, (x, y)) in [
                (a.jump[k], scale * b.jump[k]),
                (a.traction[k], b.traction[k]),
            ]
            .into_iter()
            .enumerate()
            {
                difference[m] = difference[m].max((x - y).abs());
                size[m] = size[m].max(x.abs());
            }
        }
    }
    [0, 1].map(|m: usize| difference[m] / size[m])
}

#[test]
fn a_proportional_load_gives_one_answer_in_one_step_and_in_several() {
    let exact = crack(20.0, 30.0, 0.0);
    let at_once = found(&exact, 1.0, &[]);
    let sets = [
        "time.end=1 s",
        "time.history=[['0 s', 0.0], ['1 s', 1.0]]",
        "time.steps=3",
    ];
    let difference = difference(&at_once, &found(&exact, 1.0, &sets), 1.0);
    assert!(difference.iter().all(|d| *d < 2e-7), "{difference:?}");
}

#[test]
fn slip_is_inverse_to_the_stiffness_and_tractions_do_not_see_it() {
    let exact = crack(20.0, 30.0, 0.0);
    let reference = found(&exact, 1.0, &[]);
    for factor in [1e-3, 1e3] {
        let mut other = exact;
        other.rock.young *= factor;
        let difference = difference(&reference, &found(&other, 1.0, &[]), factor);
        assert!(difference.iter().all(|d| *d < 1e-8), "{difference:?}");
    }
}
