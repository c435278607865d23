//! e06b: a diagonal C and an H that couples faces.

mod flat_cells;

use crate::measure::{Measured, count_cell};
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use crate::trial::Load;
use fracas::contact::JumpStabilization;
use fracas::scene::{GalleryScene, named};
use fracas_operators::sparse::Csr;
use fracas_solvers::amg::Amg;
use fracas_solvers::direct::{DirectChoice, DirectSolver};
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::multigrid::Smoother;
use fracas_solvers::saddle::{
    AugmentationChoice, InnerChoice, RELAXATION, Racp, RacpInverse, RelaxationSummary,
    SaddleBlocks, SaddleMethod,
};
use fracas_solvers::spectrum::{SpectrumRequest, analyse_method};
use fracas_solvers::{Observer, Silent, Step};
use std::ops::ControlFlow;

/// What does relaxing H buy?
#[derive(Debug)]
pub struct Relaxed;

/// One body; layers of contrast 1000; cells of 1:50; inclined fractures that cross in layers of contrast 10.
const SCENES: [&str; 4] = ["clamped", "layered", "stretched", "layered_crossing"];

/// The scene whose spectrum is drawn, small.
const DRAWN: &str = "layered_crossing";

/// Factors of W.
const FACTORS: [f64; 7] = [0.0, 0.05, 0.1, RELAXATION, 0.2, 0.3, 0.4];

/// All of H in C, half of it, and less in flat cells.
const CHOICES: [AugmentationChoice; 3] = [
    AugmentationChoice::LocalH,
    AugmentationChoice::HalfH,
    AugmentationChoice::FittedH,
];

/// n_it as published over n_it of what the project takes, exact S_u, at least: where C_local is small beside H, …
const GAIN: f64 = 1.3;

/// … and in one rock, with cubes and a closed fracture, where it is a third of it.
const GAIN_OF_CUBES: f64 = 1.0;

/// The same the other way round with AMG, at most, beyond one iteration.
const LOSS: f64 = 1.05;

/// Counts that differ by more are drawn on a logarithmic axis.
const SPREAD: f64 = 10.0;

/// One C, one γ.
struct Row {
    choice: AugmentationChoice,
    asked: f64,
    taken: RelaxationSummary,
    /// (physical load, sin i) with exact S_u, then with AMG.
    counts: [[Measured; 2]; 2],
}

impl Row {
    fn is(&self, choice: AugmentationChoice, gamma: f64) -> bool {
        self.choice == choice && self.asked == gamma
    }

    /// The larger n_it of both right-hand sides.
    fn most(&self, inner: usize) -> f64 {
        let [load, sin] = &self.counts[inner];
        load.count().max(sin.count())
    }
}

const INNERS: [&str; 2] = ["exact S_u", "AMG"];

fn blocks(entry: &GalleryScene, small: bool) -> anyhow::Result<SaddleBlocks> {
    let scene = match small {
        true => entry.small_scene()?,
        false => entry.scene()?,
    };
    let blocks = scene
        .build()?
        .saddle_blocks(Some(JumpStabilization::PUBLISHED))?;
    let unit = blocks.traction_unit();
    Ok(blocks.into_traction_unit(unit))
}

/// Every γ for one C.
fn rows(
    blocks: &SaddleBlocks,
    choice: AugmentationChoice,
    direct: &dyn DirectSolver,
) -> anyhow::Result<Vec<Row>> {
    let c = choice.compute(blocks, direct)?.matrix;
    let inners = [
        InnerChoice::default(),
        InnerChoice::Amg(Amg::with(Smoother::GaussSeidel)),
    ];
    let mut ready = Vec::new();
    for inner in inners {
        ready.push(inner.prepare(blocks, &c)?.inverse);
    }
    let h = Csr::new(
        blocks
            .h
            .clone()
            .unwrap_or_else(|| unreachable!("stabilized")),
    );
    let h = std::sync::Arc::new(h);
    let load = blocks.rhs();
    let sin = Load::Sine.of(blocks);
    let row = |gamma: f64| {
        let mut taken = RelaxationSummary::default();
        let counts = [0, 1].map(|inner| {
            let m = RacpInverse::new(blocks.b1.clone(), c.clone(), ready[inner].as_ref())
                .relaxed(Box::new(h.clone()), gamma);
            taken = m.relaxation();
            [&load, &sin].map(|rhs| {
                let zero = vec![0.0; rhs.len()];
                Measured::new(blocks, &m, KrylovChoice::default(), rhs, zero)
            })
        });
        Row {
            choice,
            asked: gamma,
            taken,
            counts,
        }
    };
    Ok(FACTORS.into_iter().map(row).collect())
}

