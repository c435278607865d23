//! Claim: the time at which slip begins is known as closely as a scene asks, whatever the steps: that of closed forms, and that of steps
//! as short as the interval.

use crate::scenes::{SLIDING, body};
use crate::unstable::Case;
use fracas::analytic::BlockSliding;
use fracas::nonlinear::{Begins, Event, Failure, Simulation, SlipOnset};
use fracas::scene::Body;
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// Share by which times may differ beside the interval: states are judged to 1e-6 of the largest traction. Unit: 1.
const SAME: f64 = 1e-4;

/// A run to its end: the onsets that its events tell, and the times of its steps [s].
fn onsets(body: &Body) -> (Vec<(String, SlipOnset)>, Vec<f64>) {
    let mut simulation = Simulation::new(body).unwrap();
    let (mut told, mut times) = (Vec::new(), Vec::new());
    let end = simulation.run(&mut Silent, |_, _, done| {
        times.push(done.record.time);
        told.extend(found(&done.events));
    });
    let end = end.unwrap_or_else(|failure| panic!("{failure}"));
    let known = simulation.onsets(&end);
    let known: Vec<(String, SlipOnset)> = known.map(|(f, o)| (f.into(), o.clone())).collect();
    assert_eq!(known, told, "the state knows what events told");
    (told, times)
}

fn found(events: &[Event]) -> Vec<(String, SlipOnset)> {
    let onset = |event: &Event| match event {
        Event::Onset { fracture, onset } => Some((fracture.clone(), (**onset).clone())),
        _ => None,
    };
    events.iter().filter_map(onset).collect()
}

/// An onset is known to `within`, and the exact time lies where it says.
fn holds(onset: &SlipOnset, exact: f64, within: f64, what: &str) {
    let before = onset.before.unwrap();
    assert!(
        onset.after - before <= within * (1.0 + 1e-9),
        "{what}: {before} to {} for {within}",
        onset.after
    );
    assert!(
        before <= exact * (1.0 + SAME) && exact <= onset.after * (1.0 + SAME),
        "{what}: {before} to {}, exactly {exact}",
        onset.after
    );
}

/// The steps of a run land on its grid, and on others between two times of it only.
fn on_grid(times: &[f64], end: f64, steps: u32, [from, to]: [f64; 2], what: &str) {
    let grid: Vec<f64> = (0..=steps)
        .map(|n| end * f64::from(n) / f64::from(steps))
        .collect();
    let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * end;
    for time in &grid {
        assert!(
            times.iter().any(|t| same(*t, *time)),
            "{what}: no step at {time}"
        );
    }
    let whole = |t: f64| grid.iter().any(|time| same(t, *time));
    for t in times {
        let is_within = from - 1e-9 * end <= *t && *t <= to + 1e-9 * end;
        assert!(whole(*t) || is_within, "{what}: a step at {t}");
    }
}

