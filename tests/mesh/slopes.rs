//! Claim: layers end in wedges, level fractures stay level between tops that climb, and what does not go with such tops is refused in a sentence.

use crate::geology::HELD;
use crate::tilted::{materials, volumes};
use fracas::elasticity::Elastic;
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, Remark, Scene};
use fracas_solvers::Silent;

const SMALL: &str = r#"title = "slopes"
[mesh]
x = { from = "-2 km", to = "2 km", size = "100 m" }
y = { from = "0 m", to = "100 m", cells = 1 }
z = { size = "50 m" }

[geology]
bottom = "-2 km"
layers = [
  { top = "0 m", material = "sand" },
  { top = { x = [["-2 km", "-450 m"], ["2 km", "-650 m"]] }, material = "clay" },
  { top = { x = [["-2 km", "-900 m"], ["2 km", "-1000 m"]] }, material = "rock" },
]

[[fracture]]
name = "fault"
plane = "x"
at = "300 m"
z = ["-1200 m", "-300 m"]
throw = "80 m"
friction_angle = "30 deg"
"#;

fn small(from: &str, to: &str) -> Result<(Scene, Body), String> {
    assert!(SMALL.contains(from), "{from}");
    let text = SMALL.replacen(from, to, 1) + &materials(&["sand", "clay", "rock"]) + HELD;
    let scene = Scene::from_toml(&text, "s.toml").map_err(|e| e.to_string())?;
    let body = scene.build().map_err(|e| e.to_string())?;
    Ok((scene, body))
}

#[test]
fn what_does_not_go_with_slopes_is_refused_with_its_line() {
    small("", "").unwrap();
    for (from, to, words) in [
        (
            "[\"2 km\", \"-650 m\"]",
            "[\"2 km\", \"-1100 m\"]",
            "s.toml:12:5: at x = 2000 m, y = 0 m the top of \"rock\" at -1000 m lies above the top of \"clay\" at -1100 m; tops may meet, where a layer ends, and not cross",
        ),
        (
            "[\"2 km\", \"-650 m\"]",
            "[\"-3 km\", \"-650 m\"]",
            "the points of the top of \"clay\" must increase along x: -3000 m comes after -2000 m",
        ),
        (
            "[\"2 km\", \"-650 m\"]",
            "[\"2 km\", \"-650 MPa\"]",
            "s.toml:11:",
        ),
        (
            "[\"2 km\", \"-650 m\"]",
            "[\"2 km\", \"nan\"]",
            "s.toml:11:",
        ),
        (
            "[\"2 km\", \"-650 m\"]",
            "[\"2 km\"]",
            "s.toml:11:5: the top of \"clay\" has to be a level, e.g. \"-1200 m\", or a surface:",
        ),
        (
            "{ x = [[\"-2 km\", \"-450 m\"], [\"2 km\", \"-650 m\"]] }",
            "{ x = [] }",
            "the top of \"clay\" has to be a level",
        ),
        (
            "{ x = [[\"-2 km\", \"-450 m\"], [\"2 km\", \"-650 m\"]] }",
            "{ x = [\"-2 km\", \"2 km\"], y = [\"0 m\", \"1 m\"], z = [[\"-450 m\", \"-450 m\"]] }",
            "`z` of the top of \"clay\" has 1 rows for 2 values of y; give a row per y",
        ),
        (
            "{ x = [[\"-2 km\", \"-450 m\"], [\"2 km\", \"-650 m\"]] }",
            "{ x = [\"-2 km\", \"2 km\"], y = [\"0 m\"], z = [[\"-450 m\"]] }",
            "row 1 of `z` of the top of \"clay\" has 1 heights for 2 values of x; give a height per x",
        ),
        (
            "{ x = [[\"-2 km\", \"-450 m\"]",
            "{ w = [[\"-2 km\", \"-450 m\"]",
            "s.toml:11:",
        ),
        (
            "bottom = \"-2 km\"",
            "bottom = \"-950 m\"",
            "s.toml:8:10: at x = 2000 m, y = 0 m `bottom` at -950 m lies above the top of \"rock\" at -1000 m",
        ),
        (
            "top = \"0 m\"",
            "top = { x = [[\"0 m\", \"-600 m\"], [\"1 km\", \"0 m\"]] }",
            "the top of \"clay\" at -450 m lies above the top of \"sand\" at -600 m",
        ),
        (
            "z = { size = \"50 m\" }",
            "z = { from = \"-2 km\", to = \"0 m\", cells = 20 }",
            "does not go with tops of [geology] that are not level",
        ),
        (
            "z = { size = \"50 m\" }",
            "z = { size = \"50 m\" }\nmap = { lift = [{ level = \"0 m\", to = \"1 m\" }] }",
            "[[mesh.map.lift]] does not go with tops",
        ),
        (
            "z = [\"-1200 m\", \"-300 m\"]",
            "z = [\"-1200 m\", \"100 m\"]",
            "s.toml:19:5: fracture \"fault\" leaves the box: z = 100 m is outside [-2000 m, 0 m]",
        ),
        (
            "throw = \"80 m\"",
            "throw = \"-600 m\"",
            "the throws of faults leave nothing of it",
        ),
        (
            "[[fracture]]",
            "[[fracture]]\nname = \"bed\"\nplane = \"z\"\nat = \"-550 m\"\n\n[[fracture]]",
            "cannot follow both",
        ),
    ] {
        let error = small(from, to).map(|_| ()).unwrap_err();
        assert!(error.contains(words), "{to}\n{error}");
        assert!(error.contains("s.toml:"), "{error}");
    }
    let drawdown = "pore_pressure = { drawdown = { diffusivity = '1e-7 m2/s', from = 'bottom', points = [['0 year', '30 bar'], ['1 year', '20 bar']] } }\n";
    let text = SMALL.to_owned()
        + &materials(&["sand", "rock", "clay"])
        + drawdown
        + "[time]\nend = '2 year'\nsteps = 2\n"
        + HELD;
    let error = Scene::from_toml(&text, "s.toml").unwrap_err().to_string();
    assert!(
        error.contains("`drawdown` of material \"clay\" does not go with tops"),
        "{error}"
    );
}