/// n_it against γ.
fn figure(scene: &str, rows: &[Row]) -> Figure {
    let caption = format!(
        "{scene}: iterations under the physical load against γ of W = I − γ C⁻¹H + …; γ = 0: as published."
    );
    let id = format!("e06b_{scene}");
    // AMG takes many times as many on flat cells
    let counts = |row: &Row| [0, 1].map(|inner| row.counts[inner][0].count());
    let of_all = rows.iter().flat_map(counts).filter(|n| n.is_finite());
    let [least, most] = of_all.fold([f64::INFINITY, 0.0], |[a, b], n| [n.min(a), n.max(b)]);
    let n_it = match most > SPREAD * least {
        true => Axis::log("n_it"),
        false => Axis::linear("n_it"),
    };
    let mut figure = Figure::new(&id, "", &caption, Axis::linear("γ"), n_it);
    for (k, choice) in CHOICES.into_iter().enumerate() {
        for (inner, name) in INNERS.iter().enumerate() {
            let mut points = rows
                .iter()
                .filter(|row| row.choice == choice)
                .filter_map(|row| Some([row.taken.gamma, row.counts[inner][0].iterations? as f64]))
                .collect::<Vec<_>>();
            // where γ gives way it is the same from there on
            points.dedup();
            let name = format!("{}, {name}", choice.name());
            let series = Series::new(&name, Mark::LinePoints, points);
            figure = figure.with(series.tone(2 * k + inner));
        }
    }
    figure
}

/// The eigenvalues with exact S_u, as published and relaxed.
fn spectra(entry: &GalleryScene) -> anyhow::Result<Figure> {
    let blocks = blocks(entry, true)?;
    let caption = format!(
        "{DRAWN}, {} unknowns: eigenvalues of M⁻¹𝒜 with exact S_u, as published and with H relaxed.",
        blocks.size()
    );
    let axes = (Axis::linear("Re λ"), Axis::linear("Im λ"));
    let mut figure = Figure::new("e06b_spectrum", "", &caption, axes.0, axes.1);
    for (tone, (name, racp)) in [
        (
            "as published, local_h",
            Racp::published(InnerChoice::default()),
        ),
        ("H relaxed, fitted_h", Racp::default()),
    ]
    .into_iter()
    .enumerate()
    {
        let request = SpectrumRequest {
            conditions: false,
            ..SpectrumRequest::default()
        };
        let method = SaddleMethod::Racp(racp);
        let report = analyse_method(&blocks, &method, &request, &mut Silent)?;
        let values = &report.eigenvalues;
        let points = values.re.iter().zip(&values.im).map(|(re, im)| [*re, *im]);
        figure = figure.with(Series::new(name, Mark::Points, points.collect()).tone(tone));
    }
    Ok(figure)
}

fn checks(scene: &str, rows: &[Row]) -> Vec<Check> {
    let find = |choice, gamma| rows.iter().find(|row| row.is(choice, gamma));
    let (Some(published), Some(ours)) = (
        find(AugmentationChoice::LocalH, 0.0),
        find(AugmentationChoice::FittedH, RELAXATION),
    ) else {
        unreachable!("both are in the sweep")
    };
    let gain = match scene {
        "clamped" => GAIN_OF_CUBES,
        _ => GAIN,
    };
    vec![
        Check::at_least(
            format!("{scene}, exact S_u: n_it as published over n_it relaxed"),
            gain,
            published.most(0) / ours.most(0),
        ),
        Check::at_most(
            format!("{scene}, AMG: n_it relaxed, less one, over n_it as published"),
            LOSS,
            (ours.most(1) - 1.0) / published.most(1),
        ),
    ]
}