/// Two blocks of random rock and friction, sheared forth and back.
#[test]
fn blocks_slip_at_the_time_of_the_closed_form() {
    let mut random = Random::new(11);
    for seed in 0..24 {
        let mut between = |low: f64, high: f64| random.between(low, high);
        let shear = 10f64.powf(between(9.0, 10.5));
        let (height, cut) = (between(1.0, 50.0), between(1.0, 4.999).floor());
        let compression = between(2e6, 3e7);
        let friction = between(5.0, 40.0);
        let blocks = BlockSliding {
            shear,
            heights: [height * cut / 6.0, height * (1.0 - cut / 6.0)],
            friction_angle: f64::to_radians(friction),
            cohesion: between(0.0, 2e6),
            compression,
        };
        // slips on the way forth, before 1 s
        let end = between(1.05, 4.0) * blocks.elastic_range();
        let steps = between(5.0, 40.0).floor() as u32;
        let within = 10f64.powf(between(-4.0, -1.0));
        let method = ["lagrange", "{augmented_lagrangian={factor=1e2}}"][seed % 2];
        let body = body(
            SLIDING,
            &[
                &format!("material.0.young={} Pa", 2.5 * shear),
                &format!("mesh.z.to={height} m"),
                &format!("fracture.0.at={} m", blocks.heights[0]),
                &format!("fracture.0.friction_angle={friction} deg"),
                &format!("fracture.0.cohesion={} Pa", blocks.cohesion),
                &format!("initial_stress.constant.zz=-{compression} Pa"),
                &format!("boundary.3.displacement.x={end} m"),
                &format!("time.steps={steps}"),
                &format!("time.onset={{within=\"{within} s\",patch=\"1 m2\"}}"),
                &format!("solver.method={method}"),
                "solver.tolerance=1e-10",
            ],
        );
        let (told, times) = onsets(&body);
        let what = format!("seed {seed}, {steps} steps");
        assert_eq!(told.len(), 2, "{what}: {told:?}");
        let exact = blocks.elastic_range() / end;
        for ((name, onset), begins) in told.iter().zip([Begins::Face, Begins::Patch]) {
            assert_eq!(
                (name.as_str(), onset.begins, onset.face),
                ("cut", begins, 0)
            );
            holds(onset, exact, within, &what);
            assert!((onset.area - 1.0).abs() < 1e-12);
            let center = [0.5, 0.5, blocks.heights[0]];
            let apart = (0..3).map(|k| (onset.center[k] - center[k]).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-9 * height, "{what}");
        }
        let nominal = 5.0 / f64::from(steps);
        let step = (exact / nominal).floor() * nominal;
        // corners of the history are times as well
        let mut corners = times.clone();
        corners.retain(|t| ![1.0, 3.0].iter().any(|c| (t - c).abs() < 1e-9));
        let grid = [1.0, 3.0].map(|c| (c / nominal - (c / nominal).round()).abs() < 1e-9);
        corners.extend(
            [1.0, 3.0]
                .into_iter()
                .zip(grid)
                .filter(|c| c.1)
                .map(|c| c.0),
        );
        on_grid(&corners, 5.0, steps, [step, step + nominal], &what);
    }
}

/// A crack through uniformly stressed rock, two cells across.
const INCLINED: &str = r#"
title = "Inclined fault under a growing load"
[mesh]
x = { from = "-16 m", to = "16 m", cells = 8 }
y = { from = "0 m", to = "2 m", cells = 2 }
z = { from = "-4 m", to = "4 m", cells = 8 }
[mesh.map.incline]
plane = "x"
tilt = "20 deg"
pivot = ["0 m", "0 m", "0 m"]
fade = true
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "fault"
plane = "x"
at = "0 m"
z = ["-2 m", "2 m"]
friction_angle = "30 deg"
cohesion = "0 MPa"
pressure = "1 MPa"
pressure_history = [["0 s", 1], ["1 s", 1]]
[[boundary]]
side = "x-"
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
side = "x+"
pressure = "10 MPa"
[[boundary]]
side = "z+"
pressure = "10 MPa"
history = [["0 s", 1], ["1 s", 10]]
[time]
end = "1 s"
steps = 4
[solver]
tolerance = 1e-11
"#;

/// The fault of a seed: what is set, and the time at which it slips.
fn inclined(random: &mut Random) -> (Vec<String>, f64) {
    loop {
        let tilt = random.between(15.0, 60.0f64);
        let friction = random.between(10.0, 35.0f64);
        let cohesion = random.between(0.0, 2e6);
        let side = random.between(5e6, 2e7);
        let growth = random.between(1.5, 12.0);
        let fluid = [random.between(0.0, 2e6), random.between(0.0, 4e6)];
        // shear less its limit, linear in time
        let (s, c) = tilt.to_radians().sin_cos();
        let excess = |t: f64| {
            let top = side * (1.0 + (growth - 1.0) * t);
            let pressure = fluid[0] + (fluid[1] - fluid[0]) * t;
            // the normal of a plane x = 0 that leans by the tilt
            let normal = -side * c * c - top * s * s + pressure;
            (top - side) * s * c - cohesion + normal * friction.to_radians().tan()
        };
        let [first, last] = [excess(0.0), excess(1.0)];
        if first > -1e4 || last < 1e5 {
            continue;
        }
        let exact = first / (first - last);
        let set = [
            format!("mesh.map.incline.tilt={tilt} deg"),
            format!("fracture.0.friction_angle={friction} deg"),
            format!("fracture.0.cohesion={cohesion} Pa"),
            format!(
                "fracture.0.pressure_history=[[\"0 s\",{}],[\"1 s\",{}]]",
                fluid[0] / 1e6,
                fluid[1] / 1e6
            ),
            format!("boundary.4.pressure={side} Pa"),
            format!("boundary.5.pressure={side} Pa"),
            format!("boundary.5.history=[[\"0 s\",1],[\"1 s\",{growth}]]"),
        ];
        return (set.into(), exact);
    }
}

