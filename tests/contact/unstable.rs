//! Claim: slip that weakens faster than the rock around is stiff is recognized at the load at which it begins, whatever steps lead
//! there, also where the step opens the faces; slip that weakens more slowly never is.
//!
//! `FRACAS_RUNS=600 FRACAS_SEED=1000 cargo test --release --test contact unstable:: -- --nocapture` tries more blocks.

use crate::scenes::{SLIDING, body, run};
use fracas::analytic::BlockSliding;
use fracas::nonlinear::{Event, Failure, Simulation};
use fracas::scene::Body;
use fracas_operators::random::splitmix64;
use fracas_solvers::Silent;

/// Runs of each kind where nobody asks for more.
const RUNS: u64 = 12;

/// Share by which loads may differ: states are judged to 1e-6 of the largest traction. Unit: 1.
const SAME: f64 = 1e-5;

/// What holds faces, and the share of the elastic range by which springs give. Unit: 1.
const METHODS: [(&str, f64); 3] = [
    ("lagrange", 0.0),
    ("{augmented_lagrangian={factor=1e2}}", 0.0),
    ("{penalty={factor=1e4}}", 1e-3),
];

/// Blocks that a seed decides.
pub(crate) struct Case {
    pub(crate) blocks: BlockSliding,
    /// Weakening at rest over `G/(H1 + H2)`.
    ratio: f64,
    /// Displacement of the top after 1 s [m].
    pub(crate) end: f64,
    overrides: Vec<String>,
}

impl Case {
    /// `ratio` between `low` and `high`.
    pub(crate) fn new(seed: u64, [low, high]: [f64; 2]) -> Self {
        let number = |k: u64| (splitmix64(97 * seed + k) >> 11) as f64 / (1u64 << 53) as f64;
        let between = |k: u64, low: f64, high: f64| low + (high - low) * number(k);
        let shear = 10f64.powf(between(1, 9.0, 10.5));
        let (cells, cut) = (6.0, 1.0 + (4.999 * number(2)).floor());
        let height = between(3, 1.0, 50.0);
        let ratio = between(4, low, high);
        let [friction, dynamic] = [between(5, 25.0, 40.0), between(6, 5.0, 20.0)];
        let blocks = BlockSliding {
            shear,
            heights: [height * cut / cells, height * (1.0 - cut / cells)],
            friction_angle: f64::to_radians(friction),
            cohesion: 0.0,
            compression: 1e7,
        };
        // −dτ_L/ds at rest = σ0 (φ_s − φ_d)/(d_c cos² φ_s)
        let fall = f64::to_radians(friction - dynamic);
        let slope = ratio * shear / height;
        let distance = 1e7 * fall / (blocks.friction_angle.cos().powi(2) * slope);
        let end = between(7, 1.2, 3.0) * blocks.elastic_range();
        let overrides = [
            format!("material.0.young={} Pa", 2.5 * shear),
            format!("mesh.z.to={height} m"),
            format!("fracture.0.at={} m", height * cut / cells),
            format!("fracture.0.friction_angle={friction} deg"),
            "fracture.0.cohesion=0 MPa".into(),
            format!("fracture.0.dynamic_friction_angle={dynamic} deg"),
            format!("fracture.0.weakening_distance={distance} m"),
            format!("boundary.3.displacement.x={end} m"),
            format!("time.steps={}", 1 + (9.0 * number(8)) as u32),
            "time.end=1 s".into(),
        ];
        Self {
            blocks,
            ratio,
            end,
            overrides: overrides.into(),
        }
    }

    pub(crate) fn body(&self, method: &str, more: &[&str]) -> Body {
        let method = format!("solver.method={method}");
        let own = self.overrides.iter().map(String::as_str);
        // stiff springs round at 1e-13
        let settings = match method.ends_with("lagrange") {
            true => [&*method, "solver.tolerance=1e-13"],
            false => [&*method, "solver.tolerance=1e-10"],
        };
        let all: Vec<&str> = own.chain(more.iter().copied()).chain(settings).collect();
        body(SLIDING, &all)
    }
}

/// The number of a method.
fn of(method: &str) -> usize {
    METHODS.iter().position(|m| m.0 == method).unwrap()
}

/// Every seed with every method.
fn all() -> impl Iterator<Item = (u64, &'static str, f64)> {
    let with = |seed| METHODS.map(|(method, gives)| (seed, method, gives));
    let first = asked("FRACAS_SEED", 0);
    (first..first + runs()).flat_map(with)
}

pub(crate) fn runs() -> u64 {
    asked("FRACAS_RUNS", RUNS)
}

pub(crate) fn asked(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().unwrap())
}

