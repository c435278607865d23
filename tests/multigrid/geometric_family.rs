//! Claim: on random scenes of fractures that cross each other and held sides, geometric multigrid is set up wherever S_u can be
//! factorized, and needs at most twice the iterations of AMG (of a factorization where that cannot be set up, and any number where
//! neither can), or 30. Hierarchies that are made to go on to 60 unknowns, and to iterate there,
//! miss that in at most 1 of 50 scenes.
//!
//! `GEOMETRIC_FAMILY=3000 GEOMETRIC_SEED=1 cargo test --release --test multigrid geometric_family:: -- --nocapture` tries that many;
//! `GEOMETRIC_SKIP=17` begins with the seed that is so much larger, and `GEOMETRIC_SCENES=folder` keeps the scenes.

use fracas::contact::JumpStabilization;
use fracas::mesh::{BodyPart, Hold};
use fracas::multigrid::{Geometric, GeometricInverse};
use fracas::scene::{Body, Scene};
use fracas_operators::Preconditioner;
use fracas_operators::random::Random;
use fracas_operators::sparse::Csr;
use fracas_solvers::Silent;
use fracas_solvers::amg::Amg;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::multigrid::Precision;
use fracas_solvers::saddle::{
    Assembled, AugmentationChoice, AugmentationMatrix, InnerChoice, Measure, RELAXATION, Racp,
    RacpInverse, SaddleBlocks, SaddleMethod, SaddleSystem, solve_accurately,
};
use std::fmt::Write;

/// Scenes where the environment names no number.
const FEW: u64 = 12;

/// Iterations that are few whatever AMG takes.
pub(super) const ENOUGH: usize = 30;

/// Iterations after which a solve has failed.
const MOST: usize = 400;

/// Counts that a summary names with their seeds.
const LARGEST: usize = 5;

/// Share of the scenes that may be missed by hierarchies that are made deeper than the default. Unit: 1.
const DEEP: f64 = 0.02;

const AXES: [&str; 3] = ["x", "y", "z"];

/// From `low` to `high`, both included.
fn range(dice: &mut Random, low: usize, high: usize) -> usize {
    low + dice.below(high - low + 1)
}

/// Grid lines of an axis: equal, stretched, growing, or uneven cells.
fn lines(dice: &mut Random, cells: usize, stretch: f64) -> Vec<f64> {
    let kind = range(dice, 0, 5);
    let growth = 1.0 + 0.5 * dice.unit();
    let middle = range(dice, 0, cells) as f64;
    let mut lines = vec![0.0];
    let mut at: f64 = 0.0;
    for i in 0..cells {
        at += stretch
            * match kind {
                0 => growth.powf((i as f64 - middle).abs()),
                1 => dice.one_of(&[0.5, 1.0, 1.0, 2.0]),
                _ => 1.0,
            };
        // few digits, so that text and numbers agree
        lines.push((at * 1e6).round() / 1e6);
    }
    lines
}

fn interval(dice: &mut Random, lines: &[f64], whole: usize) -> [f64; 2] {
    let n = lines.len() - 1;
    if dice.below(100) < whole {
        return [lines[0], lines[n]];
    }
    let from = range(dice, 0, n - 2);
    let to = range(dice, from + 2, n);
    [lines[from], lines[to]]
}

