//! Claim: a crack between two unlike rocks, opened by pressure, has the opening that is known where the rocks do not make it slip.

use crate::plane_strain::{Piece, pieces, solved};
use crate::tips::fine_tips;
use fracas::analytic::{LineCrack, Rock};
use fracas::contact::ContactState;
use fracas::scene::Scene;

const PRESSURE: f64 = 2e6;

const UPPER: Rock = Rock {
    young: 25e9,
    poisson: 0.2,
};

/// The rock of this ν whose second Dundurs parameter against `rock` is 0: `G_1 (1 − 2ν_2) = G_2 (1 − 2ν_1)`.
///
/// Then the singularity at the tips does not oscillate, pressure makes no slip, and the opening is the mean of those in one rock:
/// `w(s) = 2p (c_1 + c_2) √(a² − s²)`, `c = (1 − ν²)/E` (J. R. Rice, J. Appl. Mech. 55 (1988) 98–103, equations for ε = 0).
fn without_slip(rock: Rock, poisson: f64) -> Rock {
    let shear = rock.shear() * (1.0 - 2.0 * poisson) / (1.0 - 2.0 * rock.poisson);
    Rock {
        young: 2.0 * (1.0 + poisson) * shear,
        poisson,
    }
}

/// The faces of the line crack with another rock below it; cells of s²/2 at the tips that grow by e^s.
fn crack(lower: Rock, s: f64) -> Vec<Piece> {
    let scene = include_str!("../../src/scene/gallery/line_crack.toml").replacen(
        "[[material]]\nname = \"rock\"\nyoung = \"25 GPa\"\npoisson = 0.25\n",
        &format!(
            "[[material]]\nname = \"upper\"\nyoung = \"{} Pa\"\npoisson = {}\n\n[[material]]\nname = \"lower\"\n\
             young = \"{} Pa\"\npoisson = {}\nlayers = [[\"-100 m\", \"0 m\"]]\n",
            UPPER.young, UPPER.poisson, lower.young, lower.poisson
        ),
        1,
    );
    assert!(scene.contains("lower"));
    let scene = Scene::from_toml(&scene, "scene.toml").unwrap();
    let body = scene
        .with_overrides(&fine_tips(&["x", "z"], s))
        .unwrap()
        .build()
        .unwrap();
    pieces(&body, &solved(&body), 0, [1.0, 0.0])
}

/// Error of the openings and largest slip, in the L2 norm over the known opening.
fn errors(faces: &[Piece], rocks: [Rock; 2]) -> [f64; 2] {
    let known = |p: &Piece| {
        let of = |rock| LineCrack {
            rock,
            half_length: 1.0,
            pressure: PRESSURE,
        };
        let [from, to] = p.span;
        rocks.map(|rock| 0.5 * of(rock).mean_opening(from, to))
    };
    let sum = |f: &dyn Fn(&Piece) -> f64| faces.iter().map(|p| p.area * f(p).powi(2)).sum::<f64>();
    let exact = |p: &Piece| known(p).iter().sum::<f64>();
    let scale = sum(&exact);
    [
        (sum(&|p| p.jump[0] - exact(p)) / scale).sqrt(),
        (sum(&|p| p.jump[1]) / scale).sqrt(),
    ]
}

#[test]
fn rocks_that_make_no_slip_open_as_the_mean_of_both() {
    // moduli of 1 : 5.0 and 1 : 24; trilinear elements are too stiff where ν nears ½
    for (poisson, bound) in [(0.45, 0.06), (0.49, 0.14)] {
        let lower = without_slip(UPPER, poisson);
        let [coarse, fine] = [0.42, 0.3].map(|s| {
            let faces = crack(lower, s);
            assert!(faces.iter().all(|p| p.state == ContactState::Open));
            let carried = faces.iter().flat_map(|p| p.traction.map(f64::abs));
            assert!(carried.fold(0.0, f64::max) < 1e-6 * PRESSURE);
            errors(&faces, [UPPER, lower])
        });
        println!(
            "E {:.3e} below, opening and slip: {coarse:.4?} {fine:.4?}",
            lower.young
        );
        assert!(fine[0] < bound && fine[1] < 0.02, "{poisson}: {fine:?}");
        assert!(coarse[0] / fine[0] > 1.5, "{poisson}: {coarse:?} {fine:?}");
    }
}

/// The same contrast with equal ν makes slip: what the test above finds small is there to be found.
#[test]
fn other_rocks_slip_under_pressure_alone() {
    let lower = Rock {
        young: without_slip(UPPER, 0.45).young,
        ..UPPER
    };
    let [_, slip] = errors(&crack(lower, 0.42), [UPPER, lower]);
    println!("slip over opening with equal ν: {slip:.4}");
    assert!(slip > 0.05, "{slip}");
}
