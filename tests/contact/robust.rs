//! Claim: whatever the friction, contrast, steps and crossings, a run converges or ends with a typed reason and a good last
//! state; few rounds of the active set do; a Newton step in slip or opening takes at most half again as many Krylov iterations
//! as one in stick.

use fracas::nonlinear::{Event, Failure, Simulation};
use fracas::scene::{Scene, SolverSection};
use fracas_operators::random::Random;
use fracas_solvers::{Silent, Step};
use std::ops::ControlFlow;

/// A scene that the seed alone decides.
fn scene(seed: u64) -> String {
    let r = &mut Random::new(seed.wrapping_mul(0x2545_F491_4F6C_DD1D) + 1);
    let (nx, ny, nz) = (r.whole(4, 6), r.whole(2, 4), r.whole(4, 6));
    let mut toml = format!(
        "title = 'seed {seed}'\n[mesh]\nx = {{ from = '0 m', to = '{nx} m', cells = {nx} }}\n\
         y = {{ from = '0 m', to = '{ny} m', cells = {ny} }}\nz = {{ from = '0 m', to = '{nz} m', cells = {nz} }}\n"
    );
    if r.chance(0.5) {
        let dip = r.between(60.0, 90.0);
        toml += &format!(
            "[mesh.map.incline]\nplane = 'x'\ndip = '{dip} deg'\nfade = {}\n",
            r.chance(0.5)
        );
    }
    let contrast = 10f64.powf(r.between(-4.0, 4.0));
    toml += "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = 0.25\n";
    toml += &format!(
        "[[material]]\nname = 'layer'\nyoung = '{} Pa'\npoisson = {}\nlayers = [['0 m', '{} m']]\n",
        1e10 * contrast,
        r.between(0.0, 0.45),
        nz / 2
    );
    let crossing = r.chance(0.5);
    let friction = |r: &mut Random| {
        format!(
            "friction_angle = '{} deg'\ncohesion = '{} MPa'\n",
            r.between(0.0, 1.2).atan().to_degrees(),
            if r.chance(0.5) {
                0.0
            } else {
                r.between(0.0, 2.0)
            }
        )
    };
    toml += &format!(
        "[[fracture]]\nname = 'fault'\nplane = 'x'\nat = '{} m'\n{}",
        nx / 2,
        friction(r)
    );
    if r.chance(0.3) {
        toml += &format!("z = ['1 m', '{} m']\n", nz - 1);
    }
    if r.chance(0.2) {
        toml += "dynamic_friction_angle = '5 deg'\nweakening_distance = '5 mm'\n";
    }
    if crossing {
        toml += &format!(
            "[[fracture]]\nname = 'bed'\nplane = 'z'\nat = '{} m'\n{}",
            nz / 2,
            friction(r)
        );
    }
    let move_by = |r: &mut Random| format!("'{} mm'", r.between(-3.0, 3.0));
    toml += "[[boundary]]\nside = 'z-'\nhold = 'fixed'\n";
    match r.whole(0, 2) {
        0 => {
            toml += &format!(
                "[[boundary]]\nside = 'z+'\ndisplacement = {{ x = {}, z = {} }}\n",
                move_by(r),
                move_by(r)
            );
        }
        1 => {
            toml += &format!(
                "[[boundary]]\nside = 'z+'\ntraction = {{ x = '{} MPa', z = '{} MPa' }}\n",
                r.between(-4.0, 4.0),
                r.between(-10.0, 1.0)
            );
        }
        _ => {
            toml += &format!(
                "[[boundary]]\nside = 'z+'\npressure = '{} MPa'\n",
                r.between(0.0, 10.0)
            )
        }
    }
    toml += "history = [['0 s', 0.2], ['4 s', 1.0], ['7 s', -0.5], ['10 s', 1.0]]\n";
    // without it blocks may be free once fractures open
    if r.chance(0.8) {
        toml += &format!(
            "[[boundary]]\nside = 'x+'\npressure = '{} MPa'\n",
            r.between(0.0, 10.0)
        );
        toml += "[[boundary]]\nside = 'y-'\nhold = 'roller'\n[[boundary]]\nside = 'x-'\nhold = 'roller'\n";
    } else {
        toml += "[[boundary]]\nside = 'x-'\nhold = 'roller'\n";
    }
    let steps = [1, 2, 3, 5, 10, 20, 50][r.whole(0, 6) as usize];
    toml + &format!("[time]\nend = '10 s'\nsteps = {steps}\n")
}