/// A scene as text: 1–6 cuts, T and X crossings, or a network; held and loaded sides; layers.
fn scene(seed: u64) -> String {
    let dice = &mut Random::new(seed);
    let cells = [0, 1, 2].map(|_| range(dice, 5, 13));
    let stretch = [0, 1, 2].map(|_| {
        if dice.below(100) < 15 {
            dice.one_of(&[0.02, 0.1, 0.5, 5.0, 20.0])
        } else {
            1.0
        }
    });
    let lines = [0, 1, 2].map(|d: usize| lines(dice, cells[d], stretch[d]));
    let mut text = format!("title = \"family {seed}\"\n[mesh]\n");
    for d in 0..3 {
        let list: Vec<String> = lines[d].iter().map(|x| format!("\"{x} m\"")).collect();
        writeln!(text, "{} = {{ lines = [{}] }}", AXES[d], list.join(", ")).unwrap();
    }
    let rock = |dice: &mut Random| dice.one_of(&[0.0, 0.2, 0.25, 0.25, 0.3, 0.4, 0.49]);
    let poisson = rock(dice);
    writeln!(
        text,
        "[[material]]\nname = \"rock\"\nyoung = \"25 GPa\"\npoisson = {poisson}\ndensity = \"2500 kg/m3\""
    )
    .unwrap();
    if dice.below(100) < 35 {
        let young = 25.0 * dice.one_of(&[0.5, 0.1, 0.01, 1e-3, 10.0, 100.0]);
        let layers: Vec<String> = (0..range(dice, 1, 2))
            .map(|_| {
                let [from, to] = interval(dice, &lines[2], 0);
                format!("[\"{from} m\", \"{to} m\"]")
            })
            .collect();
        let poisson = rock(dice);
        writeln!(
            text,
            "[[material]]\nname = \"layer\"\nyoung = \"{young} GPa\"\npoisson = {poisson}\ndensity = \"2300 kg/m3\"\nlayers = [{}]",
            layers.join(", ")
        )
        .unwrap();
    }
    let network = dice.below(100) < 30;
    let mut number = 0;
    let mut plane = |text: &mut String,
                     axis: usize,
                     place: String,
                     limits: [Option<[f64; 2]>; 3]| {
        number += 1;
        writeln!(
            text,
            "[[fracture]]\nname = \"f{number}\"\nplane = \"{}\"\n{place}\nfriction_angle = \"30 deg\"",
            AXES[axis]
        )
        .unwrap();
        for (d, limit) in limits.iter().enumerate() {
            if let (true, Some([from, to])) = (d != axis, limit) {
                writeln!(text, "{} = [\"{from} m\", \"{to} m\"]", AXES[d]).unwrap();
            }
        }
    };
    if network {
        let depth = interval(dice, &lines[2], 30);
        let axes = dice.one_of(&[&[0usize, 1][..], &[0, 1], &[0, 1, 2], &[0, 2], &[0]]);
        for axis in axes {
            let every = range(dice, 1, 3).min(cells[*axis] - 1);
            let limits = [None, None, (*axis != 2).then_some(depth)];
            plane(&mut text, *axis, format!("every = {every}"), limits);
        }
    } else {
        let axes = [range(dice, 0, 2), range(dice, 0, 2), range(dice, 0, 2)];
        let mut used: Vec<(usize, usize)> = Vec::new();
        for _ in 0..range(dice, 1, 6) {
            let axis = dice.one_of(&axes);
            let at = range(dice, 1, cells[axis] - 1);
            if used.contains(&(axis, at)) {
                continue;
            }
            used.push((axis, at));
            let limits = [0, 1, 2].map(|d: usize| Some(interval(dice, &lines[d], 45)));
            plane(
                &mut text,
                axis,
                format!("at = \"{} m\"", lines[axis][at]),
                limits,
            );
        }
    }
    for (k, side) in ["z-", "x-", "x+", "y-", "y+", "z+"].iter().enumerate() {
        let condition = match (k, range(dice, 0, 99)) {
            (0, 0..80) => "hold = \"fixed\"",
            (0, _) => "hold = \"roller\"",
            (1..5, 0..22) => "hold = \"fixed\"",
            (1..5, 22..55) => "hold = \"roller\"",
            (5, 0..8) => "hold = \"roller\"",
            (5, _) => "pressure = \"10 MPa\"",
            (_, 55..75) => "pressure = \"5 MPa\"",
            _ => continue,
        };
        writeln!(text, "[[boundary]]\nside = \"{side}\"\n{condition}").unwrap();
    }
    text
}

/// A body with its system in a unit of tractions that balances it.
pub(super) struct Sample {
    body: Body,
    blocks: SaddleBlocks,
    /// C of the blocks, and of B in m².
    c: [AugmentationMatrix; 2],
}

impl Sample {
    pub(super) fn new(text: &str) -> Option<Self> {
        let body = Scene::from_toml(text, "family.toml").ok()?.build().ok()?;
        let audit = body.audit();
        let is_held = |b: &BodyPart| !matches!(b.hold, Hold::Nothing { .. });
        let is_held = audit.bodies.iter().all(is_held);
        if !is_held || audit.n_t == 0 {
            return None;
        }
        let blocks = body
            .saddle_blocks(Some(JumpStabilization::default()))
            .ok()?;
        let unit = blocks.traction_unit();
        let direct = DirectChoice::default().solver().unwrap();
        let fitted = AugmentationChoice::FittedH;
        let c = |blocks: &SaddleBlocks| fitted.compute(blocks, &*direct).unwrap().matrix;
        let in_si = c(&blocks);
        let blocks = blocks.into_traction_unit(unit);
        Some(Self {
            c: [c(&blocks), in_si],
            body,
            blocks,
        })
    }

