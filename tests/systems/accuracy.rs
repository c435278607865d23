//! Claim: what an iteration calls converged has u and t within ten tolerances of the exact solution, whatever the contrast, the
//! cells, Poisson's ratio, loads or displacements, and the inner solver; it refuses few solutions that are better than it can show.
//!
//! `ACCURACY_CASES=400 ACCURACY_SEED=7 cargo test --release --test systems accuracy:: -- --nocapture` tries more systems;
//! `ACCURACY_SKIP=192` begins with the case of that number. The scene of a wrong one is printed.

use super::reference::reference;
use fracas::contact::JumpStabilization;
use fracas::matrix_free::{MatrixFreeSaddle, RacpParts};
use fracas::scene::{Body, Scene};
use fracas_operators::random::Random;
use fracas_operators::{Fields, LinearOperator, Preconditioner};
use fracas_solvers::Silent;
use fracas_solvers::krylov::{Breakdown, Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::saddle::{
    Accurate, EnergyNorms, Measure, Racp, SaddleMethod, SaddleOperator, StrainNorm, T, U,
    solve_accurately,
};
use std::borrow::Cow;

/// Tolerances, each for all four inner solvers in turn.
const TOLERANCES: [f64; 4] = [1e-8, 1e-3, 1e-8, 1e-5];

/// Systems tried where nobody asks for more.
const CASES: u64 = 48;

/// Seed and number of a scene in which stiff rock, all but incompressible, is moved along two axes and free along the third, where soft rock alone
/// holds it: rounding of its forces there was not seen.
const ROUNDED: [(u64, u64); 1] = [(9191, 192)];

/// Seeds and numbers of flat scenes whose errors were not seen: modes of C_0 + H among others that C follows, and jumps along flat cells.
const WRONG_ONCE: [(u64, u64); 3] = [(802, 173), (802, 303), (803, 119)];

/// Inner solvers; `geometric` is set up from the body.
const INNER: [&str; 4] = ["exact", "amg", "fsai", "geometric"];

pub(super) fn environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |value| value.parse().unwrap())
}

/// Layers of contrast 1e±8, cells up to 1:1000, ν up to 0.4999, one or two cuts, pressed or displaced from above.
pub(super) fn scene(seed: u64) -> String {
    let r = &mut Random::new(seed);
    let cells = [r.whole(4, 6), r.whole(3, 5), r.whole(4, 6)];
    let mut toml = format!("title = 'seed {seed}'\n[mesh]\n");
    let thin = r.whole(0, 2) as usize;
    let ratio = match r.chance(0.5) {
        true => 10f64.powf(r.between(0.0, 3.0)),
        false => 1.0,
    };
    let spacing = [0, 1, 2].map(|d: usize| if d == thin { 1.0 / ratio } else { 1.0 });
    for (d, axis) in ["x", "y", "z"].iter().enumerate() {
        let (n, h) = (cells[d], spacing[d]);
        toml += &format!(
            "{axis} = {{ from = '0 m', to = '{} m', cells = {n} }}\n",
            f64::from(n) * h
        );
    }
    let poisson = |r: &mut Random| match r.chance(0.25) {
        true => 0.5 - 10f64.powf(r.between(-4.0, -1.0)),
        false => r.between(0.0, 0.4),
    };
    let contrast = match r.chance(0.7) {
        true => 10f64.powf(r.between(-8.0, 8.0)),
        false => 1.0,
    };
    let at = |d: usize, line: u32| f64::from(line) * spacing[d];
    toml += &format!(
        "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = {}\n",
        poisson(r)
    );
    toml += &format!(
        "[[material]]\nname = 'layer'\nyoung = '{} Pa'\npoisson = {}\nlayers = [['{} m', '{} m']]\n",
        1e10 * contrast,
        poisson(r),
        at(2, 1),
        at(2, r.whole(2, cells[2] - 1)),
    );
    toml += &format!(
        "[[fracture]]\nname = 'a'\nplane = 'x'\nat = '{} m'\nfriction_angle = '30 deg'\n",
        at(0, 2)
    );
    if r.chance(0.5) {
        toml += &format!("z = ['0 m', '{} m']\n", at(2, cells[2] - 1));
    }
    if r.chance(0.5) {
        toml += &format!(
            "[[fracture]]\nname = 'b'\nplane = 'y'\nat = '{} m'\nfriction_angle = '30 deg'\n",
            at(1, 1)
        );
    }
    toml += "[[boundary]]\nside = 'z-'\nhold = 'fixed'\n";
    let top = at(2, cells[2]);
    toml += &match r.chance(0.5) {
        true => format!(
            "[[boundary]]\nside = 'z+'\ndisplacement = {{ x = '{} m', z = '{} m' }}\n",
            1e-3 * top,
            -2e-3 * top
        ),
        false => format!(
            "[[boundary]]\nside = 'z+'\ntraction = {{ x = '{} MPa', z = '-10 MPa' }}\n",
            r.between(0.0, 5.0)
        ),
    };
    if r.chance(0.3) {
        toml += "[[boundary]]\nside = 'x-'\nhold = 'roller'\n";
    }
    toml
}