/// A network in rock under its own weight that the seed alone decides: one to four fractures that cross, dips, depletion,
/// gravity and initial stress, fluid pressure, weakening, sides that go forth and back; 400 to 1,800 displacements, and eight
/// times as many where `FRACAS_FINER` is 2 (cells of 5 m in place of 10 m).
fn network(seed: u64) -> String {
    network_in(variable("FRACAS_FINER", 1), seed)
}

/// The same with so many cells on 10 m.
fn network_in(finer: u64, seed: u64) -> String {
    let r = &mut Random::new(seed.wrapping_mul(0x9E6D_62D0_6F6A_9A9B) + 1);
    let cells = [r.whole(5, 12), r.whole(2, 4), r.whole(5, 12)];
    let mut toml = format!("title = 'network {seed}'\n[solver]\ninner = 'exact'\n[mesh]\n");
    for (axis, n) in ["x", "y", "z"].iter().zip(cells) {
        toml += &format!(
            "{axis} = {{ from = '0 m', to = '{} m', cells = {} }}\n",
            10 * n,
            finer * u64::from(n)
        );
    }
    if r.chance(0.5) {
        let dip = r.between(60.0, 90.0);
        let fade = r.chance(0.7);
        toml += &format!("[mesh.map.incline]\nplane = 'x'\ndip = '{dip} deg'\nfade = {fade}\n");
    }
    let depleted = |r: &mut Random| {
        let change = r.between(-15.0, 5.0);
        format!(
            "pressure_change = '{change} MPa'\nbiot = 0.9\npressure_history = [['0 s', 0], ['10 s', 1]]\n"
        )
    };
    let rock = |r: &mut Random, young: f64| {
        format!(
            "young = '{young} GPa'\npoisson = {}\ndensity = '2500 kg/m3'\n",
            r.between(0.05, 0.4)
        )
    };
    toml += &format!("[[material]]\nname = 'rock'\n{}", rock(r, 10.0));
    if r.chance(0.6) {
        let young = 10.0 * 10f64.powf(r.between(-1.0, 1.0));
        let (low, high) = (
            r.whole(0, cells[2] / 2),
            r.whole(cells[2] / 2 + 1, cells[2]),
        );
        toml += &format!(
            "[[material]]\nname = 'layer'\n{}layers = [['{} m', '{} m']]\n",
            rock(r, young),
            10 * low,
            10 * high
        );
        if r.chance(0.6) {
            toml += &depleted(r);
        }
    }
    // through the body or ending inside it, at different lines
    let mut taken = Vec::new();
    for k in 0..r.whole(1, 4) {
        let axis = [0, 2, 2, 0, 1][r.whole(0, 4) as usize];
        let at = r.whole(1, cells[axis] - 1);
        if taken.contains(&(axis, at)) {
            continue;
        }
        taken.push((axis, at));
        let name = |axis: usize| ["x", "y", "z"][axis];
        toml += &format!(
            "[[fracture]]\nname = 'f{k}'\nplane = '{}'\nat = '{} m'\nfriction_angle = '{} deg'\ncohesion = '{} MPa'\n",
            name(axis),
            10 * at,
            r.between(0.0, 1.0).atan().to_degrees(),
            if r.chance(0.5) {
                0.0
            } else {
                r.between(0.0, 2.0)
            }
        );
        let across = if axis == 0 { 2 } else { 0 };
        if r.chance(0.5) && cells[across] > 4 {
            let from = r.whole(0, 2);
            let to = cells[across] - r.whole(1, 2);
            toml += &format!("{} = ['{} m', '{} m']\n", name(across), 10 * from, 10 * to);
        }
        if r.chance(0.3) {
            toml += &format!(
                "dynamic_friction_angle = '3 deg'\nweakening_distance = '{} mm'\n",
                10f64.powf(r.between(0.5, 2.0))
            );
        }
        if r.chance(0.3) {
            toml += &format!(
                "pressure = '{} MPa'\npressure_history = [['0 s', 0], ['6 s', 1], ['10 s', 0.3]]\n",
                r.between(0.0, 6.0)
            );
        }
    }
    let weight = r.chance(0.7);
    let lateral = r.between(0.3, 0.9);
    let buried = r.between(2.0, 20.0);
    if weight {
        toml += "[gravity]\nz = '-9.81 m/s2'\n";
    }
    let gradient = if weight { 2500.0 * 9.81 } else { 0.0 };
    toml += &format!(
        "[initial_stress]\nreference = '{} m'\nconstant = {{ xx = '{} MPa', yy = '{} MPa', zz = '{} MPa' }}\n\
         gradient = {{ xx = '{} Pa/m', yy = '{} Pa/m', zz = '{} Pa/m' }}\n",
        10 * cells[2],
        -lateral * buried,
        -lateral * buried,
        -buried,
        lateral * gradient,
        lateral * gradient,
        gradient
    );
    toml += "[[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'x-'\nhold = 'roller'\n[[boundary]]\nside = 'y-'\nhold = 'roller'\n[[boundary]]\nside = 'y+'\nhold = 'roller'\n";
    toml += &format!("[[boundary]]\nside = 'z+'\npressure = '{buried} MPa'\n");
    let there_and_back = "history = [['0 s', 0], ['3 s', 1], ['6 s', -0.7], ['10 s', 1]]\n";
    match r.whole(0, 2) {
        0 => {
            toml += &format!(
                "[[boundary]]\nside = 'x+'\ndisplacement = {{ x = '{} mm', z = '{} mm' }}\n{there_and_back}",
                r.between(-40.0, 20.0),
                r.between(-40.0, 40.0)
            );
        }
        1 => {
            toml += &format!(
                "[[boundary]]\nside = 'x+'\ndisplacement = {{ x = '{} mm' }}\n{there_and_back}",
                r.between(-40.0, 20.0)
            );
        }
        _ => {
            toml += &format!(
                "[[boundary]]\nside = 'x+'\npressure = '{} MPa'\n",
                lateral * buried
            );
            toml += &format!(
                "[[boundary]]\nside = 'x+'\ntraction = {{ x = '{} MPa', z = '{} MPa' }}\n{there_and_back}",
                r.between(-4.0, 4.0),
                r.between(-4.0, 4.0)
            );
        }
    }
    toml + &format!("[time]\nend = '10 s'\nsteps = {}\n", r.whole(3, 12))
}

