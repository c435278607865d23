//! Claim: cracks slide and open as their closed forms say, as well as a coarse mesh can, and better on a finer one.

use crate::tips::fine_tips;
use fracas::analytic::{InclinedCrack, LineCrack, PennyCrack, Rock};
use fracas::contact::ContactState;
use fracas::nonlinear::{FaceFields, Simulation, State};
use fracas::scene::{Body, Scene, named};
use fracas_solvers::Silent;

const ROCK: Rock = Rock {
    young: 25e9,
    poisson: 0.25,
};

fn inclined() -> InclinedCrack {
    InclinedCrack {
        rock: ROCK,
        compression: 100e6,
        inclination: 20f64.to_radians(),
        friction_angle: 30f64.to_radians(),
        cohesion: 0.0,
        half_length: 1.0,
    }
}

/// A crack scene with cells of s²/2 at the tips that grow by e^s.
fn body(scene: &str, axes: &[&str], s: f64) -> Body {
    let scene = named(scene).unwrap().scene().unwrap();
    let scene = scene.with_overrides(&fine_tips(axes, s)).unwrap();
    scene.build().unwrap()
}

fn equilibrium(body: &Body) -> (State, FaceFields) {
    let mut simulation = Simulation::new(body).unwrap();
    let state = simulation.run(&mut Silent, |_, _, _| ()).unwrap();
    let fields = simulation.face_fields(&state);
    (state, fields)
}

/// Positions of a face along a direction: its ends and its middle.
fn span(body: &Body, face: usize, along: [f64; 3]) -> [f64; 3] {
    let nodes = body.fractures.faces[face].minus.nodes;
    let at = nodes.map(|a| {
        let x = body.mesh.nodes[a as usize];
        (0..3).map(|d| x[d] * along[d]).sum::<f64>()
    });
    let low = at.into_iter().fold(f64::INFINITY, f64::min);
    let high = at.into_iter().fold(f64::NEG_INFINITY, f64::max);
    [low, high, 0.5 * (low + high)]
}

/// Largest relative errors of slip and normal traction where |s| ≤ 0.8 b, and the largest tension in excess of the exact t_N over the
/// drop of the shear.
fn inclined_errors(body: &Body) -> [f64; 3] {
    let (state, fields) = equilibrium(body);
    assert!(state.states.iter().all(|s| *s == ContactState::Slip));
    let exact = inclined();
    let (sin, cos) = exact.inclination.sin_cos();
    // slip in the middle = 4(1 − ν²) Δτ b/E
    let drop = exact.peak_slip() * 25e9 / (4.0 * (1.0 - 0.25 * 0.25));
    let mut errors = [0.0; 3];
    for f in 0..body.fractures.faces.len() {
        let [from, to, middle] = span(body, f, [sin, 0.0, cos]);
        assert!(from > -1.0 - 1e-9 && to < 1.0 + 1e-9);
        let tension = (fields.traction[3 * f] - exact.normal_traction()) / drop;
        errors[2] = tension.max(errors[2]);
        if middle.abs() > 0.8 {
            continue;
        }
        let slip = fields.slip[f] / exact.mean_slip(from, to) - 1.0;
        let normal = fields.traction[3 * f] / exact.normal_traction() - 1.0;
        errors = [
            slip.abs().max(errors[0]),
            normal.abs().max(errors[1]),
            errors[2],
        ];
    }
    errors
}

#[test]
fn an_inclined_crack_slides_as_its_closed_form() {
    let [coarse, fine] =
        [0.42, 0.3].map(|s| inclined_errors(&body("inclined_crack", &["x", "z"], s)));
    // second order: (0.42/0.3)² = 1.96
    assert!(
        fine[0] < 0.06 && coarse[0] / fine[0] > 1.5,
        "{coarse:?} {fine:?}"
    );
    assert!(
        fine[1] < 0.02 && coarse[1] / fine[1] > 1.4,
        "{coarse:?} {fine:?}"
    );
    // the cells on the two sides of a sheared grid are no mirror images: a share of the singular shear at the tips, K_II/√h, becomes
    // tension there, and opens the last faces where it passes the compression
    let growth = fine[2] / coarse[2];
    assert!(
        fine[2] > 0.1 && (growth - 0.42 / 0.3).abs() < 0.2,
        "{coarse:?} {fine:?}"
    );
}