#[test]
fn slip_that_weakens_slowly_is_never_called_unstable() {
    let mut halved = 0;
    for (seed, method, _) in all() {
        let case = Case::new(seed, [0.05, 0.98]);
        let body = case.body(method, &[]);
        let mut simulation = Simulation::new(&body).unwrap();
        let mut cuts = 0;
        let end = simulation.run(&mut Silent, |_, _, done| {
            let unstable =
                |e: &Event| matches!(e, Event::Cut { reason, .. } if reason.contains("unstable"));
            assert!(!done.events.iter().any(unstable), "seed {seed} {method}");
            cuts += done.record.cuts;
        });
        let fields = simulation.face_fields(&end.unwrap());
        assert!(fields.slip[0] > 0.0, "seed {seed} {method}: nothing slips");
        halved += usize::from(cuts > 0);
    }
    // limits of the iterate before converge slowly; of the first twelve none needs it
    let runs = all().count();
    assert!(50 * halved <= runs, "{halved} of {runs} are halved");
}

#[test]
fn slip_that_runs_away_is_recognized_at_the_load_at_which_it_begins() {
    let mut named = [0; METHODS.len()];
    for (seed, method, gives) in all() {
        let case = Case::new(seed, [1.05, 6.0]);
        let body = case.body(method, &[]);
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        let end = simulation.run(&mut Silent, |_, _, done| state = done.state.clone());
        let failed = end.err();
        // a jump that is small beside the slip of the shortest step is not told from a steep path
        let Some(failure) = failed else {
            println!("seed {seed} {method}, ratio {}: to the end", case.ratio);
            continue;
        };
        let onset = case.blocks.elastic_range() / case.end;
        let [low, high] = [failure.time, failure.time + failure.increment];
        assert!(
            low <= onset * (1.0 + SAME + gives) && onset <= high * (1.0 + SAME),
            "seed {seed} {method}: {onset} {low} {high}"
        );
        assert!(
            failure.increment <= 1.0 / 128.0,
            "seed {seed} {method}: {failure}"
        );
        let Failure::Unstable(patch) = &failure.reason else {
            println!("seed {seed} {method}, ratio {}: {failure}", case.ratio);
            continue;
        };
        named[of(method)] += 1;
        assert!(
            (patch.ratio - case.ratio).abs() < 2e-3 * case.ratio,
            "seed {seed} {method}: {} {}",
            patch.ratio,
            case.ratio
        );
        assert_eq!((patch.fracture.as_str(), patch.faces), ("cut", 1));
        // the last good state: stuck just below the limit
        let fields = simulation.face_fields(&state);
        assert!(
            fields.slip[0] <= 1e-9 * case.end,
            "seed {seed} {method}: {}",
            fields.slip[0]
        );
    }
    for named in named {
        assert!(20 * named >= 19 * runs(), "{named} of {} are named", runs());
    }
}

#[test]
fn asked_for_a_run_steps_over_to_the_arrested_state_and_says_so() {
    let mut arrested = [0; METHODS.len()];
    'runs: for (seed, method, gives) in all() {
        let case = Case::new(seed, [1.05, 6.0]);
        let body = case.body(method, &["solver.unstable=arrest"]);
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        let mut passed = Vec::new();
        while state.step == 0 || !simulation.is_finished(&state) {
            let before = state.time;
            let done = match simulation.advance(&state, &mut Silent) {
                Ok(done) => done,
                // no arrested state was found: said, and the last good one stays
                Err(failure) => {
                    let onset = case.blocks.elastic_range() / case.end;
                    let reached = failure.time + failure.increment;
                    let reaches = onset <= reached * (1.0 + SAME);
                    assert!(reaches, "seed {seed} {method}: {failure}");
                    continue 'runs;
                }
            };
            let told = done
                .events
                .iter()
                .any(|e| matches!(e, Event::Arrested { .. }));
            assert_eq!(told, done.record.arrested, "seed {seed} {method}");
            state = done.state;
            if told {
                passed.push([before, state.time]);
            }
        }
        let onset = case.blocks.elastic_range() / case.end;
        if passed.is_empty() {
            println!("seed {seed} {method}, ratio {}: no jump", case.ratio);
            continue;
        }
        assert_eq!(passed.len(), 1, "seed {seed} {method}: {passed:?}");
        let [low, high] = passed[0];
        assert!(
            low <= onset * (1.0 + SAME + gives) && onset <= high * (1.0 + SAME),
            "seed {seed} {method}"
        );
        // equilibrium of the column and the limit at this slip
        let fields = simulation.face_fields(&state);
        let shear = fields.traction[1].hypot(fields.traction[2]);
        assert!(
            (shear - fields.tau_limit[0]).abs() < (1e-5 + gives) * shear,
            "seed {seed} {method}: {shear} {}",
            fields.tau_limit[0]
        );
        let height: f64 = case.blocks.heights.iter().sum();
        let driven = case.blocks.shear * (case.end - fields.slip[0]) / height;
        assert!(
            (shear - driven).abs() < (1e-5 + gives) * shear,
            "seed {seed} {method}: {shear} {driven}"
        );
        arrested[of(method)] += 1;
    }
    for arrested in arrested {
        let runs = runs();
        assert!(
            4 * arrested >= 3 * runs,
            "{arrested} of {runs} come to rest"
        );
    }
}