#[derive(Default)]
pub(crate) struct Tally {
    runs: usize,
    refused: usize,
    finished: usize,
    failed: Vec<(u64, Failure)>,
    /// Largest violation of Coulomb's limit or of the direction of slip, relative to the largest traction.
    violation: f64,
    steps: usize,
    cut: usize,
    cycles: usize,
    /// Rounds of a step in which some face changed its state, failed attempts included.
    changes: Vec<usize>,
    /// Krylov iterations per Newton step, over those of the all-stick systems of the run.
    growth: Vec<f64>,
    /// The same per digit.
    growth_per_digit: Vec<f64>,
    solves: usize,
    iterations: usize,
    setups: usize,
}

/// What the systems of a run took, all together.
#[derive(Default)]
struct Work {
    systems: f64,
    iterations: f64,
    digits: f64,
}

/// The value that a share of the sorted values does not exceed.
fn quantile<T: Copy>(sorted: &[T], share: f64) -> T {
    assert!(!sorted.is_empty() && share < 1.0, "no value");
    sorted[(share * sorted.len() as f64) as usize]
}

fn run(scene: fn(u64) -> String, seed: u64, tally: &mut Tally) {
    tally.runs += 1;
    let text = scene(seed);
    if let Some(folder) = std::env::var_os("FRACAS_SCENES") {
        let name = format!("seed_{seed}.toml");
        std::fs::write(std::path::Path::new(&folder).join(name), &text).unwrap();
    }
    let clock = std::time::Instant::now();
    let Ok(body) = Scene::from_toml(&text, "scene.toml").unwrap().build() else {
        // an incline that turns cells over, a block that nothing holds: said before anything is solved
        tally.refused += 1;
        return;
    };
    if (body.constraints.free_len() as u64) < variable("FRACAS_AT_LEAST", 0) {
        tally.runs -= 1;
        return;
    }
    let first = tally.changes.len();
    let mut simulation = Simulation::new(&body).unwrap();
    let mut state = simulation.initial_state();
    let (mut stick, mut other) = (Work::default(), Work::default());
    while state.step == 0 || !simulation.is_finished(&state) {
        let mut changes = 0;
        let mut count = |step: &Step| {
            changes += usize::from(matches!(step, Step::Round { changed: 1.., .. }));
            ControlFlow::Continue(())
        };
        match simulation.advance(&state, &mut count) {
            Ok(done) => {
                for l in &done.linear {
                    let work = if l.faces[1..] == [0, 0, 0] {
                        &mut stick
                    } else {
                        &mut other
                    };
                    work.systems += 1.0;
                    work.iterations += l.iterations as f64;
                    work.digits -= l.relative_residual.max(1e-16).log10();
                    tally.solves += 1;
                    tally.iterations += l.iterations;
                    tally.setups += usize::from(l.setup);
                }
                let record = done.record;
                assert!(record.max_tau_viol.is_finite() && record.max_pen.is_finite());
                let shear = record.max_tau_viol / done.state.traction.max(f64::MIN_POSITIVE);
                let violation = shear.max(record.max_slip_viol);
                tally.violation = tally.violation.max(violation);
                tally.steps += 1;
                tally.cut += usize::from(record.cuts > 0);
                tally.cycles += done
                    .events
                    .iter()
                    .filter(|e| matches!(e, fracas::nonlinear::Event::Cycle { .. }))
                    .count();
                tally.changes.push(changes);
                assert!(
                    done.state
                        .u
                        .iter()
                        .chain(&done.state.t)
                        .all(|v| v.is_finite())
                );
                state = done.state;
            }
            Err(failure) => {
                let reason = &failure.reason;
                assert!(
                    !matches!(reason, Failure::NotFinite { .. } | Failure::Stopped),
                    "seed {seed}: {reason}"
                );
                println!(
                    "seed {seed} ended after {:.1?}, rounds {:?}: {failure}",
                    clock.elapsed(),
                    &tally.changes[first..]
                );
                tally.failed.push((seed, failure.reason));
                return;
            }
        }
    }
    println!(
        "seed {seed} finished after {:.1?}, rounds {:?}",
        clock.elapsed(),
        &tally.changes[first..]
    );
    tally.finished += 1;
    if stick.systems > 0.0 && other.systems > 0.0 {
        let growth = |per: fn(&Work) -> f64| {
            (other.iterations / per(&other)) / (stick.iterations / per(&stick))
        };
        tally.growth.push(growth(|work| work.systems));
        tally.growth_per_digit.push(growth(|work| work.digits));
    }
}

