//! Claim: friction that follows the slip heals where a face slips back, friction that follows its path does not; both as closed forms say, and
//! as one where slip never turns.

use crate::scenes::body;
use crate::unstable::Case;
use fracas::analytic::BlockSliding;
use fracas::contact::Friction;
use fracas::nonlinear::Simulation;
use fracas::scene::Body;
use fracas_solvers::Silent;

/// Slip and its path where the top of two blocks stands at some displacement.
#[derive(Clone, Copy, Debug, Default)]
struct Slid {
    slip: f64,
    path: f64,
}

impl Slid {
    /// The state after the top has moved on to `top` without turning: `k (U − g) = ± L(s)` by bisection.
    fn moved(self, blocks: BlockSliding, friction: Friction, by_path: bool, top: f64) -> Self {
        let stiffness = blocks.shear / (blocks.heights[0] + blocks.heights[1]);
        for sign in [1.0, -1.0] {
            let at = |d: f64| Self {
                slip: self.slip + sign * d,
                path: self.path + d,
            };
            let excess = |d: f64| {
                let now = at(d);
                let s = if by_path { now.path } else { now.slip.abs() };
                sign * stiffness * (top - now.slip) - friction.limit(-blocks.compression, s)
            };
            if excess(0.0) <= 0.0 {
                continue;
            }
            let (mut low, mut high) = (0.0, (top - self.slip).abs());
            while 0.5 * (low + high) > low && 0.5 * (low + high) < high {
                let middle = 0.5 * (low + high);
                match excess(middle) > 0.0 {
                    true => low = middle,
                    false => high = middle,
                }
            }
            return at(low);
        }
        self
    }
}

fn sheared(case: &Case, method: &str, by: &str) -> Body {
    let by = format!("fracture.0.weakening_by={by}");
    case.body(method, &[&by, "time.end=5 s", "time.steps=20"])
}

/// Blocks that weaken more slowly than the rock is stiff, sheared forth and back and forth again.
#[test]
fn a_reversed_cycle_follows_the_closed_form() {
    let mut weaker = 0;
    for seed in 0..12 {
        let case = Case::new(seed, [0.05, 0.9]);
        let stiffness = case.blocks.shear / (case.blocks.heights[0] + case.blocks.heights[1]);
        let scale = stiffness * case.end;
        for method in ["lagrange", "{augmented_lagrangian={factor=1e2}}"] {
            let mut ends = Vec::new();
            for by in ["slip", "path"] {
                let (body, by_path) = (sheared(&case, method, by), by == "path");
                let friction = body.friction_of(&body.fractures.faces[0]).unwrap();
                let along = body.fractures.faces[0].frame;
                let mut simulation = Simulation::new(&body).unwrap();
                let mut now = Slid::default();
                let end = simulation.run(&mut Silent, |simulation, before, done| {
                    let state = &done.state;
                    let top = case.end * body.histories[1].at(state.time);
                    now = now.moved(case.blocks, friction, by_path, top);
                    let along_x = |v: &[f64]| (0..3).map(|k| v[k] * along[k][0]).sum::<f64>();
                    let fields = simulation.face_fields(state);
                    let (t, g) = (along_x(&fields.traction), along_x(&fields.jump));
                    let what = format!("seed {seed} {method} {by}, t = {}", state.time);
                    let shear = stiffness * (top - now.slip);
                    assert!((t - shear).abs() < 1e-6 * scale, "{what}: {t} for {shear}");
                    assert!(
                        (g - now.slip).abs() < 1e-6 * case.end,
                        "{what}: {g} for {now:?}"
                    );
                    let record = &simulation.faults(before, state)[0];
                    match by_path {
                        true => {
                            let path = fields.path[0];
                            assert!((path - now.path).abs() < 2e-6 * case.end, "{what}: {path}");
                            assert_eq!((record.path_mean, record.path_max), (path, path));
                        }
                        false => assert!(fields.path.is_empty() && state.path.is_empty()),
                    }
                });
                ends.push((simulation.face_fields(&end.unwrap()), now));
            }
            let [(heals, _), (path, own)] = &ends[..] else {
                unreachable!()
            };
            assert!(
                path.tau_limit[0] <= heals.tau_limit[0] * (1.0 + 1e-6),
                "seed {seed}"
            );
            let turned = own.path > 1.05 * own.slip.abs();
            weaker += usize::from(turned && path.tau_limit[0] < 0.999 * heals.tau_limit[0]);
        }
    }
    assert!(weaker >= 8, "{weaker} ends are weaker by the path");
}

/// A fault through rock whose load only grows, several faces of different slip.
const GROWING: &str = r#"
title = "Fault that weakens under a growing load"
[mesh]
x = { from = "-16 m", to = "16 m", cells = 8 }
y = { from = "0 m", to = "2 m", cells = 2 }
z = { from = "-4 m", to = "4 m", cells = 8 }
[mesh.map.incline]
plane = "x"
tilt = "30 deg"
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
dynamic_friction_angle = "12 deg"
weakening_distance = "15 mm"
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
history = [["0 s", 1], ["1 s", 12]]
[time]
end = "1 s"
steps = 6
[solver]
tolerance = 1e-11
"#;

/// The end of a run, and how often a step was cut.
fn end(body: &Body) -> (Vec<f64>, Vec<f64>) {
    let mut simulation = Simulation::new(body).unwrap();
    let end = simulation.run(&mut Silent, |_, _, _| {}).unwrap();
    let fields = simulation.face_fields(&end);
    assert!(
        fields
            .path
            .iter()
            .zip(&fields.slip)
            .all(|(path, slip)| path >= slip)
    );
    (fields.traction, fields.slip)
}

#[test]
fn slip_that_never_turns_weakens_alike() {
    for method in [
        "lagrange",
        "{penalty={factor=1e3}}",
        "{augmented_lagrangian={factor=1e2}}",
    ] {
        let method = format!("solver.method={method}");
        let ends = ["slip", "path"].map(|by| {
            let by = format!("fracture.0.weakening_by={by}");
            end(&body(GROWING, &[&method, &by, "solver.tolerance=1e-10"]))
        });
        let [(t, slip), (t_path, slip_path)] = &ends;
        let largest = |v: &[f64]| v.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let apart = |a: &[f64], b: &[f64]| {
            let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            largest(&difference) / largest(a)
        };
        let [traction, gone] = [apart(t, t_path), apart(slip, slip_path)];
        println!("{method}: {traction:e} {gone:e}, {:e} m", largest(slip));
        assert!(largest(slip) > 1e-3, "{:e}", largest(slip));
        assert!(
            traction < 1e-5 && gone < 1e-5,
            "{method}: {traction:e} {gone:e}"
        );
    }
}

/// Slip that runs away comes to rest in one place, whichever slip friction follows.
#[test]
fn slip_that_runs_away_rests_alike() {
    for seed in 0..8 {
        let case = Case::new(seed, [1.2, 4.0]);
        for method in ["lagrange", "{augmented_lagrangian={factor=1e2}}"] {
            let ends = ["slip", "path"].map(|by| {
                let by = format!("fracture.0.weakening_by={by}");
                end(&case.body(method, &[&by, "solver.unstable=arrest"]))
            });
            let [(_, slip), (_, path)] = &ends;
            let apart = (slip[0] - path[0]).abs();
            assert!(
                slip[0] > 0.0 && apart < 1e-5 * slip[0],
                "seed {seed} {method}: {slip:?} {path:?}"
            );
        }
    }
}