/// The same crack on a grid that is turned instead of sheared, under initial stress instead of a load.
const TURNED: &str = r#"
title = "turned"

[mesh]
x = { from = "-40 m", to = "40 m", near = "0 m", size = "0.08 m", growth = 1.5 }
y = { from = "0 m", to = "0.2 m", cells = 2 }
z = { from = "-40 m", to = "40 m", near = ["-1 m", "1 m"], size = "0.08 m", growth = 1.5 }

[mesh.map.rotate]
axis = "y"
angle = "20 deg"
center = ["0 m", "0 m", "0 m"]

[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25

[[fracture]]
name = "crack"
plane = "x"
at = "0 m"
z = ["-1 m", "1 m"]
friction_angle = "30 deg"

[initial_stress]
constant = { zz = "-100 MPa" }

[[boundary]]
side = "x-"
hold = "fixed"

[[boundary]]
side = "x+"
hold = "fixed"

[[boundary]]
side = "z-"
hold = "fixed"

[[boundary]]
side = "z+"
hold = "fixed"

[[boundary]]
side = "y-"
hold = "roller"

[[boundary]]
side = "y+"
hold = "roller"
"#;

#[test]
fn on_a_grid_that_mirrors_itself_in_the_crack_the_normal_traction_is_exact() {
    let body = Scene::from_toml(TURNED, "turned.toml")
        .unwrap()
        .build()
        .unwrap();
    let [slip, normal, tension] = inclined_errors(&body);
    assert!(normal < 1e-6, "{normal:e}");
    assert!(tension < 1e-6, "{tension:e}");
    assert!(slip < 0.12, "{slip}");
}

/// Relative error of the opening of the face nearest to the middle, from below.
fn peak_error(body: &Body, exact: impl Fn(usize) -> f64) -> f64 {
    let (state, fields) = equilibrium(body);
    assert!(state.states.iter().all(|s| *s == ContactState::Open));
    assert!(
        fields.traction.iter().all(|t| t.abs() < 1.0),
        "open faces carry nothing"
    );
    let distance = |f: &usize| {
        let [x, y, _] = body.fractures.faces[*f].center;
        (x.hypot(y), *f)
    };
    let faces = 0..body.fractures.faces.len();
    let middle = faces.min_by(|a, b| distance(a).partial_cmp(&distance(b)).unwrap());
    let middle = middle.unwrap();
    1.0 - fields.aperture[middle] / exact(middle)
}

#[test]
fn a_line_crack_opens_as_its_closed_form() {
    let exact = LineCrack {
        rock: ROCK,
        half_length: 1.0,
        pressure: 2e6,
    };
    let [coarse, fine] = [0.42, 0.3].map(|s| {
        let body = body("line_crack", &["x", "z"], s);
        peak_error(&body, |f| {
            let [from, to, _] = span(&body, f, [1.0, 0.0, 0.0]);
            exact.mean_opening(from, to)
        })
    });
    // a conforming body is too stiff
    assert!(fine > 0.0 && fine < 0.035, "{fine}");
    assert!(coarse / fine > 1.5, "{coarse} {fine}");
}

#[test]
fn a_penny_crack_opens_as_its_closed_form() {
    let exact = PennyCrack {
        rock: ROCK,
        radius: 1.0,
        pressure: 2e6,
    };
    let [coarse, fine] = [0.6, 0.42].map(|s| {
        let body = body("penny_crack", &["x", "y", "z"], s);
        peak_error(&body, |f| {
            let [x, y, _] = body.fractures.faces[f].center;
            exact.opening(x.hypot(y))
        })
    });
    assert!(fine > 0.0 && fine < 0.09, "{fine}");
    assert!(coarse / fine > 1.5, "{coarse} {fine}");
}
