//! Claim: faults of many faces whose slip runs away come to rest where the scene asks for it, whatever the weakening distance, tips or
//! not, one or two of them, and give no energy.
//!
//! `FRACAS_RUNS=100 FRACAS_SEED=1000 cargo test --release --test contact arrested:: -- --nocapture` tries more.

use crate::scenes::body;
use crate::unstable::{asked, runs};
use fracas::nonlinear::Simulation;
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// A fault of many faces or two of them, through the rock or with tips, that weakens over 0.3 to 20 mm.
fn faults(seed: u64) -> String {
    let random = &mut Random::new(seed);
    let tips = match random.chance(0.4) {
        true => "",
        false => "z = [\"1 m\", \"5 m\"]\n",
    };
    let [friction, dynamic] = [random.between(25.0, 35.0), random.between(3.0, 15.0)];
    let (distance, two) = (random.scale(0.3, 20.0), random.chance(0.4));
    let fault = |name: &str, at: f64, distance: f64| {
        format!(
            "[[fracture]]\nname = \"{name}\"\nplane = \"x\"\nat = \"{at} m\"\n{tips}friction_angle = \"{friction} deg\"\ndynamic_friction_angle = \"{dynamic} deg\"\nweakening_distance = \"{distance} mm\"\n"
        )
    };
    let one = fault("fault", if two { 1.0 } else { 2.0 }, distance);
    let other = distance * random.between(0.5, 2.0);
    let other = if two {
        fault("other", 3.0, other)
    } else {
        String::new()
    };
    let (shear, steps) = (random.between(0.01, 0.03), random.one_of(&[5, 10, 20]));
    format!(
        r#"
title = "faults"
[mesh]
x = {{ from = "0 m", to = "4 m", cells = 4 }}
y = {{ from = "0 m", to = "4 m", cells = 4 }}
z = {{ from = "0 m", to = "6 m", cells = 6 }}
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.25
{one}{other}
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
displacement = {{ x = "-4 mm", y = "0 m" }}
history = [["0 s", 1.0]]
[[boundary]]
side = "x+"
displacement = {{ z = "{shear} m" }}
history = [["0 s", 0.0], ["1 s", 1.0]]
[time]
end = "1 s"
steps = {steps}
[solver]
inner = "exact"
unstable = "arrest"
"#
    )
}

/// Next to the critical load K − W is nearly singular, past it indefinite, and states follow the slip: nineteen of twenty runs come to
/// their last load, where every face in slip bears its limit, and no fault has given energy.
#[test]
fn faults_of_many_faces_come_to_rest() {
    let first = asked("FRACAS_SEED", 0);
    let (mut finished, mut arrested) = (0, 0);
    for seed in first..first + runs() {
        let body = body(&faults(seed), &[]);
        let mut simulation = Simulation::new(&body).unwrap();
        let end = simulation.run(&mut Silent, |simulation, before, done| {
            arrested += usize::from(done.record.arrested);
            let (fields, t) = (simulation.face_fields(&done.state), &done.state.t);
            for (f, limit) in fields.tau_limit.iter().enumerate() {
                let shear = t[3 * f + 1].hypot(t[3 * f + 2]);
                let slips = fields.criticality[f] == 1.0;
                let beyond = if slips {
                    (shear - limit).abs()
                } else {
                    shear - limit
                };
                let zero = 1e-5 * done.state.traction;
                assert!(beyond <= zero, "seed {seed}, face {f}: {shear} {limit}");
            }
            for fault in simulation.faults(before, &done.state) {
                let rounding = 1e-12 * fault.shear_force * fault.slip_max;
                let d = fault.dissipated;
                assert!(d >= -rounding, "seed {seed}, {}: {d}", fault.name);
            }
        });
        match end {
            Ok(_) => finished += 1,
            Err(failure) => println!("seed {seed}: {failure}"),
        }
    }
    println!(
        "{finished} of {} finish, {arrested} steps are arrested",
        runs()
    );
    assert!(20 * finished >= 19 * runs(), "{finished} of {}", runs());
    assert!(arrested > 0, "nothing runs away");
}