/// Two blocks between which the pressure of a fluid rises.
const PRESSED: &str = r#"
title = "rising pressure"
[mesh]
x = { from = "0 m", to = "1 m", cells = 1 }
y = { from = "0 m", to = "1 m", cells = 1 }
z = { from = "0 m", to = "3 m", cells = 6 }
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
[[fracture]]
name = "cut"
plane = "z"
at = "1 m"
friction_angle = "30 deg"
dynamic_friction_angle = "10 deg"
weakening_distance = "1 mm"
pressure = "9 MPa"
pressure_history = [["0 s", 0.0], ["1 s", 1.0]]
[initial_stress]
constant = { xx = "-10 MPa", yy = "-10 MPa", zz = "-10 MPa", xz = "4.5 MPa" }
[[boundary]]
side = "x-"
displacement = { y = "0 m" }
[[boundary]]
side = "x+"
displacement = { y = "0 m" }
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
displacement = { x = "0.1 um", y = "0 m", z = "0 m" }
history = [["0 s", 0.0], ["1 s", 1.0]]
[time]
end = "1 s"
steps = 1
"#;

/// What holds the faces together falls within the step: its end alone has too little friction left to lose.
#[test]
fn slip_that_runs_away_as_pressure_rises_is_recognized_whatever_the_steps() {
    as_pressure_rises_to([6.0, 7.0]);
}

/// Above the 10 MPa that hold the faces together, which at the end of the step have no strength left to lose.
#[test]
fn slip_that_runs_away_in_a_step_that_opens_the_faces_is_recognized_whatever_the_steps() {
    as_pressure_rises_to([10.5, 14.0]);
}

/// The same where the rock gives back more than the faces lose: they slip, open, and nothing is cut.
#[test]
fn slip_that_weakens_slowly_until_the_faces_open_is_never_called_unstable() {
    for (seed, method, _) in all() {
        let number = |k: u64| (splitmix64(83 * seed + k) >> 11) as f64 / (1u64 << 53) as f64;
        let overrides = [
            format!("fracture.0.pressure={} MPa", 10.5 + 3.5 * number(1)),
            format!("fracture.0.weakening_distance={} mm", 7.0 + 8.0 * number(2)),
            format!("time.steps={}", 1 + (9.0 * number(3)) as u64),
            format!("solver.method={method}"),
        ];
        let body = body(PRESSED, &overrides.each_ref().map(|text| &**text));
        let mut open = false;
        run(&body, |_, fields, record| {
            assert_eq!(record.cuts, 0, "seed {seed} {method}");
            open |= fields.jump[0] > 0.0;
        });
        assert!(open, "seed {seed} {method}: nothing opens");
    }
}

/// Rising pressure, its largest value between these [MPa].
fn as_pressure_rises_to([low, high]: [f64; 2]) {
    for (seed, method, gives) in all() {
        let number = |k: u64| (splitmix64(89 * seed + k) >> 11) as f64 / (1u64 << 53) as f64;
        let pressure = low + (high - low) * number(1);
        let distance = 0.4 + 0.3 * number(2);
        // the interval in which it runs away, if it does
        let runs_away = |steps: u64| {
            let overrides = [
                format!("fracture.0.pressure={pressure} MPa"),
                format!("fracture.0.weakening_distance={distance} mm"),
                format!("time.steps={steps}"),
                format!("solver.method={method}"),
            ];
            let body = body(PRESSED, &overrides.each_ref().map(|text| &**text));
            let mut simulation = Simulation::new(&body).unwrap();
            let failure = simulation.run(&mut Silent, |_, _, _| ()).err()?;
            let unstable = matches!(failure.reason, Failure::Unstable(_));
            assert!(unstable, "seed {seed} {method}, {steps} steps: {failure}");
            Some([failure.time, failure.time + failure.increment])
        };
        let [low, high] = runs_away(60).unwrap();
        for steps in [1, 2, 1 + (9.0 * number(3)) as u64, 10] {
            let found = runs_away(steps);
            let same = |[l, h]: [f64; 2]| {
                l <= high * (1.0 + SAME + gives) && low <= h * (1.0 + SAME + gives)
            };
            assert!(
                found.is_some_and(same),
                "seed {seed} {method}, {steps} steps: {found:?} for {low} to {high}"
            );
        }
    }
}