/// Thin cells, 1:10 to 1:1000, and a fracture across them one or two cells high, maybe another along them: a traction that is constant on the
/// first has an eigenvalue of down to 1e-5, of which loads show little.
pub(super) fn flat_scene(seed: u64) -> String {
    const AXES: [&str; 3] = ["x", "y", "z"];
    let r = &mut Random::new(seed);
    let thin = r.below(3);
    let wide = [(thin + 1) % 3, (thin + 2) % 3];
    let cells = [0, 1, 2].map(|d| match d == thin {
        true => r.whole(5, 8),
        false => r.whole(3, 6),
    });
    let height = 10f64.powf(-r.between(1.0, 3.0));
    let at = |d: usize, line: u32| f64::from(line) * if d == thin { height } else { 1.0 };
    let mut toml = format!("title = 'seed {seed}'\n[mesh]\n");
    for (d, axis) in AXES.iter().enumerate() {
        let to = at(d, cells[d]);
        toml += &format!(
            "{axis} = {{ from = '0 m', to = '{to} m', cells = {} }}\n",
            cells[d]
        );
    }
    toml += &format!(
        "[[material]]\nname = 'rock'\nyoung = '10 GPa'\npoisson = {}\n",
        r.one_of(&[0.0, 0.2, 0.25])
    );
    if r.chance(0.5) {
        let from = r.whole(0, cells[thin] - 2);
        toml += &format!(
            "[[material]]\nname = 'layer'\nyoung = '{} Pa'\npoisson = 0.2\nboxes = [{{ {} = ['{} m', '{} m'] }}]\n",
            1e10 * 10f64.powf(r.between(-3.0, 3.0)),
            AXES[thin],
            at(thin, from),
            at(thin, r.whole(from + 1, cells[thin] - 1))
        );
    }
    let across = r.one_of(&wide);
    let from = r.whole(0, cells[thin] - 1);
    toml += &format!(
        "[[fracture]]\nname = 'short'\nplane = '{}'\nat = '{} m'\nfriction_angle = '30 deg'\n{} = ['{} m', '{} m']\n",
        AXES[across],
        at(across, r.whole(1, cells[across] - 1)),
        AXES[thin],
        at(thin, from),
        at(thin, (from + r.whole(1, 2)).min(cells[thin]))
    );
    if r.chance(0.5) {
        toml += &format!(
            "[[fracture]]\nname = 'along'\nplane = '{}'\nat = '{} m'\nfriction_angle = '30 deg'\n",
            AXES[thin],
            at(thin, r.whole(1, cells[thin] - 1))
        );
    }
    let held = AXES[r.one_of(&wide)];
    let thin = AXES[thin];
    toml += &format!("[[boundary]]\nside = '{held}-'\nhold = 'fixed'\n");
    toml += &match r.chance(0.5) {
        true => format!(
            "[[boundary]]\nside = '{held}+'\ndisplacement = {{ {held} = '-1 mm', {thin} = '{} mm' }}\n",
            r.between(-10.0, 10.0) * height
        ),
        false => format!("[[boundary]]\nside = '{held}+'\npressure = '10 MPa'\n"),
    };
    if r.chance(0.5) {
        toml += &format!("[[boundary]]\nside = '{thin}-'\nhold = 'roller'\n");
    }
    if r.chance(0.5) {
        toml += &format!("[[boundary]]\nside = '{thin}+'\npressure = '2 MPa'\n");
    }
    toml
}

/// One system: what the iteration said, and the errors against the reference.
struct Tried {
    accurate: Accurate,
    truth: Option<Fields<f64>>,
}

