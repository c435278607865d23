//! Claim: a limit of pressure throttles a well down to nothing and never turns it round, in closed fractures and in those that the fluid
//! opens, whatever came before.

use fracas::contact::ContactState;
use fracas::mesh::FractureFace;
use fracas::nonlinear::{Accepted, Simulation};
use fracas::scene::{Body, Scene};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// How far a rate may be from one that is given, relative to the largest that is asked for. Unit: 1.
const RATE: f64 = 1e-7;

/// How far a pressure may be beyond a limit, relative to it. Unit: 1.
const PRESSURE: f64 = 1e-7;

/// Largest loss of a step over what was asked for and moved so far: faces that a well cuts are judged as far as the rounding of their fluxes
/// goes (seed 1021 has 5.8e-10). Unit: 1.
const LOSS: f64 = 1e-9;

/// All steps of a body, as far as they go, and why they end where they do.
fn run(body: &Body) -> (Vec<Accepted>, Option<String>) {
    let mut simulation = Simulation::new(body).unwrap();
    let mut state = simulation.initial_state();
    let mut steps: Vec<Accepted> = Vec::new();
    while !simulation.is_finished(&state) || state.step == 0 {
        match simulation.advance(&state, &mut Silent) {
            Ok(step) => {
                state = step.state.clone();
                steps.push(step);
            }
            Err(failure) => return (steps, Some(failure.to_string())),
        }
    }
    (steps, None)
}

