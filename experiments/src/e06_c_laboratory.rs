//! e06: every choice of C between a well conditioned S_u and a well clustered spectrum.

use crate::measure::{Measured, count_cell};
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use crate::trial::Load;
use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_operators::Preconditioner;
use fracas_solvers::amg::Amg;
use fracas_solvers::direct::{DirectChoice, DirectSolver};
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::multigrid::Smoother;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, RacpInverse, SaddleBlocks};
use fracas_solvers::spectrum::condition::{scaled_schur_ends, schur_ends};
use fracas_solvers::{Observer, SetupError, Step};
use std::ops::ControlFlow;

/// Which C should one take?
#[derive(Debug)]
pub struct CLaboratory;

/// A scene, with or without stabilization.
struct Case {
    scene: &'static str,
    with_h: bool,
}

/// Layers of a stiffness contrast of 1000.
const CONTRAST: &str = "layered";

/// B has full rank in `clamped`, so that it can do without H; the others need it.
const CASES: [Case; 4] = [
    Case {
        scene: "clamped",
        with_h: false,
    },
    Case {
        scene: "clamped",
        with_h: true,
    },
    Case {
        scene: CONTRAST,
        with_h: true,
    },
    Case {
        scene: "stretched",
        with_h: true,
    },
];

/// Factors on `γ = ‖B‖²/‖A‖`.
const FACTORS: [f64; 9] = [1e-4, 1e-3, 1e-2, 1e-1, 1.0, 1e1, 1e2, 1e3, 1e4];

/// C by a rule.
const RULES: [AugmentationChoice; 5] = [
    AugmentationChoice::Local,
    AugmentationChoice::LocalH,
    AugmentationChoice::FaceBlock,
    AugmentationChoice::Exact,
    AugmentationChoice::ExactH,
];

impl Case {
    fn name(&self) -> String {
        format!("{}{}", self.scene, if self.with_h { "" } else { ", H = 0" })
    }

    fn blocks(&self, level: Level) -> anyhow::Result<SaddleBlocks> {
        let entry = named(self.scene).ok_or_else(|| anyhow::anyhow!("no scene {}", self.scene))?;
        let scene = match level {
            Level::Smoke => entry.small_scene()?,
            Level::Paper => entry.scene()?,
        };
        let stabilization = self.with_h.then_some(JumpStabilization::PUBLISHED);
        let blocks = scene.build()?.saddle_blocks(stabilization)?;
        Ok(blocks.in_traction_unit(blocks.traction_unit()))
    }
}

/// What one C gives.
struct Solved {
    choice: AugmentationChoice,
    kappa: f64,
    kappa_scaled: f64,
    /// (physical load, sin i) with exact S_u, then with AMG.
    counts: [[Option<Measured>; 2]; 2],
}

impl Solved {
    /// n_it under the physical load.
    fn count(&self, inner: usize) -> f64 {
        self.counts[inner][0]
            .as_ref()
            .map_or(f64::INFINITY, Measured::count)
    }
}

/// C, both conditions of S_u, and four iterations.
fn solved(
    blocks: &SaddleBlocks,
    choice: AugmentationChoice,
    direct: &dyn DirectSolver,
) -> Result<Solved, SetupError> {
    let c = choice.compute(blocks, direct)?.matrix;
    let exact = InnerChoice::default().prepare(blocks, &c)?.inverse;
    let kappa = schur_ends(blocks, &c, Some(exact.as_ref()), direct)?.condition();
    let kappa_scaled = scaled_schur_ends(blocks, &c, Some(exact.as_ref()), direct)?.condition();
    let load = blocks.rhs();
    let sin = Load::Sine.of(blocks);
    let counts = |inner: Box<dyn Preconditioner<f64>>| {
        let m = RacpInverse::new(blocks.b1.clone(), c.clone(), inner);
        [&load, &sin].map(|rhs| {
            let zero = vec![0.0; rhs.len()];
            Some(Measured::new(
                blocks,
                &m,
                KrylovChoice::default(),
                rhs,
                zero,
            ))
        })
    };
    let amg = match InnerChoice::Amg(Amg::with(Smoother::GaussSeidel)).prepare(blocks, &c) {
        Ok(ready) => counts(ready.inverse),
        Err(SetupError::NotApplicable { .. } | SetupError::NotPositiveDefinite { .. }) => {
            [None, None]
        }
        Err(error) => return Err(error),
    };
    Ok(Solved {
        choice,
        kappa,
        kappa_scaled,
        counts: [counts(exact), amg],
    })
}

