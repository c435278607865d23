//! e06: every choice of C between a well conditioned S_u and a well clustered spectrum.

use crate::measure::{Measured, count_cell};
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_operators::Preconditioner;
use fracas_solvers::direct::{DirectChoice, DirectSolver};
use fracas_solvers::krylov::KrylovChoice;
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
        scene: "layered",
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
        let stabilization = self.with_h.then(JumpStabilization::default);
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
    let sin: Vec<f64> = (1..=blocks.size()).map(|i| (i as f64).sin()).collect();
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
    let amg = match InnerChoice::Amg(Default::default()).prepare(blocks, &c) {
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

/// n_it against κ(S_u): the curve of γ, a mark per rule.
fn pareto(case: &Case, number: usize, inner: usize, rows: &[Solved]) -> Figure {
    let caption = format!(
        "{}, {}: iterations under the physical load against the condition number of S_u; the line is C = sγI from \
         s = 10⁴ (left) to 10⁻⁴.",
        case.name(),
        INNERS[inner]
    );
    let word = if inner == 0 { "exact" } else { "amg" };
    let mut figure = Figure::new(
        &format!("e06_pareto_{number}_{word}"),
        "",
        &caption,
        Axis::log("κ(S_u)"),
        Axis::log("n_it"),
    );
    let point = |s: &Solved| -> Option<[f64; 2]> {
        let n = s.counts[inner][0].as_ref()?.iterations?;
        Some([s.kappa, n as f64])
    };
    let curve: Vec<[f64; 2]> = rows
        .iter()
        .filter(|s| matches!(s.choice, AugmentationChoice::GlobalTimes(_)))
        .filter_map(point)
        .collect();
    figure = figure.with(Series::new("sγI", Mark::LinePoints, curve));
    for s in rows {
        if !matches!(s.choice, AugmentationChoice::GlobalTimes(_)) {
            let points: Vec<[f64; 2]> = point(s).into_iter().collect();
            if !points.is_empty() {
                figure = figure.with(Series::new(s.choice.name(), Mark::Points, points));
            }
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
         with exact S_u and with AMG."
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
                    Err(reason) => findings
                        .notes
                        .push(format!("{}, C = {choice}: {reason}.", case.name())),
                }
            }
            findings.checks.extend(checks(case, &rows));
            for inner in 0..INNERS.len() {
                findings
                    .figures
                    .push(pareto(case, number + 1, inner, &rows));
            }
        }
        findings.tables.push(table);
        Ok(findings)
    }
}

fn checks(case: &Case, rows: &[Solved]) -> Vec<Check> {
    let find = |choice: AugmentationChoice| rows.iter().find(|s| s.choice == choice);
    let _ = (case, find);
    Vec::new()
}