/// A block of 4 m with a fracture across its middle, under 10 MPa.
fn block(fracture: &str, time: &str, more: &str) -> String {
    let mut toml = String::from("title = 'wells'\n[mesh]\n");
    for axis in ["x", "y", "z"] {
        toml += &format!("{axis} = {{ from = '0 m', to = '4 m', cells = 4 }}\n");
    }
    toml += "[[material]]\nname = 'rock'\nyoung = '25 GPa'\npoisson = 0.25\ndensity = '0 kg/m3'\n";
    toml += "[[fracture]]\nname = 'F'\nplane = 'z'\nat = '2 m'\nfriction_angle = '30 deg'\n";
    toml += &format!("{fracture}\n[fluid]\nviscosity = '1 cP'\n[time]\n{time}\n");
    toml += "[initial_stress]\nconstant = { xx = '-10 MPa', yy = '-10 MPa', zz = '-10 MPa' }\n";
    for side in ["x-", "x+", "y-", "y+", "z-", "z+"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml + more
}

fn well(name: &str, [x, y]: [f64; 2], more: &str) -> String {
    format!(
        "[[well]]\nname = '{name}'\nfrom = ['{x} m', '{y} m', '4 m']\nto = ['{x} m', '{y} m', '0 m']\nradius = '0.05 m'\n{more}\n"
    )
}

fn built(toml: &str) -> Body {
    Scene::from_toml(toml, "wells.toml")
        .unwrap()
        .build()
        .unwrap()
}

/// A well that meets its limit before the fracture opens brings nothing, as with a storage that goes to nothing.
#[test]
fn a_well_that_cannot_open_a_closed_fracture_stands_at_its_limit() {
    for rate in [1e-8, 1e-6, 1e-4] {
        for limit in [5e6, 9e6] {
            let control = format!("rate = '{rate} m3/s'\nlimit = '{limit} Pa'");
            let well = well("w", [1.5, 1.5], &control);
            let body = built(&block(
                "conductivity = '1e-13 m3'",
                "end = '5 s'\nsteps = 1",
                &well,
            ));
            let (steps, why) = run(&body);
            assert_eq!(why, None);
            let step = steps.last().unwrap();
            let flow = step.flow.unwrap();
            assert!(step.wells[0].rate.abs() < 1e-9 * rate, "{:?}", step.wells);
            assert!(
                (step.wells[0].pressure / limit - 1.0).abs() < 1e-9,
                "{:?}",
                step.wells
            );
            assert!(step.state.states.iter().all(|s| *s != ContactState::Open));
            assert_eq!(flow.stored_opening, 0.0);
            assert!(step.state.p.iter().all(|p| (p / limit - 1.0).abs() < 1e-9));
        }
    }
}

/// What a closed fracture without storage does not hold is not taken from it; what an open one holds is, and no more.
#[test]
fn a_well_with_a_limit_takes_what_there_is_and_no_more() {
    let control = "rate = '-1e-6 m3/s'\nlimit = '-1 MPa'";
    let toml = block(
        "conductivity = '1e-13 m3'",
        "end = '5 s'\nsteps = 1",
        &well("w", [1.5, 1.5], control),
    );
    let (steps, why) = run(&built(&toml));
    assert_eq!(why, None);
    let done = &steps.last().unwrap().wells[0];
    assert!(
        done.rate.abs() < 1e-18 && (done.pressure + 1e6).abs() < 1.0,
        "{done:?}"
    );
    // 1e-3 m³ go in, and 5e-3 are asked for after that
    let control =
        "rate = '-1e-3 m3/s'\nlimit = '9 MPa'\nhistory = [['0 s', 0], ['1 s', 0], ['1.001 s', 1]]";
    let more = well("w", [1.5, 1.5], control)
        + "[[source]]\nfracture = 'F'\nat = ['0.5 m', '0.5 m', '2 m']\nrate = '1e-3 m3/s'\nhistory = [['0 s', 1], ['1 s', 1], ['1.001 s', 0]]\n";
    let (steps, why) = run(&built(&block(
        "conductivity = '1e-9 m3'",
        "end = '5 s'\nsteps = 5",
        &more,
    )));
    assert_eq!(why, None);
    let flows = || steps.iter().filter_map(|s| s.flow);
    let injected: f64 = flows().map(|f| f.injected).sum();
    let out: f64 = flows().map(|f| f.out).sum();
    assert!(
        (injected - 1.0005e-3).abs() < 1e-12 && (out - injected).abs() < 1e-9 * injected,
        "{injected:e} {out:e}"
    );
    let done = &steps.last().unwrap().wells[0];
    assert!(
        done.rate.abs() < 1e-12 && (done.pressure / 9e6 - 1.0).abs() < 1e-6,
        "{done:?}"
    );
}

/// A random block with one or two wells that have limits, whose rates change their sign.
fn random_block(seed: u64) -> String {
    let r = &mut Random::new(seed.wrapping_mul(0x9E37_79B9) + 3);
    let mut fracture = format!(
        "conductivity = '{:e} m3'\ninitial_pressure = '{} MPa'\n",
        10f64.powf(r.between(-17.0, -9.0)),
        r.between(0.0, 9.0)
    );
    let stores = r.chance(0.5);
    if stores {
        fracture += &format!(
            "storage = '{:e} m/Pa'\n",
            10f64.powf(r.between(-14.0, -11.0))
        );
    }
    let end = 10f64.powf(r.between(0.0, 4.0));
    let mut more = String::new();
    for (name, place) in [("v", [1.5, 1.5]), ("w", [2.5, 2.5])]
        .iter()
        .take(r.whole(1, 2) as usize)
    {
        // 0.1 mm on the whole of it
        let rate = 1.6e-3 / end
            * 10f64.powf(r.between(-3.0, 0.5))
            * if r.chance(0.5) { 1.0 } else { -1.0 };
        let limit = r.between(-1.0, 14.0);
        let back = r.between(-1.0, 0.5);
        let control = format!(
            "rate = '{rate:e} m3/s'\nlimit = '{limit} MPa'\nhistory = [['0 s', 1], ['{:e} s', 1], ['{:e} s', {back}]]",
            0.5 * end,
            0.6 * end
        );
        more += &well(name, *place, &control);
    }
    block(&fracture, &format!("end = '{end:e} s'\nsteps = 5"), &more)
}

/// What the wells of a step do is one of three things, each with its own sign of what is left; what is lost is nothing beside what was asked for
/// and moved so far.
fn check(seed: u64, body: &Body, step: &Accepted, (seen, moved): (&mut [usize; 3], &mut f64)) {
    let fluid = body.fluid.as_ref().unwrap();
    let (end, start) = (step.record.time, step.record.time - step.record.dt);
    for (well, done) in fluid.wells.iter().zip(&step.wells) {
        let fracas::flow::WellGiven::Rate(rate, Some(limit)) = well.given else {
            unreachable!("all of them have one")
        };
        let history = &body.histories[well.history];
        let asked = 0.5 * rate * (history.at(start) + history.at(end));
        let largest = rate.abs();
        let (share, sign) = (done.rate * asked.signum(), asked.signum());
        let room = sign * (limit - done.pressure);
        let slack = PRESSURE * limit.abs().max(1e6);
        assert!(
            share >= -RATE * largest && share <= asked.abs() + RATE * largest,
            "seed {seed}: {done:?}, asked {asked:e}"
        );
        let is_full = share >= asked.abs() - RATE * largest;
        let is_shut = share <= RATE * largest;
        assert!(
            is_full || room <= slack,
            "seed {seed}: {done:?}, asked {asked:e}, limit {limit}"
        );
        assert!(
            is_shut || room >= -slack,
            "seed {seed}: {done:?}, asked {asked:e}, limit {limit}"
        );
        if asked != 0.0 {
            seen[usize::from(!is_full) + usize::from(!is_full && is_shut)] += 1;
        }
    }
    let flow = step.flow.unwrap();
    let asked = fluid.wells.iter().map(|well| match well.given {
        fracas::flow::WellGiven::Rate(rate, _) => rate.abs() * step.record.dt,
        fracas::flow::WellGiven::Pressure(_) => 0.0,
    });
    let stored = flow.stored_opening.abs() + flow.stored_compression.abs();
    *moved += flow.injected + flow.out + stored + asked.sum::<f64>();
    assert!(flow.injected >= 0.0 && flow.out >= 0.0);
    // pressures are known to so much of them, too
    let pressed =
        |(face, p): (&FractureFace, &f64)| face.area * fluid.channel(face).storage * p.abs();
    let faces = body.fractures.faces.iter().zip(&step.state.p);
    let held: f64 = faces.map(pressed).sum();
    assert!(
        flow.error.abs() <= LOSS * (*moved + held),
        "seed {seed}: {flow:?}"
    );
}

fn family(seeds: std::ops::Range<u64>) {
    let (mut seen, mut ended) = ([0; 3], Vec::new());
    let count = seeds.end - seeds.start;
    let shows = std::env::var("FRACAS_SHOW").is_ok();
    for seed in seeds {
        if shows {
            println!("{}", random_block(seed));
        }
        let body = built(&random_block(seed));
        let (steps, why) = run(&body);
        let mut moved = 0.0;
        if let Some(why) = why {
            ended.push((seed, why));
        }
        for step in steps.iter().filter(|step| step.flow.is_some()) {
            check(seed, &body, step, (&mut seen, &mut moved));
        }
    }
    println!("full, part, shut: {seen:?}; ended early: {ended:#?}");
    assert!(ended.len() as u64 <= count / 50, "{ended:#?}");
    assert!(seen.iter().all(|n| *n > 0), "{seen:?}");
}

#[test]
fn limits_throttle_random_wells_and_never_turn_them_round() {
    family(0..40);
}

/// `FRACAS_SEEDS=from..to cargo test --release --test known wells:: -- --ignored --nocapture`
#[test]
#[ignore = "as many as asked for"]
fn limits_throttle_many_random_wells() {
    let seeds = std::env::var("FRACAS_SEEDS").unwrap_or_else(|_| "1000..1100".into());
    let (from, to) = seeds.split_once("..").unwrap();
    family(from.parse().unwrap()..to.parse().unwrap());
}

/// Why a scene is refused.
fn refused(toml: &str) -> String {
    match Scene::from_toml(toml, "wells.toml").unwrap().build() {
        Ok(_) => panic!("accepted"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_well_in_its_fracture_is_refused_at_every_angle_and_one_through_it_cuts_one_face() {
    let r = &mut Random::new(8);
    let angles = [0.0, 30.0, 37.0, 10.0, 77.0, -20.0, 123.0].into_iter();
    let angles: Vec<f64> = angles
        .chain((0..20).map(|_| r.between(-180.0, 180.0)))
        .collect();
    for angle in angles {
        let (s, c) = f64::to_radians(angle).sin_cos();
        let turned = |[x, y, z]: [f64; 3]| {
            let (x, z) = (x - 2.0, z - 2.0);
            format!(
                "['{} m', '{y} m', '{} m']",
                c * x + s * z + 2.0,
                c * z - s * x + 2.0
            )
        };
        let scene = |[from, to]: [[f64; 3]; 2]| {
            let well = format!(
                "[mesh.map]\nrotate = {{ axis = 'y', angle = '{angle} deg' }}\n\
                 [[well]]\nname = 'w'\nfrom = {}\nto = {}\nradius = '0.05 m'\nrate = '1e-8 m3/s'\n",
                turned(from),
                turned(to)
            );
            block(
                "conductivity = '1e-13 m3'\nstorage = '1e-11 m/Pa'",
                "end = '5 s'\nsteps = 1",
                &well,
            )
            .replace("'roller'", "'fixed'")
        };
        let (a, b) = (r.between(-1.0, 3.0), r.between(0.5, 3.5));
        let text = refused(&scene([
            [a, b, 2.0],
            [a + 3.0, b + r.between(-0.4, 0.4), 2.0],
        ]));
        assert!(text.contains("lies in fracture \"F\""), "{angle}: {text}");
        // beside the plane it is no well of this fracture
        let text = refused(&scene([[a, b, 2.5], [a + 3.0, b, 2.5]]));
        assert!(text.contains("cuts no fracture"), "{angle}: {text}");
        let body = built(&scene([[2.5, 1.5, 4.0], [2.5, 1.5, 0.0]]));
        assert_eq!(body.fluid.unwrap().wells[0].cuts.len(), 1, "{angle}");
    }
}

/// Pressures that are the same on both sides of the diagonal, and four faces that share what one would have.
#[test]
fn what_lies_on_the_border_of_faces_is_shared_by_them() {
    let fracture = "conductivity = '1e-13 m3'\nstorage = '1e-11 m/Pa'";
    for (place, faces) in [
        ([2.0, 2.0], 4),
        ([2.0, 1.5], 2),
        ([1.5, 1.5], 1),
        ([4.0, 1.5], 1),
    ] {
        let [x, y] = place;
        let rate = "rate = '1e-6 m3/s'";
        let source =
            format!("[[source]]\nfracture = 'F'\nat = ['{x} m', '{y} m', '2 m']\n{rate}\n");
        let mut found = Vec::new();
        for more in [well("w", place, rate), source] {
            let body = built(&block(fracture, "end = '5 s'\nsteps = 1", &more));
            let fluid = body.fluid.as_ref().unwrap();
            if let Some(well) = fluid.wells.first() {
                assert_eq!(well.cuts.len(), faces);
                let whole: f64 = well.cuts.iter().map(|(_, index)| index).sum();
                let expected = std::f64::consts::TAU / (0.14 * 2f64.sqrt() / 0.05).ln();
                assert!((whole / expected - 1.0).abs() < 1e-12);
            }
            let (steps, why) = run(&body);
            assert_eq!(why, None);
            found.push(steps.last().unwrap().state.p.clone());
        }
        let largest = found[0].iter().fold(0.0f64, |m, p| m.max(p.abs()));
        let least = found[0].iter().fold(largest, |m, p| m.min(*p));
        let near = |p: &&f64| **p > largest - 0.1 * (largest - least);
        let near = found[0].iter().filter(near).count();
        assert_eq!(near, faces, "{:?}", found[0]);
        for (a, b) in found[0].iter().zip(&found[1]) {
            assert!((a - b).abs() < 1e-6 * largest, "{place:?}: {a} {b}");
        }
    }
}

/// A fluid at rest stays at rest beside an edge whose pressure holds at a level.
#[test]
fn an_edge_pressure_at_a_level_is_hydrostatic() {
    for (level, pressure) in [
        (0.0, 1e6),
        (3.0, 1e6 - 3.0 * 9810.0),
        (-200.0, 1e6 + 200.0 * 9810.0),
    ] {
        let toml = block(
            "conductivity = '1e-13 m3'\nstorage = '1e-11 m/Pa'\ninitial_pressure = '1 MPa'",
            "end = '1e6 s'\nsteps = 2",
            &format!(
                "[gravity]\nz = '-9.81 m/s2'\n[[source]]\nfracture = 'F'\nedge = 'y-'\npressure = '{pressure} Pa'\nlevel = '{level} m'\n"
            ),
        );
        let toml = toml
            .replace("plane = 'z'", "plane = 'x'")
            .replace("[fluid]\n", "[fluid]\ndensity = '1000 kg/m3'\n");
        let (steps, why) = run(&built(&toml));
        assert_eq!(why, None);
        let flow = steps.last().unwrap().flow.unwrap();
        // 16 m² times s times p would be 1.6e-4
        assert!(flow.injected + flow.out < 1e-12, "{flow:?}");
    }
    let said = |more: &str, fluid: &str| {
        let source = format!(
            "[gravity]\nz = '-9.81 m/s2'\n[[source]]\nfracture = 'F'\nlevel = '0 m'\n{more}\n"
        );
        let toml = block(
            "conductivity = '1e-13 m3'\nstorage = '1e-11 m/Pa'",
            "end = '1 s'\nsteps = 1",
            &source,
        );
        refused(&toml.replace("[fluid]\n", &format!("[fluid]\n{fluid}\n")))
    };
    let text = said("rate = '1e-9 m3/s'", "density = '1000 kg/m3'");
    assert!(
        text.contains("`level`") && text.contains("pressure"),
        "{text}"
    );
    let text = said("edge = 'y-'\npressure = '1 MPa'", "");
    assert!(
        text.contains("`level`") && text.contains("density"),
        "{text}"
    );
}

/// Edges of a side are those of the mesh, far from the origin and with coordinates in six digits, too.
#[test]
fn the_edge_of_a_side_is_found_far_away_and_where_coordinates_are_rounded() {
    let source = "[[source]]\nfracture = 'F'\nedge = 'x-'\npressure = '1 MPa'\n";
    let plain = block(
        "conductivity = '1e-13 m3'\nstorage = '1e-11 m/Pa'",
        "end = '1e3 s'\nsteps = 1",
        source,
    );
    let brought = |toml: &str| {
        let (steps, why) = run(&built(toml));
        assert_eq!(why, None);
        steps.last().unwrap().flow.unwrap().injected
    };
    let whole = brought(&plain);
    let far = plain.replace(
        "x = { from = '0 m', to = '4 m'",
        "x = { from = '5000000 m', to = '5000004 m'",
    );
    assert_ne!(far, plain);
    assert!((brought(&far) / whole - 1.0).abs() < 1e-6);
    for amplitude in [1e-7, 1e-5, 1e-4] {
        let distort = format!(
            "[mesh.map.distort]\namplitude = {amplitude}\nseed = 5\nbend_fractures = true\n"
        );
        let rounded = plain.replace("[[material]]", &format!("{distort}[[material]]"));
        assert!(
            (brought(&rounded) / whole - 1.0).abs() < 1e-2,
            "{amplitude}"
        );
    }
}