#[test]
fn inclined_faults_slip_at_the_time_of_coulombs_law() {
    let mut random = Random::new(12);
    for seed in 0..16 {
        let (mut set, exact) = inclined(&mut random);
        let steps = random.between(1.0, 8.999).floor();
        let within = 10f64.powf(random.between(-3.5, -1.0));
        set.push(format!("time.steps={steps}"));
        set.push(format!("time.onset.within={within} s"));
        let set: Vec<&str> = set.iter().map(String::as_str).collect();
        let body = body(INCLINED, &set);
        let (told, times) = onsets(&body);
        let what = format!("seed {seed}, {steps} steps");
        assert_eq!(told.len(), 1, "{what}: {told:?}");
        holds(&told[0].1, exact, within, &what);
        let step = (exact * steps).floor() / steps;
        on_grid(&times, 1.0, steps as u32, [step, step + 1.0 / steps], &what);
        // it acts by the history of its own
        let after = told[0].1.after;
        let fluid = body.pressures[0].1;
        let pressure = 1e6 * body.histories[fluid].at(after);
        assert!(
            (told[0].1.pressure - pressure).abs() <= 1e-9 * pressure.abs(),
            "{what}"
        );
    }
}

/// Cohesion that grows along the fault, so that slip begins at one end and spreads.
const WEAK_END: &str =
    "fracture.0.profile=[{z=\"-3 m\",cohesion=\"0 MPa\"},{z=\"3 m\",cohesion=\"12 MPa\"}]";

/// First times of a run in steps at which a face slips, and at which a patch of `least` does; with the times before them and the first faces.
fn brute(body: &Body, least: f64) -> [([f64; 2], Vec<usize>); 2] {
    let mut simulation = Simulation::new(body).unwrap();
    let fractures = &body.fractures;
    let mut seen: [Option<([f64; 2], Vec<usize>)>; 2] = [None, None];
    let end = simulation.run(&mut Silent, |_, before, done| {
        let states = &done.state.states;
        let patches = fractures.patches(|f| states[f].code() > 0);
        let span = [before.time, done.state.time];
        let area = |p: &Vec<usize>| fractures.area_of(p.iter().copied());
        let largest = patches.iter().max_by(|a, b| area(a).total_cmp(&area(b)));
        let Some(largest) = largest else { return };
        let all: Vec<usize> = patches.iter().flatten().copied().collect();
        seen[0].get_or_insert((span, all));
        if area(largest) >= least {
            seen[1].get_or_insert((span, largest.clone()));
        }
    });
    end.unwrap();
    seen.map(Option::unwrap)
}