impl Experiment for Relaxed {
    fn id(&self) -> &'static str {
        "e06b"
    }

    fn title(&self) -> &'static str {
        "A diagonal C and an H that couples faces"
    }

    fn question(&self) -> &'static str {
        "C must dominate H, and a diagonal C that does so is too large for everything but checkerboards: does a relaxation of H \
         on either side of M⁻¹ make up for it?"
    }

    fn setup(&self) -> &'static str {
        "W M⁻¹ Wᵀ with W = p(27γ/4 C⁻¹H) on the tractions, p the polynomial of lowest degree with ½ ≤ x p² ≤ 1 up to 27γ/4 λ_max(C⁻¹H) \
         (degree 1: W = I − γ C⁻¹H; at most 4); C = C_local + diag(H) (local_h), C_local + blkdiag(H)/2 (half_h) and C_local + θ \
         blkdiag(H) with θ = 2/√ρ in [1/15, ½], ρ = tr H_ff / tr (Bᵀ diag(A)⁻¹ B)_ff (fitted_h). `clamped`, `layered` (contrast 1000), `stretched` (cells of 1:50), \
         `layered_crossing` (60° of dip, contrast 10). GMRES(100) to a true residual of 1e-8 under the physical load and \
         b_i = sin i, with exact S_u, and with AMG (flexible there). \
         Then `stretched` with cells of 1:1 to 1:200, wide along both long axes or along one, around geometric multigrid."
    }

    fn expect(&self) -> &'static str {
        "For modes that S, H and C share, λ₁λ₂ = (1 − γh/c)² (s + h)/(s + c) (derived): checkerboards, where h is up to 2 diag(H) \
         and s small, come down to the others, and C may be halved, and smaller by 1/√ρ in flat cells. Fewer iterations wherever C_local is small beside H; with \
         AMG as far as AMG is not what limits them. On flat cells H exceeds what A does to jumps by ρ, and with C of the order √ρ \
         iterations do not grow with the ratio of sides."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word());
        let mut table = Table::new(
            "e06b_relaxation",
            "Iterations with H relaxed by γ on either side of M⁻¹.",
            &[
                "scene",
                "n_u",
                "n_t",
                "C",
                "γ",
                "γ taken",
                "degree",
                "n_it exact, load",
                "n_it exact, sin",
                "n_it AMG, load",
                "n_it AMG, sin",
            ],
        );
        let direct = DirectChoice::Auto.solver()?;
        for (number, scene) in SCENES.into_iter().enumerate() {
            let entry = named(scene).ok_or_else(|| anyhow::anyhow!("no scene {scene}"))?;
            let blocks = blocks(entry, level == Level::Smoke)?;
            let mut all = Vec::new();
            for (k, choice) in CHOICES.into_iter().enumerate() {
                let step = Step::Progress {
                    stage: scene,
                    done: CHOICES.len() * number + k,
                    total: CHOICES.len() * SCENES.len(),
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                all.extend(rows(&blocks, choice, direct.as_ref())?);
            }
            for row in &all {
                let cell = |inner: usize, rhs: usize| count_cell(Some(&row.counts[inner][rhs]));
                let cells: [Cell; 11] = [
                    scene.into(),
                    blocks.n_u().into(),
                    blocks.n_t().into(),
                    row.choice.name().into(),
                    row.asked.into(),
                    row.taken.gamma.into(),
                    row.taken.degree.into(),
                    cell(0, 0),
                    cell(0, 1),
                    cell(1, 0),
                    cell(1, 1),
                ];
                table.push(cells);
            }
            if scene == DRAWN {
                findings.figures.push(spectra(entry)?);
            }
            findings.figures.push(figure(scene, &all));
            findings.checks.extend(checks(scene, &all));
        }
        findings.tables.push(table);
        flat_cells::add(&mut findings, level, observer)?;
        Ok(findings)
    }
}