const INNERS: [&str; 2] = ["exact S_u", "AMG for S_u"];

impl Solved {
    fn iterations(&self, inner: usize) -> Option<f64> {
        let n = self.counts[inner][0].as_ref()?.iterations?;
        Some(n as f64)
    }

    /// s, where C = sγI.
    fn factor(&self) -> Option<f64> {
        match self.choice {
            AugmentationChoice::GlobalTimes(factor) => Some(factor),
            _ => None,
        }
    }
}

/// The iterations that ran around this inner solver.
fn ran(rows: &[Solved], inner: usize) -> Option<String> {
    let ran = rows.iter().flat_map(|s| s.counts[inner].iter().flatten());
    let mut names: Vec<String> = ran.map(|m| m.krylov.to_string()).collect();
    names.sort();
    names.dedup();
    (!names.is_empty()).then(|| names.join(", "))
}

/// Place in the palette of a rule: shapes that stay visible one on top of the other.
fn tone(rule: AugmentationChoice) -> usize {
    match rule {
        AugmentationChoice::LocalH => 6,
        AugmentationChoice::FaceBlock => 3,
        AugmentationChoice::Exact => 5,
        AugmentationChoice::ExactH => 4,
        _ => 2,
    }
}

/// n_it against κ(S_u): a curve of s per inner solver, a mark per rule and inner solver.
fn pareto(case: &Case, number: usize, rows: &[Solved]) -> Figure {
    let caption = format!(
        "{}: iterations under the physical load against the condition number of S_u. Curves: C = sγI from s = 10⁴ (upper \
         left) to 10⁻⁴; marks: C by a rule, the lower one of a pair with exact S_u, the upper one with AMG. Values of s \
         that did not converge are left out.",
        case.name(),
    );
    let id = format!("e06_pareto_{number}");
    let (x, y) = (Axis::log("κ(S_u)"), Axis::log("n_it"));
    let mut figure = Figure::new(&id, "", &caption, x, y);
    for (inner, name) in INNERS.iter().enumerate() {
        let curve = rows
            .iter()
            .filter(|s| s.factor().is_some())
            .filter_map(|s| Some([s.kappa, s.iterations(inner)?]))
            .collect();
        let name = format!("sγI, {name}");
        figure = figure.with(Series::new(&name, Mark::LinePoints, curve).tone(inner));
    }
    // face_block below local_h
    for choice in [
        AugmentationChoice::Local,
        AugmentationChoice::FaceBlock,
        AugmentationChoice::LocalH,
        AugmentationChoice::ExactH,
        AugmentationChoice::Exact,
    ] {
        let points: Vec<[f64; 2]> = rows
            .iter()
            .filter(|s| s.choice == choice)
            .flat_map(|s| [0, 1].map(|inner| Some([s.kappa, s.iterations(inner)?])))
            .flatten()
            .collect();
        if !points.is_empty() {
            let series = Series::new(choice.name(), Mark::Points, points);
            figure = figure.with(series.tone(tone(choice)));
        }
    }
    figure
}