/// σ_v falls by the weight of the rock that a vertical line leaves, across throws of faults that dip, and begins at the ground.
#[test]
fn weight_is_that_of_the_rock_above_where_faults_dip_beside_slopes() {
    let weight =
        "[gravity]\nz = '-10 m/s2'\n[initial_stress]\nweight = { horizontal = [0.7, 0.8] }\n";
    for dip in ["70 deg", "110 deg"] {
        let text = SMALL.replacen("throw", &format!("dip = '{dip}'\nthrow"), 1)
            + &materials(&["sand", "clay", "rock"])
            + weight
            + HELD;
        let body = Scene::from_toml(&text, "s.toml").unwrap().build().unwrap();
        let at = |x: [f64; 3]| body.initial_stress_at(0, x)[2];
        let mut columns = 0;
        for (e, nodes) in body.mesh.elements.iter().enumerate() {
            let nodes = nodes.map(|a| body.mesh.nodes[a as usize]);
            let middle =
                |d: usize, of: [usize; 8]| of.map(|a| nodes[a][d]).iter().sum::<f64>() / 8.0;
            let [x, y, z] = [0, 1, 2].map(|d| middle(d, [0, 1, 2, 3, 4, 5, 6, 7]));
            let region = usize::from(body.mesh.regions[e]);
            let slope = at([x, y, z + 0.5]) - at([x, y, z - 0.5]);
            let own = body.body_force[region][2];
            assert!(
                (slope + own).abs() < 1e-6 * own.abs(),
                "{dip}, element {e}: {slope}"
            );
            if nodes[4][2].abs() < 1e-9 {
                let ground = at([x, y, -1e-3]);
                assert!((ground - 1e-3 * own).abs() < 1e-6, "{dip}: {ground}");
                columns += 1;
            }
        }
        assert!(columns >= 10, "{columns}");
    }
}

/// A level fracture stays level where tops climb below and above it.
#[test]
fn a_level_fracture_stays_level() {
    let bed = "[[fracture]]\nname = \"bed\"\nplane = \"z\"\nat = \"-800 m\"\nx = [\"-1 km\", \"0 m\"]\n\n[[fracture]]";
    let (_, body) = small("[[fracture]]", bed).unwrap();
    let mut area = 0.0;
    for face in body
        .fractures
        .faces
        .iter()
        .filter(|face| face.fracture == 0)
    {
        area += face.area;
        for a in face.plus.nodes {
            assert!((body.mesh.nodes[a as usize][2] + 800.0).abs() < 1e-9);
        }
    }
    assert!((area - 1e5).abs() < 1e-6, "{area}");
}

