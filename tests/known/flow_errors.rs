//! Claim: whatever is wrong with a fluid, or with what drives it, is said in one sentence with its place.

use fracas::nonlinear::{Failure, Simulation};
use fracas::scene::{Body, Scene};
use fracas_solvers::Silent;

const SCENE: &str = r#"title = "Fluid"

[mesh]
x = { from = "0 m", to = "4 m", cells = 4 }
y = { from = "0 m", to = "2 m", cells = 2 }
z = { from = "0 m", to = "2 m", cells = 2 }

[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25

[[fracture]]
name = "F"
plane = "x"
at = "2 m"
friction_angle = "30 deg"
conductivity = "1e-12 m3"

[fluid]
viscosity = "1 cP"

[[source]]
fracture = "F"
at = ["2 m", "0.5 m", "0.5 m"]
rate = "1 L/s"

[[source]]
fracture = "F"
edge = "z+"
pressure = "1 MPa"

[[boundary]]
side = "x-"
hold = "fixed"

[time]
end = "1 s"
steps = 1
"#;

fn built(text: &str) -> Result<Body, String> {
    let scene = Scene::from_toml(text, "s.toml").and_then(|s| s.build());
    scene.map_err(|error| error.to_string())
}

fn refused(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "{from}");
    match built(&SCENE.replacen(from, to, 1)) {
        Ok(_) => panic!("accepted {to}"),
        Err(text) => text,
    }
}

#[test]
fn the_scene_itself_is_fine() {
    let body = built(SCENE).unwrap();
    let fluid = body.fluid.as_ref().unwrap();
    assert!((fluid.viscosity - 1e-3).abs() < 1e-18 && fluid.channels[0].conductivity == 1e-12);
    assert_eq!(fluid.sources.len(), 2);
}

#[test]
fn a_conductivity_along_a_direction_is_read_with_that_across_it() {
    let along = "conductivity_along = { direction = [0.0, 3.0, 3.0], conductivity = \"4e-12 m3\" }";
    let text = SCENE.replace("\"1e-12 m3\"", &format!("\"1e-12 m3\"\n{along}"));
    let body = built(&text).unwrap();
    let channel = body.fluid.as_ref().unwrap().channels[0];
    assert!(
        (channel.conductivity / 2e-12 - 1.0).abs() < 1e-12,
        "geometric mean"
    );
    let directed = channel.directed.unwrap();
    assert!((directed.ratio - 4.0).abs() < 1e-12);
    assert!((directed.lies_in(&body.fractures.faces[0]) - 1.0).abs() < 1e-12);
}

#[test]
fn each_slip_has_its_sentence() {
    let place = "at = [\"2 m\", \"0.5 m\", \"0.5 m\"]";
    let fluid = "[fluid]\nviscosity = \"1 cP\"\n";
    for (from, to, said) in [
        ("\"1 cP\"", "\"-1 cP\"", &["viscosity", "positive"][..]),
        ("\"1 cP\"", "\"1 Pa\"", &["a viscosity", "Pa*s"]),
        (
            "\"1e-12 m3\"",
            "\"-1e-12 m3\"",
            &["conductivity", "positive"],
        ),
        ("\"1e-12 m3\"", "\"1e-12 m2\"", &["conductivity", "m3"]),
        ("\"1 L/s\"", "\"1 kg/s\"", &["a rate", "L/s"]),
        (
            "conductivity = \"1e-12 m3\"\n",
            "",
            &["fracture \"F\"", "needs `conductivity`"],
        ),
        (
            "\"1e-12 m3\"",
            "\"1e-12 m3\"\nconductivity_along = { direction = [1.0, 0.0, 0.0], conductivity = \"1e-10 m3\" }",
            &[
                "fracture \"F\"",
                "right angle",
                "(2.000000, 0.500000, 0.500000)",
            ],
        ),
        (
            "\"1e-12 m3\"",
            "\"1e-12 m3\"\nconductivity_along = { direction = [0.0, 0.0, 0.0], conductivity = \"1e-10 m3\" }",
            &["fracture \"F\"", "zero length"],
        ),
        (
            "conductivity = \"1e-12 m3\"",
            "conductivity_along = { direction = [0.0, 0.0, 1.0], conductivity = \"1e-10 m3\" }",
            &["fracture \"F\"", "needs `conductivity`"],
        ),
        (
            fluid,
            "",
            &["`conductivity`", "no effect without `[fluid]`"],
        ),
        (
            "\"0.5 m\"]",
            "\"3 m\"]",
            &[
                "no face of fracture \"F\"",
                "(2.000000, 0.500000, 3.000000)",
                "nearest face",
            ],
        ),
        ("[\"2 m\",", "[\"2.5 m\",", &["no face of fracture \"F\""]),
        ("edge = \"z+\"", "edge = \"x+\"", &["no outer edge", "x+"]),
        (
            "edge = \"z+\"",
            "",
            &["meets the rate", "number 1", "fracture \"F\""],
        ),
        (place, "edge = \"z-\"", &["a rate to an edge"]),
        (
            place,
            "at = [\"2 m\", \"0.5 m\", \"0.5 m\"]\nedge = \"z-\"",
            &["both `at` and `edge`"],
        ),
        (
            "rate = \"1 L/s\"",
            "rate = \"1 L/s\"\npressure = \"1 MPa\"",
            &["exactly one of `rate`, `pressure`"],
        ),
        (
            "[[source]]\nfracture = \"F\"",
            "[[source]]\nfracture = \"G\"",
            &["no fracture is named \"G\"", "F"],
        ),
        (
            "friction_angle",
            "pressure = \"1 MPa\"\nfriction_angle",
            &["`pressure`", "initial_pressure"],
        ),
        (
            fluid,
            "[fluid]\nviscosity = \"1 cP\"\ndensity = \"1000 kg/m3\"\n",
            &["`density`", "[gravity]"],
        ),
        (
            fluid,
            "[fluid]\nviscosity = \"1 cP\"\nreference = \"1 m\"\n",
            &["`reference`", "density"],
        ),
        (
            "[time]\nend = \"1 s\"\nsteps = 1\n",
            "",
            &["`rate`", "no effect without `[time]`"],
        ),
        ("viscosity", "viscosty", &["unknown key", "viscosity"]),
    ] {
        let text = refused(from, to);
        assert!(said.iter().all(|part| text.contains(part)), "{to}: {text}");
        assert!(text.starts_with("s.toml:"), "{text}");
    }
    let tilted = "poisson = 0.25\ndensity = \"2500 kg/m3\"\n[gravity]\nx = \"-1 m/s2\"\n";
    let heavy = SCENE.replace("poisson = 0.25\n", tilted);
    let heavy = heavy.replace(fluid, &format!("{fluid}density = \"1000 kg/m3\"\n"));
    let text = built(&heavy).unwrap_err();
    assert!(text.contains("[gravity] acts along z alone"), "{text}");
    let none = SCENE.split("[[fracture]]").next().unwrap();
    let rest = "[fluid]\nviscosity = \"1 cP\"\n[[boundary]]\nside = \"x-\"\nhold = \"fixed\"\n";
    assert!(
        built(&format!("{none}{rest}"))
            .unwrap_err()
            .contains("no fracture to flow in")
    );
}