/// n_it against s, and what local_h takes without a sweep.
fn sweep(case: &Case, number: usize, rows: &[Solved]) -> Figure {
    let caption = format!(
        "{}: iterations under the physical load for C = sγI; dashed: C = local_h.",
        case.name()
    );
    let id = format!("e06_sweep_{number}");
    let (x, y) = (Axis::log("s"), Axis::log("n_it"));
    let mut figure = Figure::new(&id, "", &caption, x, y);
    for (inner, name) in INNERS.iter().enumerate() {
        let curve = rows
            .iter()
            .filter_map(|s| Some([s.factor()?, s.iterations(inner)?]))
            .collect();
        let name = format!("sγI, {name}");
        figure = figure.with(Series::new(&name, Mark::LinePoints, curve).tone(inner));
    }
    for (inner, name) in INNERS.iter().enumerate() {
        let local_h = rows.iter().find(|s| s.choice == AugmentationChoice::LocalH);
        if let Some(n) = local_h.and_then(|s| s.iterations(inner)) {
            let line = vec![[FACTORS[0], n], [FACTORS[FACTORS.len() - 1], n]];
            let name = format!("local_h, {name}");
            figure = figure.with(Series::new(&name, Mark::Dashed, line).tone(inner));
        }
    }
    figure
}

fn row(case: &Case, blocks: &SaddleBlocks, s: &Solved) -> [Cell; 11] {
    let factor = match s.choice {
        AugmentationChoice::GlobalTimes(factor) => factor.into(),
        _ => Cell::Missing,
    };
    let cell = |inner: usize, rhs: usize| count_cell(s.counts[inner][rhs].as_ref());
    [
        case.name().into(),
        blocks.n_u().into(),
        blocks.n_t().into(),
        s.choice.name().into(),
        factor,
        s.kappa.into(),
        s.kappa_scaled.into(),
        cell(0, 0),
        cell(0, 1),
        cell(1, 0),
        cell(1, 1),
    ]
}

/// The row of a choice that does not apply.
fn failed(case: &Case, blocks: &SaddleBlocks, choice: AugmentationChoice) -> Vec<Cell> {
    let mut cells: Vec<Cell> = vec![
        case.name().into(),
        blocks.n_u().into(),
        blocks.n_t().into(),
        choice.name().into(),
        Cell::Missing,
    ];
    cells.extend(std::iter::repeat_n(Cell::Failed, 6));
    cells
}

impl Experiment for CLaboratory {
    fn id(&self) -> &'static str {
        "e06"
    }

    fn title(&self) -> &'static str {
        "The choice of C: iterations against the condition of S_u"
    }

    fn question(&self) -> &'static str {
        "A small C clusters the spectrum and spoils S_u, a large one does the reverse: which C pays, and does a rule find it?"
    }

    fn setup(&self) -> &'static str {
        "C = sγI with γ = ‖B‖²/‖A‖ and s = 10⁻⁴…10⁴ against local, local_h, face_block, exact and exact_h; `clamped` with and \
         without H, `layered` (stiffness contrast 1000), `stretched` (cells of 1:50). κ(S_u) by Lanczos, also after \
         symmetric scaling to a unit diagonal; GMRES(100) to a true residual of 1e-8 under the physical load and b_i = sin i, \
         with exact S_u, and with AMG (flexible there: its cycle runs in f32; Gauss–Seidel for every C, so that only C differs)."
    }

    fn expect(&self) -> &'static str {
        "With H = 0 and exact S_u the eigenvalues are eig(S, S + C): iterations fall with s, κ(S_u) grows like 1/s. With \
         H ≠ 0 they are eig(S + H, S + C): below H a smaller C buys nothing (derived). With an inexact S_u⁻¹ both ends lose. \
         The local rules stand near the corner of the curve without a sweep; under contrast or stretching no multiple of \
         the identity does."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word());
        let mut table = Table::new(
            "e06_c_laboratory",
            "Condition numbers of S_u and iterations for every C.",
            &[
                "scene",
                "n_u",
                "n_t",
                "C",
                "s",
                "κ(S_u)",
                "κ scaled",
                "n_it exact, load",
                "n_it exact, sin",
                "n_it AMG, load",
                "n_it AMG, sin",
            ],
        );
        let direct = DirectChoice::Auto.solver()?;
        let choices: Vec<AugmentationChoice> = FACTORS
            .into_iter()
            .rev()
            .map(AugmentationChoice::GlobalTimes)
            .chain(RULES)
            .collect();
        for (number, case) in CASES.iter().enumerate() {
            let blocks = case.blocks(level)?;
            let mut rows = Vec::new();
            for (k, choice) in choices.iter().enumerate() {
                let step = Step::Progress {
                    stage: "choices of C",
                    done: number * choices.len() + k,
                    total: CASES.len() * choices.len(),
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                match solved(&blocks, *choice, direct.as_ref()) {
                    Ok(s) => {
                        table.push(row(case, &blocks, &s));
                        rows.push(s);
                    }
                    Err(reason) => {
                        table.rows.push(failed(case, &blocks, *choice));
                        let note = format!("{}, C = {choice}: {reason}.", case.name());
                        findings.notes.push(note);
                    }
                }
            }
            findings.checks.extend(checks(case, &rows));
            for (inner, name) in INNERS.iter().enumerate() {
                if let Some(krylov) = ran(&rows, inner) {
                    findings.set(name, krylov);
                }
            }
            findings.figures.push(sweep(case, number + 1, &rows));
            findings.figures.push(pareto(case, number + 1, &rows));
        }
        findings.tables.push(table);
        Ok(findings)
    }
}

