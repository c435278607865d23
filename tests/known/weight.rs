//! Claim: rock under its own weight, layer by layer, is at rest from the start.

use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas_operators::random::Random;
use fracas_solvers::Silent;

fn scene(more: &str) -> String {
    let mut toml = String::from(
        "title = 'Weight'\n[mesh]\nx = { from = '0 m', to = '900 m', cells = 3 }\ny = { from = '0 m', to = '100 m', cells = 2 }\n\
         z = { lines = ['-1000 m', '-700 m', '-450 m', '-200 m', '0 m'] }\n\
         [[material]]\nname = 'deep'\nyoung = '20 GPa'\npoisson = 0.2\ndensity = '2600 kg/m3'\n\
         [[material]]\nname = 'middle'\nyoung = '5 GPa'\npoisson = 0.3\ndensity = '2100 kg/m3'\nlayers = [['-700 m', '-200 m']]\n\
         [[material]]\nname = 'top'\nyoung = '1 GPa'\npoisson = 0.35\ndensity = '1800 kg/m3'\nlayers = [['-200 m', '0 m']]\n\
         [[fracture]]\nname = 'cut'\nplane = 'x'\nat = '300 m'\nz = ['-700 m', '-200 m']\nfriction_angle = '30 deg'\n\
         [gravity]\nz = '-10 m/s2'\n",
    );
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml + more
}

#[test]
fn layers_are_at_rest_under_their_weight() {
    for (fluid, density) in [("", 0.0), (", fluid = '1000 kg/m3'", 1000.0)] {
        let toml = scene(&format!(
            "[initial_stress]\nweight = {{ horizontal = [0.74, 0.83]{fluid} }}\n"
        ));
        let body = Scene::from_toml(&toml, "s.toml").unwrap().build().unwrap();
        // 200 m of 1800 and 440 m of 2100 above -640 m
        let expected = -10.0 * (200.0 * (1800.0 - density) + 440.0 * (2100.0 - density));
        let [xx, yy, zz, ..] = body.initial_stress_at(0, [1.0, 1.0, -640.0]);
        for (found, share) in [(xx, 0.74), (yy, 0.83), (zz, 1.0)] {
            assert!(
                (found - share * expected).abs() < 1e-9 * expected.abs(),
                "{found}"
            );
        }
        let mut simulation = Simulation::new(&body).unwrap();
        let start = simulation.initial_state();
        let state = simulation.advance(&start, &mut Silent).unwrap().state;
        let moved = state.u.iter().fold(0.0f64, |m, u| m.max(u.abs()));
        assert!(moved < 1e-9, "{moved} m");
        for (face, t) in body.fractures.faces.iter().zip(state.t.chunks_exact(3)) {
            let [xx, ..] = body.initial_stress_at(0, face.center);
            assert!((t[0] - xx).abs() < 1e-6 * xx.abs(), "{t:?} {xx}");
        }
    }
}

#[test]
fn weight_without_direction_is_refused() {
    let weight = "[initial_stress]\nweight = { horizontal = [0.74, 0.83] }\n";
    for toml in [
        scene(weight).replace("[gravity]\nz = '-10 m/s2'\n", ""),
        scene(weight).replace("z = '-10 m/s2'", "x = '1 m/s2'"),
    ] {
        let text = Scene::from_toml(&toml, "s.toml")
            .unwrap()
            .build()
            .unwrap_err()
            .to_string();
        assert!(
            text.contains("the initial stress of weight needs") && text.contains("s.toml:"),
            "{text}"
        );
    }
}

#[test]
fn rock_that_would_float_is_refused() {
    for seed in 0..20 {
        let r = &mut Random::new(seed);
        let fluid = r.between(500.0, 2900.0).round();
        let toml = scene(&format!(
            "[initial_stress]\nweight = {{ horizontal = [0.7, 0.8], fluid = '{fluid} kg/m3' }}\n"
        ));
        let built = Scene::from_toml(&toml, "s.toml").unwrap().build();
        // the lightest layer is the upper one, then the middle, and levels are met from the top down
        let light = [
            (1800.0, "-200 m and 0 m"),
            (2100.0, "-450 m and -200 m"),
            (2600.0, "-1000 m and -700 m"),
        ];
        match (built, light.iter().find(|(rock, _)| *rock < fluid)) {
            (Ok(_), None) => {}
            (Err(error), Some((rock, place))) => {
                let text = error.to_string();
                let expected = format!(
                    "between z = {place} the rock weighs {rock:.4} kg/m3 and the fluid {fluid} kg/m3"
                );
                assert!(text.contains(&expected), "{text}");
                assert!(text.contains("s.toml:"), "{text}");
            }
            (built, light) => panic!("seed {seed}: {light:?}, built {}", built.is_ok()),
        }
    }
}