#[test]
fn springs_and_flow_do_not_go_together() {
    let text = format!("{SCENE}\n[solver]\nmethod = {{ penalty = {{ factor = 1e3 }} }}\n");
    let body = built(&text).unwrap();
    let said = match Simulation::new(&body) {
        Ok(_) => panic!("accepted"),
        Err(error) => error.to_string(),
    };
    assert!(said.contains("lagrange"), "{said}");
}

/// More is withdrawn than there is, from closed and from open faces, incompressible or not: said as such whatever the steps.
#[test]
fn what_is_not_there_cannot_be_taken() {
    let whole = SCENE.replace("at = [\"2 m\", \"0.5 m\", \"0.5 m\"]\n", "");
    let (head, tail) = whole
        .split_once("[[source]]\nfracture = \"F\"\nedge")
        .unwrap();
    let (_, tail) = tail.split_once("[[boundary]]").unwrap();
    let sides = ["x+", "y-", "y+", "z-", "z+"];
    let rollers = sides.map(|side| format!("[[boundary]]\nside = \"{side}\"\nhold = \"roller\"\n"));
    let scene = format!("{head}[[boundary]]{tail}{}", rollers.concat());
    let stress =
        "[initial_stress]\nconstant = { xx = \"-3 MPa\", yy = \"-3 MPa\", zz = \"-3 MPa\" }\n";
    // more out than came in, and than the 0.9 L in which a compressible fluid is
    for (compressibility, out) in [("", -2), ("compressibility = \"1e-9 1/Pa\"\n", -40)] {
        let history = format!(
            "rate = \"0.1 L/s\"\nhistory = [[\"0 s\", 1], [\"0.4 s\", 1], [\"0.41 s\", {out}], [\"1 s\", {out}]]\n"
        );
        for steps in [1, 3, 10] {
            let text = scene
                .replace("rate = \"1 L/s\"\n", &history)
                .replace("steps = 1", &format!("steps = {steps}"))
                .replace("[[source]]", &format!("{stress}[[source]]"))
                .replace("\"1 cP\"\n", &format!("\"1 cP\"\n{compressibility}"));
            let body = built(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
            let mut simulation = Simulation::new(&body).unwrap();
            let mut state = simulation.initial_state();
            let reason = loop {
                assert!(
                    state.step == 0 || !simulation.is_finished(&state),
                    "finished\n{text}"
                );
                match simulation.advance(&state, &mut Silent) {
                    Ok(done) => state = done.state,
                    Err(failure) => break failure.reason,
                }
            };
            let is_said = match compressibility {
                "" => matches!(reason, Failure::Drained { .. }),
                _ => matches!(reason, Failure::Emptied { .. }),
            };
            assert!(is_said, "{reason}\n{text}");
        }
    }
}
