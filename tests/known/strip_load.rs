//! Claim: a load on a strip of the ground spreads with depth as in a half-space.

use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas_solvers::Silent;

/// Half-width of the strip [m], its pressure [Pa], and the depth of a plane below it [m].
const STRIP: (f64, f64, f64) = (1.0, 1e6, 1.5);

/// Pressure that holds the plane closed everywhere [Pa].
const START: f64 = 2e6;

/// σ_zz on the plane at x: `−(p/π) (α + sin α cos(α + 2δ))`, α the angle that the strip subtends and δ that of its nearer end with the
/// vertical [Pa].
///
/// # Source
/// H. G. Poulos, E. H. Davis, Elastic Solutions for Soil and Rock Mechanics, Wiley (1974), section 3.3 (after Carothers 1920).
fn vertical(x: f64) -> f64 {
    let (half, pressure, depth) = STRIP;
    let [far, near] = [x + half, x - half].map(|along| (along / depth).atan());
    let alpha = far - near;
    -pressure / std::f64::consts::PI * (alpha + alpha.sin() * (far + near).cos())
}

#[test]
fn a_strip_load_spreads_as_in_a_half_space() {
    let (half, pressure, depth) = STRIP;
    let axis = "size = '0.125 m', growth = 1.2";
    let scene = format!(
        "title = 'strip'\n[mesh]\n\
         x = {{ from = '-150 m', to = '150 m', {axis}, fine = ['-2 m', '2 m'] }}\n\
         y = {{ from = '0 m', to = '1 m', cells = 1 }}\n\
         z = {{ from = '-150 m', to = '0 m', {axis}, fine = ['-{depth} m', '0 m'] }}\n\
         [[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n\
         [[fracture]]\nname = 'plane'\nplane = 'z'\nat = '-{depth} m'\nfriction_angle = '30 deg'\ncohesion = '1 GPa'\n\
         [[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'x-'\nhold = 'roller'\n[[boundary]]\nside = 'x+'\nhold = 'roller'\n\
         [[boundary]]\nside = 'y-'\nhold = 'roller'\n[[boundary]]\nside = 'y+'\nhold = 'roller'\n\
         [[boundary]]\nside = 'z+'\npressure = '{START} Pa'\n\
         [initial_stress]\nconstant = {{ xx = '-{START} Pa', yy = '-{START} Pa', zz = '-{START} Pa' }}\n\
         [[boundary]]\nside = 'z+'\npressure = '{pressure} Pa'\nx = ['-{half} m', '{half} m']\n"
    );
    let scene = Scene::from_toml(&scene, "strip.toml").unwrap();
    let body = scene.build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let state = simulation.initial_state();
    let done = simulation.advance(&state, &mut Silent).unwrap();
    let mut compared = 0;
    for (f, face) in body.fractures.faces.iter().enumerate() {
        let x = face.center[0];
        if x.abs() > 2.0 {
            continue;
        }
        let (found, exact) = (done.state.t[3 * f] + START, vertical(x));
        assert!(
            (found - exact).abs() < 0.01 * pressure,
            "x = {x}: {found} {exact}"
        );
        compared += 1;
    }
    assert!(compared >= 30);
}
