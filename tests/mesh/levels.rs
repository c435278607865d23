//! Claim: keys of a `profile` are linear between their own levels, and rows that make no sense are told.

use fracas::scene::{Body, Scene, SceneError};
use fracas_operators::random::Random;

/// A body of four cells in a row with three planes; the last one has keys of its own.
fn body(keys: &str) -> Result<Body, SceneError> {
    Scene::from_toml(&(before() + keys), "levels.toml")?.build()
}

/// What stands before the keys of the last plane.
fn before() -> String {
    let mut toml = String::from("title = 'levels'\n[mesh]\n");
    for (axis, cells) in [("x", 4), ("y", 1), ("z", 1)] {
        toml += &format!("{axis} = {{ from = '0 m', to = '4 m', cells = {cells} }}\n");
    }
    toml += "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n[[boundary]]\nside = 'z-'\nhold = 'fixed'\n";
    for x in 1..=2 {
        toml += &format!("[[fracture]]\nname = '{x}'\nplane = 'x'\nat = '{x} m'\n");
    }
    toml + "[[fracture]]\nname = 'F'\nplane = 'x'\nat = '3 m'\n"
}

/// Line of the keys that is underlined, from 1, what of it is, and what is said.
fn problem(keys: &str) -> (usize, String, String) {
    match body(keys) {
        Err(SceneError::Section { place, problem }) => {
            let line = place.line - before().lines().count();
            let underlined = place.excerpt.chars().skip(place.column - 1);
            let underlined = underlined.take(place.width).collect();
            (line, underlined, problem.to_string())
        }
        Err(other) => panic!("{other}"),
        Ok(body) => panic!("{:?}", body.friction),
    }
}

/// Claim: every key is linear between the rows that have it, and constant beyond them, whatever the other keys and the order.
#[test]
fn keys_are_linear_between_their_own_levels() {
    let mut random = Random::new(4);
    for _ in 0..200 {
        let mut z: Vec<f64> = (0..2 + random.below(4))
            .map(|_| -random.between(1.0, 3e3))
            .collect();
        z.sort_by(f64::total_cmp);
        if random.chance(0.5) {
            z.reverse();
        }
        let (mut rows, mut angles, mut cohesions) = (String::new(), Vec::new(), Vec::new());
        for z in &z {
            rows += &format!("{{ z = \"{z} m\"");
            let has = [random.chance(0.6), random.chance(0.6)];
            if has[0] || !has[1] {
                angles.push((*z, random.between(5.0, 40.0)));
                rows += &format!(", friction_angle = \"{} deg\"", angles[angles.len() - 1].1);
            }
            if has[1] {
                cohesions.push((*z, random.between(0.0, 9.0)));
                rows += &format!(", cohesion = \"{} MPa\"", cohesions[cohesions.len() - 1].1);
            }
            rows += " }, ";
        }
        let body = body(&format!("profile = [{rows}]")).unwrap();
        let found = body.friction[2].as_ref().unwrap();
        let linear = |rows: &mut Vec<(f64, f64)>, z: f64| {
            rows.sort_by(|a, b| a.0.total_cmp(&b.0));
            let clamped = z.clamp(rows[0].0, rows[rows.len() - 1].0);
            let pair = rows
                .windows(2)
                .find(|w| w[0].0 <= clamped && clamped <= w[1].0);
            pair.map_or(rows[0].1, |w| {
                w[0].1 + (clamped - w[0].0) / (w[1].0 - w[0].0) * (w[1].1 - w[0].1)
            })
        };
        for _ in 0..20 {
            let z = -random.between(0.0, 3.2e3);
            let at = found.at(z);
            if !angles.is_empty() {
                let expected = linear(&mut angles, z).to_radians();
                assert!((at.angle - expected).abs() < 1e-12, "{at:?} {expected}");
            }
            if !cohesions.is_empty() {
                let expected = 1e6 * linear(&mut cohesions, z);
                assert!((at.cohesion - expected).abs() < 1e-5, "{at:?} {expected}");
            }
        }
    }
}

#[test]
fn what_makes_no_sense_is_told_with_its_row() {
    let (line, underlined, said) = problem(
        "friction_angle = \"30 deg\"\nprofile = [{ z = \"0 m\", friction_angle = \"20 deg\" }]",
    );
    assert_eq!((line, &underlined[..]), (1, "\"30 deg\""));
    assert!(said.contains("`profile`"), "{said}");
    let row = |z: &str| format!("{{ z = \"{z}\", cohesion = \"1 MPa\" }}");
    for z in [["0 m", "-1 m", "-1 m"], ["0 m", "-2 m", "-1 m"]] {
        let rows: Vec<String> = z.iter().map(|z| row(z)).collect();
        let (line, underlined, said) = problem(&format!("profile = [\n{}]", rows.join(",\n")));
        assert_eq!((line, underlined), (4, row("-1 m")));
        assert!(said.contains("-1 m"), "{said}");
    }
    let (line, underlined, _) = problem("profile = []");
    assert_eq!((line, &underlined[..]), (1, "[]"));
    let (line, underlined, _) = problem("profile = [{ z = \"0 m\" }]");
    assert_eq!((line, &underlined[..]), (1, "{ z = \"0 m\" }"));
    let half = "profile = [{ z = \"0 m\", friction_angle = \"30 deg\", dynamic_friction_angle = \"10 deg\" }]";
    assert!(problem(half).2.contains("weakens only"));
    let (line, underlined, said) = problem("friction_angle = \"30 deg\"\nweakening_by = \"path\"");
    assert_eq!((line, &underlined[..]), (2, "\"path\""));
    assert!(
        said.contains("no effect without `dynamic_friction_angle`"),
        "{said}"
    );
    let still = "friction_angle = \"30 deg\"\ndynamic_friction_angle = \"10 deg\"\nprofile = [{ z = \"0 m\", weakening_distance = \"0 mm\" }, { z = \"1 m\", weakening_distance = \"2 mm\" }]";
    assert!(problem(still).2.contains("weakens only"));
}