/// Bisection from a few long steps finds what short ones find, on a fault whose strength is not the same everywhere.
#[test]
fn onsets_are_those_of_steps_as_short_as_the_interval() {
    let mut random = Random::new(13);
    for seed in 0..3 {
        let (set, _) = inclined(&mut random);
        let mut set: Vec<&str> = set.iter().map(String::as_str).collect();
        set.retain(|key| !key.starts_with("fracture.0.cohesion"));
        let hard = ["boundary.5.history=[[\"0 s\",1],[\"1 s\",14]]"];
        let base = INCLINED.replace("cohesion = \"0 MPa\"\n", "");
        let built = |more: &[&str]| body(&base, &[&set[..], &hard, &[WEAK_END], more].concat());
        // two, three and all of its four rows
        let whole = built(&[]).fractures;
        let whole = whole.area_of(0..whole.faces.len());
        let patch = [0.4, 0.6, 0.9][seed] * whole;
        let fine = brute(&built(&["time.steps=250"]), patch);
        let onset = format!("time.onset={{within=\"4 ms\",patch=\"{patch} m2\"}}");
        let body = built(&["time.steps=5", &onset]);
        let (told, _) = onsets(&body);
        assert_eq!(told.len(), 2, "seed {seed}: {told:?}");
        for (((_, onset), (span, faces)), begins) in
            told.iter().zip(&fine).zip([Begins::Face, Begins::Patch])
        {
            println!("seed {seed}: {onset:?}, {span:?}, {faces:?}");
            assert_eq!(onset.begins, begins);
            // paths of long and of short steps differ a little once faces slip
            let before = onset.before.unwrap();
            assert!(onset.after - before <= 4e-3 * (1.0 + 1e-9));
            assert!(
                before <= span[1] + 4e-3 && onset.after >= span[0] - 4e-3,
                "seed {seed}"
            );
            assert!(faces.contains(&onset.face), "seed {seed}: {faces:?}");
            let area = body.fractures.area_of(faces.iter().copied());
            assert!(
                onset.area <= 1.5 * area && onset.area > 0.0,
                "{} {area}",
                onset.area
            );
        }
        assert!(told[0].1.area < patch && told[1].1.area >= patch * (1.0 - 1e-9));
        assert!(told[0].1.after < told[1].1.before.unwrap());
    }
}

/// Where slip runs away at once, the step that fails tells when it begins; where it comes to rest, the step that goes over it does.
#[test]
fn slip_that_runs_away_tells_when_it_begins() {
    for seed in 0..8u64 {
        let case = Case::new(seed, [1.2, 4.0]);
        let exact = case.blocks.elastic_range() / case.end;
        for within in [0.1, 1e-3, 1e-5] {
            let onset = format!("time.onset.within={within} s");
            let what = format!("seed {seed}, within {within}");
            let body = case.body("lagrange", &[&onset]);
            let mut simulation = Simulation::new(&body).unwrap();
            let mut told = Vec::new();
            let end = simulation.run(&mut Silent, |_, _, done| told.extend(found(&done.events)));
            if let Err(failure) = end {
                let is_unstable = matches!(failure.reason, Failure::Unstable(_));
                assert!(is_unstable, "{what}: {failure}");
                assert!(told.is_empty(), "{what}");
                told = found(&failure.events);
            }
            assert_eq!(told.len(), 1, "{what}");
            holds(&told[0].1, exact, within, &what);
            let rests = case.body("lagrange", &[&onset, "solver.unstable=arrest"]);
            let (told, _) = onsets(&rests);
            assert_eq!(told.len(), 1, "{what}");
            holds(&told[0].1, exact, within, &what);
        }
    }
}

/// What begins with the loads of time 0 is told at that time, and no step is halved for it.
#[test]
fn slip_at_time_0_needs_no_search() {
    let set = [
        "time.onset.within=1e-6 s",
        "boundary.5.history=[[\"0 s\",10],[\"1 s\",11]]",
    ];
    let body = body(INCLINED, &set);
    let (told, times) = onsets(&body);
    assert_eq!(told.len(), 1);
    assert_eq!((told[0].1.before, told[0].1.after), (Some(0.0), 0.0));
    assert_eq!(times, [0.0, 0.25, 0.5, 0.75, 1.0]);
}

/// Rock that drains beside the fault: the onset says by how much its pressure has changed by then.
#[test]
fn an_onset_tells_the_pressure_of_the_rock_beside_it() {
    let drained = [
        "material.0.biot=0.8",
        "material.0.pressure_change=-5 MPa",
        "material.0.pressure_history=[[\"0 s\",0],[\"1 s\",1]]",
        "time.onset.within=1 ms",
    ];
    let (told, _) = onsets(&body(INCLINED, &drained));
    let onset = &told[0].1;
    for side in onset.drained {
        assert!((side + 4e6 * onset.after).abs() < 1e-6, "{onset:?}");
    }
}