fn checks(case: &Case, rows: &[Solved]) -> Vec<Check> {
    let (exact, amg) = (0, 1);
    let name = case.name();
    let rule = |choice: AugmentationChoice| rows.iter().find(|s| s.choice == choice);
    let count = |choice, inner| rule(choice).map_or(f64::INFINITY, |s| s.count(inner));
    let kappa = |choice| rule(choice).map_or(f64::NAN, |s| s.kappa);
    let sweep: Vec<&Solved> = rows
        .iter()
        .filter(|s| matches!(s.choice, AugmentationChoice::GlobalTimes(_)))
        .collect();
    let best = |inner: usize| {
        sweep
            .iter()
            .map(|s| s.count(inner))
            .fold(f64::INFINITY, f64::min)
    };
    let smallest = AugmentationChoice::GlobalTimes(FACTORS[0]);
    let local_h = AugmentationChoice::LocalH;
    let mut checks = vec![
        Check::at_least(
            format!("{name}: κ(S_u) of s = 10⁻⁴ over that of local_h"),
            1e3,
            kappa(smallest) / kappa(local_h),
        ),
        Check::at_most(
            format!("{name}, AMG: n_it of local_h over the best of all sγI"),
            1.5,
            count(local_h, amg) / best(amg),
        ),
    ];
    if case.with_h {
        checks.push(Check::at_least(
            format!("{name}, exact S_u: n_it of s = 10⁻⁴ over local_h (a C below H buys nothing)"),
            1.2,
            count(smallest, exact) / count(local_h, exact),
        ));
    } else {
        checks.push(Check::holds(
            format!("{name}, exact S_u: n_it never grows when s falls"),
            "as stated",
            format!(
                "{:?}",
                sweep.iter().map(|s| s.count(exact)).collect::<Vec<_>>()
            ),
            sweep
                .windows(2)
                .all(|w| w[1].count(exact) <= w[0].count(exact)),
        ));
        checks.push(Check::at_most(
            format!("{name}, exact S_u and C = BᵀA⁻¹B: n_it (theorem 1: two eigenvalues)"),
            3.0,
            count(AugmentationChoice::Exact, exact),
        ));
    }
    if case.scene == CONTRAST {
        checks.push(Check::at_least(
            format!("{name}, exact S_u: n_it of the best sγI over local_h"),
            1.5,
            best(exact) / count(local_h, exact),
        ));
    }
    checks
}