pub(crate) fn sweep(scene: fn(u64) -> String, seeds: std::ops::Range<u64>) -> Tally {
    let mut tally = Tally::default();
    seeds.for_each(|seed| run(scene, seed, &mut tally));
    tally.changes.sort_unstable();
    tally.growth.sort_by(f64::total_cmp);
    tally.growth_per_digit.sort_by(f64::total_cmp);
    println!(
        "{} runs, {} refused, {} finished, {} ended with a reason; {} steps, {} cut, {} cycles, friction violated by {:.1e}; rounds with changes median {}, 95 % {}, most {}; growth median {:.2}, 95 % {:.2}, per digit {:.2}, {:.2}; {} iterations, {} solves, {} set-ups",
        tally.runs,
        tally.refused,
        tally.finished,
        tally.failed.len(),
        tally.steps,
        tally.cut,
        tally.cycles,
        tally.violation,
        quantile(&tally.changes, 0.5),
        quantile(&tally.changes, 0.95),
        tally.changes[tally.changes.len() - 1],
        quantile(&tally.growth, 0.5),
        quantile(&tally.growth, 0.95),
        quantile(&tally.growth_per_digit, 0.5),
        quantile(&tally.growth_per_digit, 0.95),
        tally.iterations,
        tally.solves,
        tally.setups,
    );
    tally
}