/// Rollers and a load on level ground: what climbs inside changes nothing where all rocks are alike, and a fault that sticks neither.
#[test]
fn alike_rocks_settle_as_one() {
    let text = SMALL.to_owned() + &materials(&["sand", "clay", "rock"]);
    let mut text = text.replacen("30 deg", "60 deg", 1);
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        text += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    text += "[[boundary]]\nside = 'z+'\npressure = '10 MPa'\n";
    let body = Scene::from_toml(&text, "s.toml").unwrap().build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let start = simulation.initial_state();
    let state = simulation.advance(&start, &mut Silent).unwrap().state;
    let u = simulation.displacement(&state);
    let strain = 10e6
        / Elastic {
            young: 10e9,
            poisson: 0.2,
        }
        .constrained();
    for (x, u) in body.mesh.nodes.iter().zip(u.chunks_exact(3)) {
        let expected = -strain * (x[2] + 2000.0);
        assert!(
            u[0].abs() < 1e-7 && (u[2] - expected).abs() < 1e-7,
            "{x:?} {u:?}"
        );
    }
}

/// A wedge keeps a tenth of its height on the grid, and its volume.
#[test]
fn a_layer_ends_in_a_wedge() {
    let wedge = |ends: &str, y: &str| {
        format!(
            "title = 'wedge'\n[mesh]\nx = {{ from = '-2 km', to = '2 km', size = '40 m' }}\ny = {{ {y} }}\nz = {{ size = '30 m' }}\n[geology]\nbottom = '-2 km'\n\
             layers = [{{ top = '0 m', material = 'a' }}, {{ top = '-500 m', material = 'b' }}, {{ top = {ends}, material = 'c' }}]\n{}{HELD}",
            materials(&["a", "b", "c"])
        )
    };
    let slab = "from = '0 m', to = '100 m', cells = 1";
    let block = "from = '0 m', to = '1 km', size = '50 m'";
    for (ends, y, expected, gone, close) in [
        // 300 m at one end, nothing at the other
        (
            "{ x = [['-2 km', '-800 m'], ['2 km', '-500 m']] }",
            slab,
            300.0 * 2000.0 * 100.0,
            0.025,
            2e-3,
        ),
        // nothing from the middle on
        (
            "{ x = [['-1 km', '-800 m'], ['0 m', '-500 m']] }",
            slab,
            (300.0 * 1000.0 + 150.0 * 1000.0) * 100.0,
            0.506,
            4e-3,
        ),
        // a saddle: nothing in two corners
        (
            "{ x = ['-2 km', '2 km'], y = ['0 m', '1 km'], z = [['-800 m', '-500 m'], ['-500 m', '-700 m']] }",
            block,
            125.0 * 4000.0 * 1000.0,
            0.0,
            4e-3,
        ),
    ] {
        let scene = Scene::from_toml(&wedge(ends, y), "w.toml").unwrap();
        let body = scene.build().unwrap();
        let found = volumes(&body);
        assert!(
            (found[1] / expected - 1.0).abs() < close,
            "{} {expected}",
            found[1]
        );
        // above it nothing has moved
        let above = 500.0 * found.iter().sum::<f64>() / 2000.0;
        assert!((found[0] / above - 1.0).abs() < 1e-12);
        let told = scene
            .geology()
            .unwrap()
            .remarks
            .iter()
            .find_map(|remark| match remark {
                Remark::Thin {
                    layer,
                    volume,
                    share,
                    ..
                } => Some((layer.clone(), *volume, *share)),
                _ => None,
            });
        let (layer, volume, share) = told.unwrap();
        assert_eq!(layer, "b");
        assert!(
            (volume - (found[1] / expected - 1.0)).abs() < 2e-4,
            "{volume} {found:?}"
        );
        assert!((share - gone).abs() < 0.011, "{share}");
        let text = scene.geology().unwrap().to_string();
        assert!(
            text.contains("layer \"b\" ends: the grid leaves it"),
            "{text}"
        );
        let again = Scene::from_toml(&scene.to_toml().unwrap(), "again.toml").unwrap();
        assert_eq!(again.build().unwrap().mesh, body.mesh);
    }
}

/// The example of the page is a scene.
#[test]
fn the_slopes_of_the_page_are_a_scene() {
    let page = include_str!("../../docs/scenes.md");
    let section = page.split("### Tops that are not level").nth(1).unwrap();
    let toml = section
        .split("```toml\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .unwrap();
    let text = format!(
        "title = 'page'\n{toml}{}{HELD}",
        materials(&["sand", "clay", "rock"])
    );
    let scene = Scene::from_toml(&text, "page.toml").unwrap();
    let body = scene.build().unwrap();
    assert!(volumes(&body).iter().all(|v| *v > 0.0));
    assert_eq!(
        scene.geology().unwrap().warnings().count(),
        0,
        "{}",
        scene.geology().unwrap()
    );
}
