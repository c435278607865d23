//! Claim: fluid that flows in fractures opens them by the volume it brings, at the pressure that is known, and none is lost.

use crate::tips::fine_tips;
use fracas::analytic::{LineCrack, PennyCrack, Rock};
use fracas::contact::ContactState;
use fracas::io::{Checkpoints, Fingerprint, read_checkpoint};
use fracas::nonlinear::{Accepted, Simulation, State};
use fracas::scene::{Body, Scene, named};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

const ROCK: Rock = Rock {
    young: 25e9,
    poisson: 0.25,
};

/// All steps of a body.
fn run(body: &Body) -> (Vec<Accepted>, State) {
    let mut simulation = Simulation::new(body).unwrap();
    let mut state = simulation.initial_state();
    let mut steps = Vec::new();
    while !simulation.is_finished(&state) || state.step == 0 {
        let step = simulation.advance(&state, &mut Silent).unwrap();
        state = step.state.clone();
        steps.push(step);
    }
    (steps, state)
}

/// The scene `injection` of the gallery: what is pumped in stays in the fractures, comes back, and nothing is lost; a checkpoint goes on
/// with the same bits.
#[test]
fn what_is_pumped_into_crossing_fractures_stays_there_and_comes_back() {
    let scene = named("injection").unwrap().small_scene().unwrap();
    let body = scene.build().unwrap();
    let (steps, _) = run(&body);
    let rows: Vec<_> = steps.iter().filter_map(|s| s.flow).collect();
    let injected: f64 = rows.iter().map(|f| f.injected).sum();
    let (mut stored, mut most) = (0.0, 0.0f64);
    for flow in &rows {
        stored += flow.stored_opening + flow.stored_compression;
        most = most.max(stored);
        assert!(flow.error.abs() <= 1e-10 * injected, "{flow:?}");
    }
    assert!(
        (most - injected).abs() < 1e-9 * injected,
        "{most} of {injected}"
    );
    let out: f64 = rows.iter().map(|f| f.out).sum();
    assert!(out > 0.0 && (stored + out - injected).abs() < 1e-9 * injected);
    // both fractures have been open
    let opened = |fracture: u16| {
        let faces = || body.fractures.faces.iter().enumerate();
        steps.iter().any(|step| {
            let open = |f: usize| step.state.states[f] == ContactState::Open;
            faces().any(|(f, face)| face.fracture == fracture && open(f))
        })
    };
    assert!(opened(0), "nothing opened");
    println!(
        "open faces: {:?}",
        steps.iter().map(|s| s.record.faces[3]).collect::<Vec<_>>()
    );
    let newton: Vec<usize> = steps.iter().map(|s| s.record.newton_it).collect();
    println!("Newton: {newton:?}");

    let folder = std::env::temp_dir().join(format!("fracas-flow-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let fingerprint = Fingerprint::new(&body, "injection");
    let half = steps.len() / 2;
    let path = Checkpoints::new(folder.clone(), fingerprint)
        .save(&steps[half].state)
        .unwrap();
    let read = read_checkpoint(&path, fingerprint).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(read, steps[half].state);
    let again = Simulation::new(&body)
        .unwrap()
        .advance(&read, &mut Silent)
        .unwrap();
    assert_eq!(again.state, steps[half + 1].state);
    assert_eq!(again.flow, steps[half + 1].flow);
}

/// Two confined layers of 2 m and 3 m with a fracture between them, under 10 MPa.
fn layers(more: &str) -> Scene {
    let text = format!(
        r#"
title = "Confined layers"
[mesh]
x = {{ from = "0 m", to = "3 m", cells = 3 }}
y = {{ from = "0 m", to = "2 m", cells = 2 }}
z = {{ from = "0 m", to = "5 m", cells = 5 }}
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "F"
plane = "z"
at = "2 m"
friction_angle = "30 deg"
conductivity = "1e-13 m3"
[initial_stress]
constant = {{ xx = "-8 MPa", yy = "-8 MPa", zz = "-10 MPa" }}
[[boundary]]
side = "x-"
hold = "roller"
[[boundary]]
side = "x+"
hold = "roller"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "z-"
hold = "roller"
[[boundary]]
side = "z+"
hold = "roller"
[fluid]
viscosity = "1e-3 Pa*s"
{more}
"#
    );
    Scene::from_toml(&text, "layers.toml").unwrap()
}

#[test]
fn confined_layers_open_evenly_by_what_comes_in() {
    let (closing, length) = (10e6, 5.0);
    let confined = 25e9 * 0.75 / (1.25 * 0.5);
    // q per area grows for 4 s, then stays
    let rate = 1e-4;
    let volume = |t: f64| rate * if t < 4.0 { t * t / 8.0 } else { t - 2.0 };
    for (storage, sets) in [
        (0.0, vec![]),
        (1.5e-11, vec!["fracture.0.storage=1.5e-11 m/Pa"]),
    ] {
        let scene = layers(
            r#"
[[source]]
fracture = "F"
rate = "6e-4 m3/s"
history = [["0 s", 0], ["4 s", 1]]
[time]
end = "10 s"
steps = 10
"#,
        );
        let body = scene.with_overrides(&sets).unwrap().build().unwrap();
        let (steps, _) = run(&body);
        let mut opened = 0;
        for step in &steps[1..] {
            let (q, p) = (volume(step.record.time), &step.state.p);
            // closed until p = σ0, then g + s p = ∫q dt with p = σ0 + M_c g/L
            let gap = ((q - storage * closing) / (1.0 + storage * confined / length)).max(0.0);
            let expected = match gap > 0.0 {
                true => closing + confined * gap / length,
                false => q / storage,
            };
            opened += usize::from(gap > 0.0);
            let open = step.state.states.iter().all(|s| *s == ContactState::Open);
            assert_eq!(open, gap > 0.0, "at {} s", step.record.time);
            for p in p {
                assert!(
                    (p - expected).abs() < 1e-8 * expected,
                    "{}: {p} {expected}",
                    step.record.time
                );
            }
            let flow = step.flow.unwrap();
            assert!(
                (flow.stored_opening + flow.stored_compression - flow.injected).abs()
                    < 1e-10 * flow.injected
            );
            assert!(flow.error.abs() < 1e-10 * flow.injected, "{flow:?}");
        }
        assert!(opened >= 5, "{opened}");
    }
}

#[test]
fn a_fracture_gives_back_what_it_took_and_closes() {
    let mut random = Random::new(20_100);
    for seed in 0..20 {
        // what is left at the end is a rounding of either sign
        let rate = 3e-4 * (0.5 + random.unit());
        let conductivity = 1e-12 * 10f64.powf(random.unit() - 0.5);
        let scene = layers(&format!(
            r#"
[[source]]
fracture = "F"
at = ["0.5 m", "0.5 m", "2 m"]
rate = "{rate} m3/s"
history = [["0 s", 1], ["3 s", 1], ["3.5 s", 0], ["6 s", 0], ["6.5 s", -1], ["9.25 s", -1], ["9.75 s", 0]]
[time]
end = "10 s"
steps = 20
"#
        ));
        let sets = [format!("fracture.0.conductivity={conductivity} m3")];
        let body = scene.with_overrides(&sets).unwrap().build().unwrap();
        let (steps, _) = run(&body);
        let injected: f64 = steps
            .iter()
            .filter_map(|s| s.flow)
            .map(|f| f.injected)
            .sum();
        assert!((injected - rate * 3.25).abs() < 1e-12);
        let mut stored = 0.0;
        for step in &steps {
            let Some(flow) = step.flow else { continue };
            stored += flow.stored_opening;
            assert!(
                flow.error.abs() <= 1e-10 * injected,
                "{seed}: {:e} of {injected:e}",
                flow.error
            );
            assert!(stored > -1e-10 * injected, "{seed}: {stored:e}");
        }
        assert!(stored.abs() < 1e-9 * injected, "{seed}: {stored:e}");
    }
}

#[test]
fn more_than_a_closed_fracture_holds_cannot_be_taken_from_it() {
    let scene = layers(
        r#"
[[source]]
fracture = "F"
rate = "-1 L/s"
[time]
end = "1 s"
steps = 1
[solver]
max_cuts = 2
"#,
    );
    let body = scene.build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let start = simulation.initial_state();
    let state = simulation.advance(&start, &mut Silent).unwrap().state;
    let said = simulation
        .advance(&state, &mut Silent)
        .unwrap_err()
        .to_string();
    assert!(said.contains("\"F\"") && said.contains("storage"), "{said}");
}

/// A crack scene with cells of s²/2 at the tips that grow by e^s, without a pressure of its own, under 5 MPa all around.
fn crack(scene: &str, axes: &[&str], s: f64, rate: f64) -> Body {
    let toml = named(scene)
        .unwrap()
        .toml
        .replace("pressure = \"2 MPa\"", "conductivity = \"1e-9 m3\"");
    let name = if scene == "line_crack" {
        "crack"
    } else {
        "penny"
    };
    let more = format!(
        "\n[fluid]\nviscosity = \"1e-4 Pa*s\"\n[[source]]\nfracture = \"{name}\"\nrate = \"{rate} m3/s\"\nhistory = [[\"0 s\", 1]]\n\
         [time]\nend = \"1000 s\"\nsteps = 2\n[initial_stress]\nconstant = {{ xx = \"-5 MPa\", yy = \"-5 MPa\", zz = \"-5 MPa\" }}\n"
    );
    let scene = Scene::from_toml(&(toml + &more), "crack.toml").unwrap();
    scene
        .with_overrides(&fine_tips(axes, s))
        .unwrap()
        .build()
        .unwrap()
}

/// Relative error of the net pressure after both steps, and the largest difference of pressures.
fn net_pressure(body: &Body, exact: f64) -> f64 {
    let (steps, state) = run(body);
    let areas = body.fractures.faces.iter().map(|f| f.area);
    let whole: f64 = areas.clone().sum();
    let mean = state.p.iter().zip(areas).map(|(p, a)| p * a).sum::<f64>() / whole;
    for p in &state.p {
        assert!((p - mean).abs() < 1e-3 * mean, "{p} of {mean}");
    }
    assert!(
        steps
            .iter()
            .filter_map(|s| s.flow)
            .all(|f| f.error.abs() < 1e-10 * f.injected)
    );
    (mean - 5e6) / exact - 1.0
}

#[test]
fn a_line_crack_of_high_conductivity_has_the_pressure_of_its_volume() {
    let held = LineCrack {
        rock: ROCK,
        half_length: 1.0,
        pressure: 3e6,
    }
    .volume();
    let exact = LineCrack::of_volume(ROCK, 1.0, held).pressure;
    let errors = [0.42, 0.3].map(|s| {
        let body = crack("line_crack", &["x", "z"], s, 0.2 * held / 1000.0);
        net_pressure(&body, exact)
    });
    println!("line crack: {errors:.4?}");
    assert!(errors[1] > 0.0 && errors[1] < 0.051, "{errors:?}");
    assert!(errors[0] / errors[1] > 1.7, "{errors:?}");
}

#[test]
fn a_penny_crack_of_high_conductivity_has_the_pressure_of_its_volume() {
    let held = PennyCrack {
        rock: ROCK,
        radius: 1.0,
        pressure: 3e6,
    }
    .volume();
    let exact = PennyCrack::of_volume(ROCK, 1.0, held).pressure;
    let errors = [0.9, 0.6].map(|s| {
        // a quarter of it
        let body = crack("penny_crack", &["x", "y", "z"], s, 0.25 * held / 1000.0);
        net_pressure(&body, exact)
    });
    println!("penny crack: {errors:.4?}");
    assert!(errors[1] > 0.0 && errors[1] < 0.4, "{errors:?}");
    assert!(errors[0] / errors[1] > 1.5, "{errors:?}");
}

/// erf by its series, and by its continued fraction beyond 3.
fn erfc(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for k in 1..200 {
        term *= -x * x / f64::from(k);
        sum += term / (2.0 * f64::from(k) + 1.0);
    }
    1.0 - 2.0 / std::f64::consts::PI.sqrt() * sum
}

#[test]
fn pressure_diffuses_along_a_closed_fracture_with_storage() {
    // D = C/(μ s) = 0.5 m²/s along 20 m that the front does not cross
    let error = |cells: u32, steps: u32| {
        let scene = layers(
            r#"
[[source]]
fracture = "F"
edge = "x-"
pressure = "1 MPa"
[time]
end = "8 s"
steps = 8
history = [["0 s", 1]]
"#,
        );
        let sets = [
            "mesh.x.to=20 m".to_string(),
            format!("mesh.x.cells={cells}"),
            "mesh.y.cells=1".into(),
            "fracture.0.storage=2e-10 m/Pa".into(),
            format!("time.steps={steps}"),
        ];
        let body = scene.with_overrides(&sets).unwrap().build().unwrap();
        let (_, state) = run(&body);
        assert!(state.states.iter().all(|s| *s != ContactState::Open));
        let mut sum = 0.0;
        for (face, p) in body.fractures.faces.iter().zip(&state.p) {
            let exact = 1e6 * erfc(face.center[0] / (2.0 * (0.5f64 * 8.0).sqrt()));
            sum += face.area * ((p - exact) / 1e6).powi(2);
        }
        (sum / 40.0).sqrt()
    };
    let (coarse, fine) = (error(20, 8), error(80, 128));
    println!("diffusion: {coarse:.2e} {fine:.2e}");
    // half the cells and a quarter of the time step, twice
    assert!(fine < 1e-3 && coarse / fine > 10.0, "{coarse} {fine}");
}

/// A well through three faces of one fracture and a second one, by rate, with a limit, and by pressure.
#[test]
fn a_well_shares_its_rate_has_one_pressure_and_keeps_its_limit() {
    let held = r#"
[[source]]
fracture = "F"
edge = "x-"
pressure = "1 MPa"
[time]
end = "100 s"
steps = 2
history = [["0 s", 1]]
[[well]]
name = "W"
from = ["2.5 m", "0.5 m", "5 m"]
to = ["2.5 m", "0.5 m", "0 m"]
radius = "0.05 m"
"#;
    let run_with = |more: &str| {
        let scene = layers(&format!("{held}{more}\n"));
        let body = scene.build().unwrap();
        let (steps, state) = run(&body);
        (body, steps.last().unwrap().clone(), state)
    };
    let (body, by_rate, _) = run_with("rate = \"1e-7 m3/s\"");
    let (well, flow) = (&by_rate.wells[0], by_rate.flow.unwrap());
    assert!(
        (well.rate - 1e-7).abs() < 1e-19 && flow.injected > 0.0,
        "{well:?}"
    );
    // steady: what comes in by the well leaves through the edge
    assert!(
        (flow.injected - flow.out).abs() < 1e-9 * flow.injected,
        "{flow:?}"
    );
    let face = body.fluid.as_ref().unwrap().wells[0].cuts[0];
    let at = by_rate.state.p[face.0 as usize];
    // q = 2π C/μ (p_w − p)/ln(0.14 √2 h / r)
    let drop = 1e-7 * (0.14 * 2f64.sqrt() / 0.05).ln() / (std::f64::consts::TAU * 1e-10);
    assert!(
        (well.pressure - at - drop).abs() < 1e-6 * drop,
        "{well:?} {at} {drop}"
    );
    // the same by that pressure
    let (_, by_pressure, _) = run_with(&format!("pressure = \"{:?} Pa\"", well.pressure));
    assert!((by_pressure.wells[0].rate / 1e-7 - 1.0).abs() < 1e-6);
    // and with a limit halfway
    let limit = 0.5 * (1e6 + well.pressure);
    let (_, limited, _) = run_with(&format!("rate = \"1e-7 m3/s\"\nlimit = \"{limit:?} Pa\""));
    assert!((limited.wells[0].pressure / limit - 1.0).abs() < 1e-12);
    assert!(
        (limited.wells[0].rate / 0.5e-7 - 1.0).abs() < 1e-6,
        "{:?}",
        limited.wells
    );
    assert!(limited.flow.unwrap().error.abs() < 1e-12 * limited.flow.unwrap().injected);
}

#[test]
fn a_well_beside_the_fractures_and_other_slips_are_told() {
    let said = |well: &str| {
        let scene = layers(&format!(
            "[time]\nend = \"1 s\"\nsteps = 1\n[[well]]\nname = \"W\"\n{well}\n"
        ));
        match scene.build() {
            Ok(_) => panic!("accepted {well}"),
            Err(error) => error.to_string(),
        }
    };
    let line = "from = [\"2.5 m\", \"0.5 m\", \"5 m\"]\nto = [\"2.5 m\", \"0.5 m\", \"0 m\"]";
    for (well, words) in [
        (
            "from = [\"2.5 m\", \"0.5 m\", \"5 m\"]\nto = [\"2.5 m\", \"0.5 m\", \"3 m\"]\nrate = \"1 L/s\"".into(),
            &["cuts no fracture", "\"F\""][..],
        ),
        (format!("{line}\nrate = \"1 L/s\"\nradius = \"1 m\""), &["radius", "smaller"]),
        (format!("{line}\nrate = \"1 L/s\"\npressure = \"1 MPa\""), &["exactly one of"]),
        (format!("{line}\npressure = \"1 MPa\"\nlimit = \"1 MPa\""), &["`limit`"]),
    ] {
        let text = said(&well);
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
}