/// All runs but one in `one_in` finish or end by a loss of equilibrium that is shown: a body that nothing holds, or slip that
/// runs away. No accepted slip goes against its traction, and no shear is above its limit.
pub(crate) fn ends_in_a_known_way(tally: &Tally, one_in: usize) {
    let shown = |(_, reason): &&(u64, Failure)| {
        matches!(reason, Failure::Loose { .. } | Failure::Unstable(_))
    };
    let other = tally.failed.iter().filter(|r| !shown(r)).count();
    let runs = tally.finished + tally.failed.len();
    assert!(
        one_in * other <= runs,
        "{other} of {runs} runs end for another reason than a loss of equilibrium"
    );
    let most = SolverSection::default().state_tolerance;
    assert!(tally.violation <= most, "{}", tally.violation);
}

/// Runs that end without equilibrium end because a body is held by nothing, or by slipping faces alone, but for a few; nearly
/// all steps take few rounds.
fn ends_well(tally: &Tally) {
    ends_in_a_known_way(tally, 20);
    let changes = quantile(&tally.changes, 0.95);
    assert!(
        changes <= 10,
        "{changes} rounds with changes in 95 % of the steps"
    );
    // slip is solved to fewer digits than stick
    let growth = quantile(&tally.growth, 0.95);
    assert!(
        growth <= 1.51,
        "{growth} times the iterations of stick in 95 % of the runs"
    );
}

/// Seeds from `FRACAS_SEED` on, `FRACAS_RUNS` of them.
pub(crate) fn asked(runs: u64) -> std::ops::Range<u64> {
    let first = variable("FRACAS_SEED", 0);
    first..first + variable("FRACAS_RUNS", runs)
}

/// The number that an environment variable holds.
fn variable(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |value| value.parse().unwrap())
}

#[test]
fn runs_of_every_kind_end_well() {
    ends_well(&sweep(scene, 0..20));
}

/// The full sweep: `cargo test --release --test contact robust:: -- --ignored --nocapture five`.
#[test]
#[ignore = "minutes"]
fn five_hundred_runs_end_well() {
    ends_well(&sweep(scene, 0..500));
}

/// Seeds that no setting was chosen by.
#[test]
#[ignore = "minutes"]
fn five_hundred_others_end_well() {
    ends_well(&sweep(scene, 1000..1500));
}

/// `FRACAS_RUNS=1000 FRACAS_SEED=0 cargo test --release --test contact robust:: -- --nocapture networks` for the full sweep;
/// `FRACAS_SCENES=folder` keeps its scenes there, `FRACAS_FINER=2` doubles the cells of every side, and `FRACAS_AT_LEAST=5000` leaves out
/// bodies of fewer displacements.
#[test]
fn networks_end_well() {
    let seeds = asked(6);
    let tally = sweep(network, seeds);
    // of few runs none ends otherwise, of many one in a hundred may
    ends_in_a_known_way(&tally, 100);
    let changes = quantile(&tally.changes, 0.95);
    assert!(
        changes <= 10,
        "{changes} rounds with changes in 95 % of the steps"
    );
}

/// Faces that open under weakening slip first in states that are no equilibrium: whether that slip runs away cannot be computed where
/// their tangent has no inverse. That is told, and the step, which is solved, stands.
#[test]
fn what_cannot_be_known_of_stability_is_told_and_the_step_stands() {
    let body = Scene::from_toml(&network(130_415), "scene.toml")
        .unwrap()
        .build()
        .unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let mut unknown = 0;
    let end = simulation.run(&mut Silent, |_, _, done| {
        let is_unknown = |e: &&Event| matches!(e, Event::Unknown { .. });
        unknown += done.events.iter().filter(is_unknown).count();
    });
    assert!(end.is_ok());
    assert!(unknown > 0);
}

/// Next to a load at which slip runs away, rounds go back and forth between states in which faces that have come to their limit slip, so that
/// they slip backwards, and states in which they stick: the former are those that show why no state settles.
#[test]
fn slip_that_runs_away_is_shown_where_the_last_states_show_nothing() {
    let scene = Scene::from_toml(&network_in(2, 300_542), "scene.toml");
    let body = scene.unwrap().build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let failure = simulation.run(&mut Silent, |_, _, _| {}).unwrap_err();
    let Failure::Unstable(patch) = failure.reason else {
        panic!("{failure}");
    };
    assert!(!patch.settled && patch.ratio > 1.0, "{patch}");
}