fn tried(body: &Body, inner: &str, tolerance: f64) -> Option<Tried> {
    let stabilization = Some(JumpStabilization::default());
    let system = body.stick_system(stabilization);
    let magnitude = system.magnitude().unwrap();
    let saddle = MatrixFreeSaddle::in_traction_unit(&system, magnitude.unit).unwrap();
    let blocks = body
        .saddle_blocks(stabilization)
        .unwrap()
        .into_traction_unit(magnitude.unit);
    let a = saddle.stiffness();
    let strain = a
        .is_displaced()
        .then(|| -> StrainNorm<'_> { Box::new(|u| a.strain_norm(u)) });
    let assembled = SaddleOperator::new(&blocks);
    let (operator, m, norms): (&dyn LinearOperator<f64>, Box<dyn Preconditioner<f64>>, _) =
        match inner {
            "geometric" => {
                let ready =
                    RacpParts::new(&Racp::geometric(), &saddle, &system, &mut Silent).ok()?;
                (
                    &saddle,
                    Box::new(ready.inverse),
                    saddle
                        .energy_norms(&magnitude, strain)
                        .with_entries(&blocks),
                )
            }
            _ => {
                let method = SaddleMethod::default()
                    .with_parts(None, Some(inner.parse().unwrap()))
                    .unwrap();
                let c = blocks.contact_compliance();
                let norms = EnergyNorms::new(
                    &assembled,
                    blocks.h.as_ref(),
                    c,
                    Cow::Owned(blocks.stiffness()),
                );
                (
                    &assembled,
                    method.ready(&blocks).ok()?.inverse,
                    norms.against(strain).with_entries(&blocks),
                )
            }
        };
    let b = blocks.rhs();
    let krylov = KrylovChoice::default().flexible_for(&*m);
    let criteria = Criteria {
        relative_tolerance: tolerance,
        max_iterations: 600,
    };
    let mut x = vec![0.0; b.len()];
    let system = System {
        operator,
        preconditioner: &*m,
        rhs: &b,
    };
    let accurate = solve_accurately(
        krylov.method(),
        &system,
        &criteria,
        (Measure::Error, &norms),
        &mut x,
        &mut Silent,
    );
    let truth = reference(&blocks, &b).map(|exact| {
        x.iter_mut().zip(&exact).for_each(|(x, exact)| *x -= exact);
        EnergyNorms::relative(norms.error(&x), norms.solution(&exact), tolerance)
    });
    Some(Tried { accurate, truth })
}

#[test]
fn converged_means_accurate_and_refused_means_not() {
    holds_in(scene, &ROUNDED);
}

#[test]
fn errors_on_short_fractures_across_flat_cells_are_seen() {
    holds_in(flat_scene, &WRONG_ONCE);
}

/// The claim, for scenes that are drawn from a seed, after those that were wrong once.
fn holds_in(scene: fn(u64) -> String, wrong_once: &[(u64, u64)]) {
    let (cases, first) = (
        environment("ACCURACY_CASES", CASES),
        environment("ACCURACY_SEED", 1),
    );
    let (mut counts, mut wrong) = ([0; 5], Vec::new());
    let skip = environment("ACCURACY_SKIP", 0);
    let drawn = (skip..skip + cases).map(|seed| (first, seed));
    for (first, seed) in wrong_once.iter().copied().chain(drawn) {
        let text = scene(first.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(seed));
        let body = Scene::from_toml(&text, "scene.toml")
            .unwrap()
            .build()
            .unwrap();
        let inner = INNER[(seed % 4) as usize];
        let tolerance = TOLERANCES[(seed / 4 % 4) as usize];
        let Some(Tried { accurate, truth }) = tried(&body, inner, tolerance) else {
            counts[0] += 1;
            println!("{seed} {inner}: no set-up");
            continue;
        };
        let converged =
            matches!(&accurate.result, Ok(report) if report.outcome == Outcome::Converged);
        let (its, said) = match &accurate.result {
            Ok(report) => (
                report.iterations,
                format!(
                    "{:?} ritz {:.1e} res {:.1e}",
                    report.outcome,
                    report.smallest_ritz.unwrap_or(f64::NAN),
                    report.relative_residual
                ),
            ),
            Err(breakdown) => (breakdown.iteration(), breakdown.to_string()),
        };
        let errors = |e: Fields<f64>| format!("{:.1e} {:.1e}", e[U], e[T]);
        let (estimate, exact) = (
            errors(accurate.error),
            truth.map_or("unknown".into(), errors),
        );
        println!(
            "{seed} {inner} {tolerance:.0e}: {said}; {its} iterations, {} passes, errors {estimate}, true {exact}",
            accurate.passes
        );
        let Some([u, t]) = truth.map(|errors| [errors[U], errors[T]]) else {
            counts[1] += 1;
            continue;
        };
        let worst = u.max(t);
        counts[if converged { 2 } else { 3 }] += 1;
        let before = wrong.len();
        if converged && worst > 10.0 * tolerance {
            wrong.push(format!(
                "seed {seed}, {inner}, {tolerance:.0e}: {said}, true errors {u:.1e} and {t:.1e}"
            ));
        }
        let is_true = match &accurate.result {
            Ok(report) => report.outcome == Outcome::IterationLimit,
            Err(Breakdown::Inaccurate { error, .. }) => *error > tolerance && 10.0 * error > worst,
            // x is far from solving anything
            Err(Breakdown::Stagnation {
                relative_residual, ..
            }) => *relative_residual > 0.1 && worst > tolerance,
            Err(_) => false,
        };
        if !converged && !is_true {
            wrong.push(format!(
                "seed {seed}, {inner}, {tolerance:.0e}: refused by '{said}', true errors {u:.1e} and {t:.1e}"
            ));
        }
        if wrong.len() > before {
            println!("{text}");
        }
        // where M is poor, a bound of the error may not be small though the error is
        if !converged && worst < 0.1 * tolerance {
            counts[4] += 1;
        }
    }
    let [no_setup, no_reference, converged, refused, modest] = counts;
    println!(
        "{cases} systems: {no_setup} without set-up, {no_reference} without a reference, {converged} converged, {refused} refused, {modest} of them better than they could show, {} false",
        wrong.len()
    );
    assert!(converged * 2 > cases, "too few were solved");
    assert!(modest * 25 <= cases, "{modest} refusals of good solutions");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