    /// Iterations of GMRES to errors of 1e-8, as `solve` counts them.
    fn iterations(&self, m: &dyn Preconditioner<f64>) -> usize {
        let assembled = Assembled::new(&self.blocks, None);
        let own = self.blocks.rhs();
        let b: Vec<f64> = match own.iter().any(|b| *b != 0.0) {
            true => own,
            false => (1..=own.len()).map(|i| (i as f64).sin()).collect(),
        };
        let system = System {
            operator: assembled.operator(),
            preconditioner: m,
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-8,
            max_iterations: MOST,
        };
        let choice = KrylovChoice::default().flexible_for(m);
        let mut x = vec![0.0; b.len()];
        let solved = solve_accurately(
            choice.method(),
            &system,
            &criteria,
            (Measure::Error, &assembled.norms(true)),
            &mut x,
            &mut Silent,
        );
        match solved.result {
            Ok(report) if report.outcome == Outcome::Converged => report.iterations,
            _ => MOST,
        }
    }

    pub(super) fn geometric(&self, settings: Geometric) -> Result<usize, String> {
        let system = self.body.stick_system(Some(JumpStabilization::default()));
        let inverse = GeometricInverse::new(&settings, &system, &self.c[1]);
        let inverse = inverse.map_err(|error| error.to_string())?;
        let m = RacpInverse::new(self.blocks.b1.clone(), self.c[0].clone(), inverse);
        // faces without a neighbour have no H
        let m = match &self.blocks.h {
            Some(h) => m.relaxed(Box::new(Csr::new(h.clone())), RELAXATION),
            None => m,
        };
        Ok(self.iterations(&m))
    }

    pub(super) fn assembled(&self, inner: InnerChoice) -> Result<usize, String> {
        let method = SaddleMethod::Racp(Racp {
            inner,
            ..Racp::default()
        });
        let ready = method.ready(&self.blocks).map_err(|e| e.to_string())?;
        Ok(self.iterations(&*ready.inverse))
    }
}

pub(super) fn of_environment(name: &str, default: u64) -> u64 {
    std::env::var(name)
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(default)
}

/// Median, 95 %, and the largest of these counts of seeds.
fn summary(mut counts: Vec<(usize, u64)>) -> String {
    counts.sort_unstable();
    let at = |share: f64| counts.get(((counts.len() as f64 - 1.0) * share).round() as usize);
    let count = |share| at(share).map_or(0, |(count, _)| *count);
    let largest: Vec<String> = (counts.iter().rev().take(LARGEST))
        .map(|(count, seed)| format!("{count} ({seed})"))
        .collect();
    format!(
        "median {}, 95 % {} of {}, largest {}",
        count(0.5),
        count(0.95),
        counts.len(),
        largest.join(", ")
    )
}

