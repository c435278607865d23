//! Scenes with known answers, and the way through their steps.

use fracas::nonlinear::{FaceFields, Simulation, State, StepRecord};
use fracas::scene::{Body, Scene};
use fracas_solvers::Silent;

/// The body of a scene with these keys replaced.
pub(crate) fn body(toml: &str, overrides: &[&str]) -> Body {
    let scene = Scene::from_toml(toml, "scene.toml").unwrap();
    scene.with_overrides(overrides).unwrap().build().unwrap()
}

/// Runs to the end; what `visit` sees is every accepted step.
pub(crate) fn run(body: &Body, mut visit: impl FnMut(&State, &FaceFields, &StepRecord)) {
    let mut simulation = Simulation::new(body).unwrap();
    let end = simulation.run(&mut Silent, |simulation, _, done| {
        for event in &done.events {
            println!("{event:?}");
        }
        println!("{:?}", done.record);
        let fields = simulation.face_fields(&done.state);
        visit(&done.state, &fields, &done.record);
    });
    if let Err(failure) = end {
        panic!("{failure}");
    }
}

/// Two blocks of heights 1 and 2 m, only u_x(z) free, sheared forth and back at the top.
pub(crate) const SLIDING: &str = r#"
title = "Block sliding"
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
cohesion = "1 MPa"
[initial_stress]
constant = { xx = "-10 MPa", yy = "-10 MPa", zz = "-10 MPa" }
[[boundary]]
side = "x-"
displacement = { y = "0 m", z = "0 m" }
[[boundary]]
side = "x+"
displacement = { y = "0 m", z = "0 m" }
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
displacement = { x = "6 mm", y = "0 m", z = "0 m" }
history = [["0 s", 0.0], ["1 s", 1.0], ["3 s", -1.0], ["5 s", 1.0]]
[time]
end = "5 s"
steps = 20
[solver]
tolerance = 1e-13
"#;

/// A block on a plane of 45 deg that is pushed down and cannot but slide.
pub(crate) const PASSING: &str = r#"
title = "Passing crack"
[mesh]
x = { from = "-1 m", to = "1 m", cells = 6 }
y = { from = "0 m", to = "1 m", cells = 2 }
z = { from = "-2 m", to = "2 m", cells = 8 }
[mesh.map.incline]
plane = "z"
along = "x"
tilt = "45 deg"
fade = true
pivot = ["0 m", "0.5 m", "0 m"]
[[material]]
name = "rock"
young = "10 GPa"
poisson = 0.2
[[fracture]]
name = "cut"
plane = "z"
at = "0 m"
friction_angle = "30 deg"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "z-"
hold = "fixed"
[[boundary]]
side = "z+"
displacement = { z = "-0.1 m" }
[solver]
tolerance = 1e-11
"#;

/// Closed, sliding, open and back.
pub(crate) const CYCLE: &str = r#"
title = "Cycle of states"
[mesh]
x = { from = "-4 m", to = "4 m", cells = 4 }
y = { from = "0 m", to = "20 m", cells = 5 }
z = { from = "0 m", to = "20 m", cells = 5 }
[[material]]
name = "rock"
young = "5 GPa"
poisson = 0.25
[[fracture]]
name = "cut"
plane = "x"
at = "0 m"
friction_angle = "30 deg"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
displacement = { x = "-1 mm" }
history = [["0 s", 1.0], ["5 s", -1.0], ["10 s", 1.0]]
[[boundary]]
side = "x+"
displacement = { z = "1 mm", y = "0 m" }
history = [["0 s", 0.0], ["2 s", 1.0], ["8 s", 1.0], ["10 s", 0.0]]
[time]
end = "10 s"
steps = 10
"#;
