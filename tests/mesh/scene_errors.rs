//! Claim: whatever is wrong with a scene is said with its place, what it is, and what to do.

use fracas::scene::{Body, Pull, Scene, SceneError, named};
use proptest::prelude::*;

const SCENE: &str = r#"title = "Two blocks"

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

[[boundary]]
side = "x-"
hold = "fixed"
"#;

/// The message for the scene with one piece of text replaced, reading and building.
fn refused(from: &str, to: &str) -> String {
    assert!(SCENE.contains(from), "{from}");
    let text = SCENE.replacen(from, to, 1);
    match Scene::from_toml(&text, "s.toml").and_then(|s| s.build()) {
        Ok(_) => panic!("accepted {to}"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn the_scene_itself_is_fine() {
    let body = Scene::from_toml(SCENE, "s.toml").unwrap().build().unwrap();
    assert_eq!(body.mesh.nodes.len(), 5 * 9 + 9);
    assert_eq!(
        body.constraints.full_len() - body.constraints.free_len(),
        27
    );
}

#[test]
fn unknown_keys_and_values_get_their_nearest_match_and_their_line() {
    assert_eq!(
        refused("cells = 4", "cels = 4"),
        "s.toml:4:33: unknown key `cels`, did you mean `cells`?; known here: from, to, cells, ratio, toward, size, growth, largest, near, fine, through, lines\n  |\n4 | x = { from = \"0 m\", to = \"4 m\", cels = 4 }\n  |                                 ^^^^"
    );
    let text = refused("hold = \"fixed\"", "hold = \"roler\"");
    assert!(
        text.starts_with("s.toml:20:8: unknown value `roler`, did you mean `roller`?; known here: roller, fixed\n"),
        "{text}"
    );
    let solver = |racp: &str| {
        let section = format!("[solver]\nracp = {racp}\n\n[[boundary]]");
        refused("[[boundary]]", &section)
    };
    let text = solver("{ inner = { geometric = { degre = 2 } } }");
    assert!(
        text.contains("unknown key `degre`, did you mean `degree`?"),
        "{text}"
    );
    let text = solver("{ inner = { geometrc = {} } }");
    assert!(text.contains("did you mean `geometric`?"), "{text}");
    let text = solver("{ inner = { ssor = { omega = 3 } } }");
    assert!(text.contains("omega = 3: expected"), "{text}");
    let text = refused("[[boundary]]", "[[boundry]]");
    assert!(
        text.contains("unknown key `boundry`, did you mean `boundary`?"),
        "{text}"
    );
    let text = refused("side = \"x-\"", "side = \"xx-\"");
    assert!(text.contains("did you mean `x-`?"), "{text}");
    assert!(
        refused("side = \"x-\"", "side = \"left\"")
            .contains("unknown value `left`; known here: x-, x+,")
    );
}

#[test]
fn values_are_checked_where_they_are_written() {
    for (from, to, start) in [
        (
            "\"25 GPa\"",
            "\"25 Gpa\"",
            "s.toml:10:9: \"25 Gpa\": unknown unit \"Gpa\"; nearest known units: GPa, Pa, kPa",
        ),
        (
            "\"25 GPa\"",
            "\"25 m\"",
            "s.toml:10:9: \"25 m\" has the unit \"m\" (m), expected Young's modulus (Pa), e.g. in Pa, MPa, GPa",
        ),
        (
            "\"25 GPa\"",
            "\"-25 GPa\"",
            "s.toml:10:9: Young's modulus is \"-25 GPa\", but it must be positive",
        ),
        (
            "\"25 GPa\"",
            "25e9",
            "s.toml:10:9: \"2.5e10\" has no unit, expected Young's modulus",
        ),
        (
            "0.25",
            "0.5",
            "s.toml:11:11: Poisson's ratio is \"0.5\", but it must be between -1 and 0.5, both excluded",
        ),
        ("0.25", "nan", "s.toml:11:11: "),
        ("cells = 4", "cells = 0", "s.toml:4:41: "),
        ("cells = 4", "cells = -1", "s.toml:4:41: "),
        (
            "at = \"2 m\"",
            "at = [\"2 m\", \"3 kg\"]",
            "s.toml:16:14: \"3 kg\" has the unit",
        ),
    ] {
        let text = refused(from, to);
        assert!(text.starts_with(start), "{text}");
        assert!(text.contains('^'), "{text}");
    }
    assert!(refused("title = \"Two blocks\"", "").contains("missing field `title`"));
    assert!(refused("plane = \"x\"", "plane = \"x").starts_with("s.toml:15:"));
}

#[test]
fn sections_that_make_no_sense_are_refused_with_their_line() {
    for (from, to, start) in [
        (
            "at = \"2 m\"",
            "at = \"2.5 m\"",
            "s.toml:16:6: fracture \"F\": x = 2.5 m is not a grid line; the nearest are 2 m and 3 m\n",
        ),
        (
            "at = \"2 m\"",
            "at = \"9 m\"",
            "s.toml:16:6: fracture \"F\" leaves the box: x = 9 m is outside [0 m, 4 m]\n",
        ),
        (
            "at = \"2 m\"",
            "at = \"0 m\"",
            "s.toml:16:6: fracture \"F\" lies on the boundary x = 0 m",
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\ny = [\"1 m\", \"1 m\"]",
            "s.toml:17:5: fracture \"F\" selects no face: its span in y from 1 m to 1 m is empty\n",
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\nx = [\"0 m\", \"1 m\"]",
            "s.toml:17:5: fracture \"F\" has the plane x, so it cannot have a span in x",
        ),
        (
            "at = \"2 m\"",
            "at = [\"2 m\", \"2 m\"]",
            "s.toml:13:1: fractures \"F_1\" and \"F_2\" share the face at (2.000000, 0.500000, 0.500000) m",
        ),
        (
            "at = \"2 m\"",
            "at = []",
            "s.toml:16:6: fracture \"F\" selects nothing: `at` is an empty list",
        ),
        (
            "x = { from = \"0 m\", to = \"4 m\", cells = 4 }",
            "x = { from = \"0 m\", to = \"4 m\", cells = 4000000000 }",
            "s.toml:3:2: 36000000009 nodes are more than 536870911",
        ),
        (
            "at = \"2 m\"",
            "every = 7",
            "s.toml:13:1: fracture \"F\" selects nothing: no interior grid line in x is a multiple of `every = 7`\n",
        ),
        (
            "at = \"2 m\"",
            "",
            "s.toml:13:1: fracture \"F\" needs exactly one of `at`, `every`; it has 0\n",
        ),
        (
            "to = \"4 m\"",
            "to = \"-4 m\"",
            "s.toml:4:1: axis x: from 0 m to -4 m is empty",
        ),
        (
            "to = \"4 m\", ",
            "",
            "s.toml:4:1: [mesh.x] needs `from`, `to` and `cells`, or `from`, `to`, `size`, `growth` and `near` or `fine`, or `lines` alone\n",
        ),
        (
            "cells = 4",
            "cells = 4, toward = \"1 m\"",
            "s.toml:4:53: axis x: grading ratio 1 cannot be met with 4 cells; `toward` needs a `ratio`",
        ),
        (
            "cells = 4",
            "size = \"1 m\", growth = 1.2",
            "s.toml:4:1: [mesh.x] needs `from`, `to` and `cells`, or `from`, `to`, `size`, `growth` and `near` or `fine`",
        ),
        (
            "cells = 4",
            "size = \"1 m\", growth = 1.2, near = \"5 m\"",
            "s.toml:4:1: axis x: near is 5; it must be inside the axis",
        ),
        (
            "cells = 4",
            "size = \"1e-9 m\", growth = 1, near = \"0 m\"",
            "s.toml:3:2: 36000000009 nodes are more than 536870911",
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\nlayers = [[\"5 m\", \"6 m\"]]",
            "s.toml:8:1: ",
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\nlayers = [[\"1 m\", \"0 m\"]]",
            "s.toml:12:11: layer 1 of material \"rock\" from 1 m to 0 m is empty; write the lower end first\n",
        ),
        (
            "[[fracture]]",
            "[[material]]\nname = \"rock\"\nyoung = \"1 Pa\"\npoisson = 0\n[[fracture]]",
            "s.toml:14:8: two materials are named \"rock\"; names must differ\n",
        ),
        (
            "hold = \"fixed\"",
            "hold = \"fixed\"\npressure = \"1 Pa\"",
            "s.toml:18:1: [[boundary]] of side x- needs exactly one of `hold`, `displacement`, `traction`, `pressure`; it has 2\n",
        ),
        (
            "hold = \"fixed\"",
            "displacement = {}",
            "s.toml:20:1: the displacement of x- has no component; give `x`, `y` or `z`\n",
        ),
        (
            "[[material]]",
            "[mesh.map.distort]\namplitude = 0.9\n[[material]]",
            "s.toml:8:",
        ),
        (
            "[[material]]",
            "[mesh.map.incline]\nplane = \"x\"\ndip = \"5 deg\"\nfade = true\n[[material]]",
            "s.toml:8:",
        ),
        (
            "[[material]]",
            "[mesh.map.incline]\nplane = \"x\"\n[[material]]",
            "s.toml:8:",
        ),
        (
            "[[material]]",
            "[mesh.map.incline]\nplane = \"x\"\nalong = \"y\"\ndip = \"60 deg\"\n[[material]]",
            "s.toml:11:7: `dip` needs `along = \"z\"`",
        ),
    ] {
        let text = refused(from, to);
        assert!(text.starts_with(start), "{text}");
    }
}

#[test]
fn a_roller_on_a_tilted_side_is_refused() {
    let text = SCENE
        .replace("hold = \"fixed\"", "hold = \"roller\"")
        .replace(
            "[[material]]",
            "[mesh.map.rotate]\naxis = \"z\"\nangle = \"10 deg\"\n[[material]]",
        );
    let error = Scene::from_toml(&text, "s.toml")
        .unwrap()
        .build()
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("a roller needs a side perpendicular to an axis, but after the maps the normal of x- is (-0.9848, -0.1736, 0.0000)"),
        "{error}"
    );
    // a quarter turn brings the side back onto an axis: y
    let quarter = text.replace("10 deg", "90 deg");
    let error = Scene::from_toml(&quarter, "s.toml")
        .unwrap()
        .build()
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("nothing is prescribed along x, z"),
        "{error}"
    );
}

#[test]
fn a_body_that_nothing_holds_is_named() {
    assert_eq!(
        refused("hold = \"fixed\"", "hold = \"roller\""),
        "body 0 (8 elements around (1.000000, 1.000000, 1.000000) m) is not held by its boundary, nor by closed fractures to a held body: 3 rigid motions are free, nothing is prescribed along y, z; hold it with a [[boundary]] (roller, fixed or displacement)"
    );
    assert!(
        refused("hold = \"fixed\"", "pressure = \"1 MPa\"")
            .contains("6 rigid motions are free, nothing is prescribed along x, y, z")
    );
    // an unfractured body
    let whole = SCENE.replace("hold = \"fixed\"", "traction = { x = \"1 Pa\" }");
    let whole = whole.replace(
        "[[fracture]]\nname = \"F\"\nplane = \"x\"\nat = \"2 m\"\n",
        "",
    );
    let error = Scene::from_toml(&whole, "s.toml")
        .unwrap()
        .build()
        .unwrap_err();
    assert!(
        matches!(
            error,
            SceneError::NotHeld {
                body: 0,
                free: 6,
                ..
            }
        ),
        "{error}"
    );
}

#[test]
fn overrides_reach_tables_lists_and_names() {
    let scene = Scene::from_toml(SCENE, "s.toml").unwrap();
    let set = |text: &str| scene.with_overrides(&[text]);
    assert_eq!(
        set("mesh.x.cells=8")
            .unwrap()
            .sections()
            .mesh
            .x
            .cells
            .unwrap()
            .get(),
        8
    );
    assert_eq!(
        set("material.rock.young=20 GPa")
            .unwrap()
            .sections()
            .material[0]
            .young
            .si(),
        20e9
    );
    assert_eq!(
        set("fracture.0.at = 1 m")
            .unwrap()
            .build()
            .unwrap()
            .fractures
            .faces[0]
            .center[0],
        1.0
    );
    assert!(
        set("mesh.map.distort.amplitude=0.1")
            .unwrap()
            .build()
            .is_ok()
    );
    let text = |t: &str| set(t).unwrap_err().to_string();
    assert_eq!(
        text("mesh.x.cells"),
        "override mesh.x.cells: write key=value, e.g. mesh.x.cells=8"
    );
    assert_eq!(
        text("material.salt.young=1 GPa"),
        "override material.salt.young=1 GPa: `salt` is not in `material`; there are: rock"
    );
    let unknown = text("mesh.x.cels=8");
    assert!(
        unknown.starts_with("s.toml with overrides:") && unknown.contains("did you mean `cells`?"),
        "{unknown}"
    );
    assert!(set("title.a=1").is_err());
    for (setting, refused) in [
        (
            "solver.rounds={ patience = 0 }",
            "patience = 0: expected a number from 1 to 1000000",
        ),
        (
            "solver.rounds={ loose = 1.0 }",
            "loose = 1: expected a number from",
        ),
    ] {
        let said = text(setting);
        assert!(said.contains(refused), "{said}");
    }
}

#[test]
fn loads_arrive_with_their_signs() {
    let text = format!(
        "{SCENE}\n[[boundary]]\nside = \"x+\"\npressure = \"2 MPa\"\n[[boundary]]\nside = \"z+\"\ntraction = {{ x = \"1 MPa\" }}\n[[boundary]]\nside = \"y+\"\ndisplacement = {{ z = \"-1 mm\" }}\n[gravity]\nz = \"-10 m/s^2\"\n[initial_stress]\nreference = \"2 m\"\nconstant = {{ zz = \"-1 MPa\" }}\ngradient = {{ zz = \"22 kPa/m\" }}\n"
    )
    .replace("poisson = 0.25", "poisson = 0.25\ndensity = \"2500 kg/m3\"");
    let body = Scene::from_toml(&text, "s.toml").unwrap().build().unwrap();
    assert_eq!(body.tractions.len(), 2);
    assert_eq!(body.tractions[0].pull, Pull::Pressure(2e6));
    assert_eq!(body.tractions[0].faces.len(), 4);
    assert_eq!(body.tractions[1].pull, Pull::Traction([1e6, 0.0, 0.0]));
    let pushes = body.inventory().pushes;
    for (push, traction) in pushes.iter().zip([[-2e6, 0.0, 0.0], [1e6, 0.0, 0.0]]) {
        let off = |i: usize| (push.traction[i] - traction[i]).abs();
        assert!((0..3).all(|i| off(i) < 1e-8), "{push:?}");
    }
    assert_eq!(body.body_force, [[0.0, 0.0, -25e3]]);
    assert_eq!(
        body.initial_stress.unwrap().at([0.0, 0.0, 1.0])[2],
        -1e6 - 22e3
    );
    let pushed =
        (0..body.constraints.full_len()).filter(|d| body.constraints.value(*d) == Some(-1e-3));
    assert_eq!(pushed.count(), 18); // 15 nodes of y+ and three copies
}

#[test]
fn the_schema_names_every_section() {
    let schema = serde_json::to_value(fracas::scene::schema()).unwrap();
    for key in [
        "title",
        "mesh",
        "material",
        "fracture",
        "boundary",
        "gravity",
        "initial_stress",
    ] {
        assert!(schema["properties"].get(key).is_some(), "{key}");
    }
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn a_missing_file_is_named() {
    let error = Scene::load("/nowhere/s.toml").unwrap_err().to_string();
    assert!(
        error.starts_with("cannot read /nowhere/s.toml: "),
        "{error}"
    );
    assert!(named("nothing").is_none());
}

proptest! {
    #[test]
    fn no_text_panics(at in 0..SCENE.len(), junk in "\\PC{0,6}") {
        let (head, tail) = SCENE.split_at(at);
        if let Err(error) = Scene::from_toml(&format!("{head}{junk}{tail}"), "s.toml").and_then(|s| s.build()) {
            prop_assert!(!error.to_string().is_empty());
        }
    }
}

#[test]
fn keys_that_would_change_nothing_are_refused() {
    for (from, to, place, sentence) in [
        (
            "poisson = 0.25",
            "poisson = 0.25\nbiot = 0.9",
            "s.toml:12:",
            "`biot` of material \"rock\" has no effect without `pressure_change`",
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\npressure_history = [[\"0 s\", 0], [\"1 s\", 1]]",
            "s.toml:12:",
            "`pressure_history` of material \"rock\" has no effect without `pressure_change`",
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\npressure_history = [[\"0 s\", 0], [\"1 s\", 1]]",
            "s.toml:17:",
            "`pressure_history` of fracture \"F\" has no effect without `pressure`",
        ),
        (
            "hold = \"fixed\"",
            "hold = \"fixed\"\nhistory = [[\"0 s\", 0], [\"1 s\", 1]]",
            "s.toml:21:",
            "`history` of x- has no effect beside `hold`",
        ),
    ] {
        let text = refused(from, to);
        assert!(text.starts_with(place) && text.contains(sentence), "{text}");
    }
}

#[test]
fn entries_that_a_list_has_no_place_for_are_refused() {
    let wanted = |wanted: usize, found: usize| {
        format!("a list of {wanted} entries was expected, this one has {found}\n")
    };
    for (from, to, place, sentence) in [
        (
            "hold = \"fixed\"",
            "pressure = \"1 MPa\"\nhistory = [[\"0 s\", 0, 9], [\"1 day\", 1, \"x\"]]",
            "s.toml:21:12: ",
            wanted(2, 3),
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\npressure_change = \"1 MPa\"\npressure_history = [[\"0 s\", 0, 3]]",
            "s.toml:13:21: ",
            wanted(2, 3),
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\npore_pressure = { points = [[\"0 s\", \"1 MPa\"], [\"1 day\", \"2 MPa\", \"oops\", 7]] }",
            "s.toml:12:47: ",
            wanted(2, 4),
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\nz = [\"0 m\", \"1 m\", \"junk\"]",
            "s.toml:17:5: ",
            wanted(2, 3),
        ),
        (
            "side = \"x-\"",
            "side = \"x-\"\nz = [\"0 m\", \"1 m\", 2]",
            "s.toml:20:5: ",
            wanted(2, 3),
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\nlayers = [['0 m', '1 m'], ['1 m', '2 m', 'x']]",
            "s.toml:12:27: ",
            wanted(2, 3),
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\nboxes = [{ y = ['0 m', '1 m', '2 m', '3 m'] }]",
            "s.toml:12:16: ",
            wanted(2, 4),
        ),
        (
            "cells = 2 }\nz",
            "size = \"1 m\", growth = 1.2, fine = [\"0 m\", \"1 m\", \"2 m\"] }\nz",
            "s.toml:5:68: ",
            wanted(2, 3),
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\nconductivity_along = { direction = [0, 0, 1, \"x\"], conductivity = \"1 m3\" }",
            "s.toml:17:36: ",
            wanted(3, 4),
        ),
        (
            "[[boundary]]",
            "[[source]]\nfracture = \"F\"\nat = [\"2 m\", \"1 m\", \"1 m\", \"2 m\"]\n[[boundary]]",
            "s.toml:20:6: ",
            wanted(3, 4),
        ),
    ] {
        let text = refused(from, to);
        assert!(text.starts_with(&(place.to_owned() + &sentence)), "{text}");
    }
    let scene = Scene::from_toml(SCENE, "s.toml").unwrap();
    let longer = scene.with_overrides(&["fracture.F.z=[\"0 m\", \"1 m\", 7]"]);
    let text = longer.unwrap_err().to_string();
    assert!(text.contains(&wanted(2, 3)), "{text}");
    let text = refused(
        "hold = \"fixed\"",
        "hold = \"fixed\"\n[solver]\nmax_cuts = -1",
    );
    let start = "s.toml:22:12: invalid value: integer `-1`, expected a whole number, 0 or more\n";
    assert!(text.starts_with(start), "{text}");
}

#[test]
fn factors_of_which_products_are_no_numbers_are_refused() {
    let time = "[time]\nend = \"2 s\"\nsteps = 2\n";
    let history = |factor: &str| format!("history = [[\"0 s\", 0], [\"1 s\", {factor}]]\n");
    let loaded = |factor: &str| {
        let pressure = format!("pressure = \"1 MPa\"\n{}", history(factor));
        let moved = format!("[[boundary]]\nside = \"x+\"\n{pressure}");
        built("", "", &(moved + time))
    };
    for factor in ["1e300", "-2e100"] {
        let text = loaded(factor).unwrap_err().to_string();
        let start = format!(
            "s.toml:24:32: the factor {factor} of a history is out of range: factors are at most 1e100 in size\n"
        );
        assert!(text.starts_with(&start), "{text}");
    }
    assert!(loaded("1e100").is_ok());
    assert!(loaded("1e-200").is_ok());
    let of_time = built("", "", &(time.to_owned() + &history("1e101")));
    let text = of_time.unwrap_err().to_string();
    assert!(text.starts_with("s.toml:24:32: the factor 1e101"), "{text}");
}

/// Builds the scene with a piece of text replaced and sections added.
fn built(from: &str, to: &str, more: &str) -> Result<Body, SceneError> {
    let text = SCENE.replacen(from, to, 1) + more;
    Scene::from_toml(&text, "s.toml").and_then(|scene| scene.build())
}

#[test]
fn gravity_needs_a_density_of_every_material() {
    let gravity = "[gravity]\nz = \"-9.81 m/s2\"\n";
    let weight = format!(
        "{gravity}[initial_stress]\nweight = {{ horizontal = [0.7, 0.8], fluid = \"1000 kg/m3\" }}\n"
    );
    for more in [gravity, &weight] {
        let text = built("", "", more).unwrap_err().to_string();
        let sentence = "s.toml:8:1: material \"rock\" has no `density`, by which [gravity] acts on it; give one, e.g. density = \"2500 kg/m3\"";
        assert!(text.starts_with(sentence), "{text}");
    }
    let rock = "poisson = 0.25\ndensity = \"0 kg/m3\"";
    assert!(built("poisson = 0.25", rock, gravity).is_ok());
    assert!(built("", "", "[gravity]\nz = \"0 m/s2\"\n").is_ok());
}

#[test]
fn tables_that_begin_after_the_run_are_refused() {
    let time = "[time]\nend = \"2 year\"\nsteps = 2\n";
    for (from, to, more, what) in [
        (
            "poisson = 0.25",
            "poisson = 0.25\npore_pressure = { points = [[\"FIRST year\", \"30 bar\"], [\"2020 year\", \"1 bar\"]] }",
            "",
            "`pore_pressure` of material \"rock\"",
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\npore_pressure = { points = [[\"FIRST year\", \"30 bar\"], [\"2020 year\", \"1 bar\"]], between = \"steps\" }",
            "",
            "`pore_pressure` of material \"rock\"",
        ),
        (
            "poisson = 0.25",
            "poisson = 0.25\npressure_change = \"1 MPa\"\npressure_history = [[\"FIRST year\", 0], [\"2020 year\", 1]]",
            "",
            "`pressure_history` of material \"rock\"",
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\npressure = \"1 MPa\"\npressure_history = [[\"FIRST year\", 0], [\"2020 year\", 1]]",
            "",
            "`pressure_history` of fracture \"F\"",
        ),
        (
            "",
            "",
            "[[boundary]]\nside = \"x+\"\npressure = \"1 MPa\"\nhistory = [[\"FIRST year\", 0], [\"2020 year\", 1]]\n",
            "`history` of x+",
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\nconductivity = \"1e-13 m3\"",
            "[fluid]\nviscosity = \"1 cP\"\n[[source]]\nfracture = \"F\"\nrate = \"1 L/s\"\nhistory = [[\"FIRST year\", 0], [\"2020 year\", 1]]\n",
            "`history` of [[source]] of fracture \"F\"",
        ),
        (
            "at = \"2 m\"",
            "at = \"2 m\"\nconductivity = \"1e-13 m3\"",
            "[fluid]\nviscosity = \"1 cP\"\n[[well]]\nname = \"W\"\nfrom = [\"1 m\", \"1.5 m\", \"1.5 m\"]\nto = [\"3 m\", \"1.5 m\", \"1.5 m\"]\nrate = \"1 L/s\"\nhistory = [[\"FIRST year\", 0], [\"2020 year\", 1]]\n",
            "`history` of [[well]] \"W\"",
        ),
        (
            "",
            "",
            "[[boundary]]\nside = \"x+\"\npressure = \"1 MPa\"\n[time]\nhistory = [[\"FIRST year\", 0], [\"2020 year\", 1]]\n",
            "`history` of [time]",
        ),
    ] {
        let tried = |first: &str| {
            let more = match more.contains("[time]") {
                true => more.replace("[time]\n", time),
                false => format!("{more}{time}"),
            };
            built(
                from,
                &to.replace("FIRST", first),
                &more.replace("FIRST", first),
            )
        };
        for late in ["1990", "2"] {
            let text = tried(late).err().map(|e| e.to_string()).unwrap_or_default();
            let sentence = format!("{what} begins at {late} year, and the run ends at 2 year");
            assert!(text.contains(&sentence), "{to}{more}: {text}");
        }
        // the end may lie within a table, and before what comes after its first row
        for early in ["0", "1.5"] {
            if let Err(error) = tried(early) {
                panic!("{to}{more}: {error}");
            }
        }
    }
    // a constant
    let single = "poisson = 0.25\npore_pressure = { points = [[\"1990 year\", \"30 bar\"]] }";
    assert!(built("poisson = 0.25", single, time).is_ok());
}

#[test]
fn loads_on_what_is_held_are_refused() {
    let held = "[[boundary]]\nside = \"x+\"\nhold = \"roller\"\n";
    let loaded = |load: &str| format!("{held}[[boundary]]\nside = \"x+\"\n{load}\n");
    for (load, key) in [
        ("pressure = \"1 MPa\"", "pressure"),
        ("traction = { x = \"1 MPa\" }", "traction"),
    ] {
        let text = built("", "", &loaded(load)).unwrap_err().to_string();
        let sentence =
            format!("`{key}` of x+ has no effect: the displacement along it is prescribed");
        assert!(text.contains(&sentence), "{text}");
    }
    for free in ["traction = { y = \"1 MPa\" }", "pressure = \"0 MPa\""] {
        assert!(built("", "", &loaded(free)).is_ok(), "{free}");
    }
}

#[test]
fn histories_that_vary_need_time() {
    let varying = "[[\"0 s\", 0], [\"1 s\", 1]]";
    for (from, to, place, what) in [
        (
            "poisson = 0.25",
            format!("poisson = 0.25\npressure_change = \"1 MPa\"\npressure_history = {varying}"),
            "s.toml:13:",
            "`pressure_history` of material \"rock\" varies",
        ),
        (
            "at = \"2 m\"",
            format!("at = \"2 m\"\npressure = \"1 MPa\"\npressure_history = {varying}"),
            "s.toml:18:",
            "`pressure_history` of fracture \"F\" varies",
        ),
        (
            "hold = \"fixed\"",
            format!(
                "hold = \"fixed\"\n[[boundary]]\nside = \"x+\"\npressure = \"1 MPa\"\nhistory = {varying}"
            ),
            "s.toml:24:",
            "`history` of x+ varies",
        ),
    ] {
        let text = refused(from, &to);
        assert!(text.starts_with(place) && text.contains(what), "{text}");
        assert!(text.contains("without [time]"), "{text}");
        let build = |text: &str| Scene::from_toml(text, "s.toml").and_then(|s| s.build());
        let scene = SCENE.replacen(from, &to, 1);
        let timed = format!("{scene}\n[time]\nend = \"2 s\"\nsteps = 2\n");
        assert!(build(&timed).is_ok(), "with [time]: {to}");
        let constant = scene.replace("\"0 s\", 0]", "\"0 s\", 1]");
        assert!(build(&constant).is_ok(), "a constant factor: {to}");
    }
}