#[test]
fn random_scenes_are_set_up_and_take_few_iterations() {
    let count = of_environment("GEOMETRIC_FAMILY", FEW);
    let first =
        of_environment("GEOMETRIC_SEED", 0) * 1_000_000 + of_environment("GEOMETRIC_SKIP", 0);
    let verbose = std::env::var("GEOMETRIC_VERBOSE").is_ok();
    let kinds: [(&str, Geometric); 4] = [
        ("f32", Geometric::default()),
        (
            "f64",
            Geometric {
                precision: Precision::F64,
                ..Geometric::default()
            },
        ),
        (
            "deep f32",
            Geometric {
                coarsest: 60,
                ..Geometric::default()
            },
        ),
        (
            "deep f64",
            Geometric {
                coarsest: 60,
                direct: 60,
                precision: Precision::F64,
                ..Geometric::default()
            },
        ),
    ];
    let (mut tried, mut skipped, mut sizes) = (0, 0, Vec::new());
    let mut counts: Vec<Vec<(usize, u64)>> = vec![Vec::new(); kinds.len()];
    let mut bad = vec![0; kinds.len()];
    let mut missed = Vec::new();
    for seed in first.. {
        if tried == count {
            break;
        }
        let text = scene(seed);
        if let Some(folder) = std::env::var_os("GEOMETRIC_SCENES") {
            let file = std::path::Path::new(&folder).join(format!("seed_{seed}.toml"));
            std::fs::write(file, &text).unwrap();
        }
        let Some(sample) = Sample::new(&text) else {
            skipped += 1;
            assert!(skipped <= 20 + 3 * count, "most scenes are refused");
            continue;
        };
        tried += 1;
        let (n_u, n_t) = (sample.blocks.n_u(), sample.blocks.n_t());
        sizes.push((n_u, seed));
        let amg = std::cell::OnceCell::new();
        let exact = std::cell::OnceCell::new();
        for (k, (name, settings)) in kinds.iter().enumerate() {
            let found = sample.geometric(*settings);
            match found {
                Ok(n) => {
                    counts[k].push((n, seed));
                    let fits = n <= ENOUGH || {
                        let amg =
                            amg.get_or_init(|| sample.assembled(InnerChoice::Amg(Amg::default())));
                        let rival = match amg {
                            Ok(_) => amg,
                            // where it cannot be set up
                            Err(_) => {
                                exact.get_or_init(|| sample.assembled(InnerChoice::default()))
                            }
                        };
                        // neither is set up: a motion costs less energy than rounding leaves
                        rival.as_ref().map_or(true, |most| n <= 2 * most)
                    };
                    if !fits {
                        let exact = exact.get_or_init(|| sample.assembled(InnerChoice::default()));
                        bad[k] += 1;
                        missed.push(format!("{seed} {name}: {n} iterations, amg {:?}, exact {exact:?}; n_u {n_u}, n_t {n_t}", amg.get()));
                    }
                }
                Err(error) => {
                    let exact = exact.get_or_init(|| sample.assembled(InnerChoice::default()));
                    if exact.is_ok() {
                        bad[k] += 1;
                        missed.push(format!(
                            "{seed} {name}: {error}; exact {exact:?}; n_u {n_u}, n_t {n_t}"
                        ));
                    }
                }
            }
            if verbose {
                for m in missed.drain(..) {
                    println!("{m}");
                }
            }
        }
    }
    println!(
        "{tried} scenes from seed {first}, {skipped} refused, n_u {}",
        summary(sizes)
    );
    for (k, (name, _)) in kinds.iter().enumerate() {
        println!("{name}: {}, {} missed", summary(counts[k].clone()), bad[k]);
    }
    // of the few scenes of a default run none may be missed
    let most = [0.0, 0.0, DEEP, DEEP].map(|share| (share * count as f64) as usize);
    let is_met = bad.iter().zip(most).all(|(bad, most)| *bad <= most);
    assert!(is_met, "{}", missed.join("\n"));
}

/// Plates of 1:50 between cuts on a graded axis took 230, 50 and 67 (35 now) iterations, a stiff sheet of 1:10 over soft rock 200 (50 with S_u
/// factorized), bars of 1:50 to 1:1000 that are cut from each other along two axes 400 (61 with S_u factorized),
/// columns that end in soft rock 134 (50 with S_u factorized), plates of 1:50 that cuts turn into bars 249 (56 with S_u factorized).
#[test]
fn seeds_that_took_many_iterations_take_few() {
    for (seed, most) in [
        (921_001_368, ENOUGH),
        (921_001_121, ENOUGH),
        (913_000_462, 40),
        (922_000_885, 55),
        (919_001_009, 61),
        (9_511_000_554, 56),
        (9_711_002_799, 56),
    ] {
        let sample = Sample::new(&scene(seed)).unwrap();
        let found = sample.geometric(Geometric::default());
        assert!(
            found.as_ref().is_ok_and(|n| *n <= most),
            "{seed}: {found:?}"
        );
    }
}

/// Where λ_max is too small by a hundredth, a polynomial of degree 48 makes the cycle indefinite: ten Lanczos steps left two boxes with
/// ν = 0.4999 and uneven cells of up to 1:5000 without an answer after 1,000 iterations. AMG takes 68 in the first and fails in the second.
#[test]
fn cycles_of_rock_that_is_all_but_incompressible_are_definite() {
    for (text, most) in [
        (include_str!("../data/incompressible/box.toml"), 61),
        (include_str!("../data/incompressible/bar.toml"), 61),
    ] {
        let sample = Sample::new(text).unwrap();
        let found = sample.geometric(Geometric::default());
        assert!(found.as_ref().is_ok_and(|n| *n <= most), "{found:?}");
    }
}
