//! e02b: the spectrum of M⁻¹𝒜 with multigrid for S_u⁻¹, all of it on a small body, its ends on a large one.

use crate::e02_spectra::{CHOICES, region};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_solvers::amg::Amg;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::multigrid::Precision;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, SaddleBlocks};
use fracas_solvers::spectrum::{Eigenvalues, SpectrumReport, SpectrumRequest, analyse};
use fracas_solvers::{Observer, SetupError, Step};
use std::ops::ControlFlow;

/// Where do the eigenvalues lie when multigrid stands in for S_u⁻¹?
#[derive(Debug)]
pub struct SpectrumAmg;

/// Scene of the whole spectra, as in e02.
const SCENE: &str = "clamped";

/// Scene of the ends, and its cells in print: 100 thousand unknowns.
const LARGE: &str = "analogue_b";
const LARGE_CELLS: [&str; 3] = ["mesh.x.cells=30", "mesh.y.cells=32", "mesh.z.cells=32"];

/// Unknowns at which the direct solver takes over in the small body, so that it has two levels at least.
const COARSEST: usize = 60;

/// Unknowns that the large body has at least in print.
const ENOUGH: f64 = 1e5;

/// Largest relative difference between ends by Lanczos and ends of dense matrices.
const AGREE: f64 = 1e-6;

fn multigrid(precision: Precision, coarsest: usize) -> InnerChoice {
    InnerChoice::Amg(Amg {
        precision,
        coarsest,
        ..Amg::default()
    })
}

fn blocks(scene: &str, overrides: &[&str], with_h: bool) -> anyhow::Result<SaddleBlocks> {
    let entry = named(scene).ok_or_else(|| anyhow::anyhow!("no scene {scene}"))?;
    let stabilization = with_h.then_some(JumpStabilization::PUBLISHED);
    Ok(entry
        .scene()?
        .with_overrides(overrides)?
        .build()?
        .saddle_blocks(stabilization)?)
}

/// The report, or the reason why there is none: C = BᵀA⁻¹B and a method that does not apply are rows.
fn analysed(
    blocks: &SaddleBlocks,
    request: &SpectrumRequest,
    observer: &mut dyn Observer,
) -> anyhow::Result<Result<SpectrumReport, String>> {
    match analyse(blocks, request, observer) {
        Ok(report) => Ok(Ok(report)),
        Err(
            reason @ (SetupError::NotApplicable { .. } | SetupError::NotPositiveDefinite { .. }),
        ) => Ok(Err(reason.to_string())),
        Err(error) => Err(error.into()),
    }
}

/// Levels of the hierarchy that stands for S_u⁻¹.
fn levels(blocks: &SaddleBlocks, request: &SpectrumRequest) -> anyhow::Result<usize> {
    let direct = DirectChoice::Auto.solver()?;
    let c = request.augmentation.compute(blocks, direct.as_ref())?;
    let ready = request.inner.prepare(blocks, &c.matrix)?;
    Ok(ready.hierarchy.map_or(0, |h| h.levels.len()))
}

/// `max_i min_j |λ_i − μ_j|`, the larger of both ways: how far apart two spectra lie.
fn distance(a: &Eigenvalues, b: &Eigenvalues) -> f64 {
    let one_way = |a: &Eigenvalues, b: &Eigenvalues| {
        a.iter()
            .map(|(x, y)| {
                b.iter()
                    .map(|(u, v)| (x - u).hypot(y - v))
                    .fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
    };
    one_way(a, b).max(one_way(b, a))
}

const HEADINGS: [&str; 15] = [
    "(2,2)",
    "C",
    "levels",
    "α_u",
    "β_u",
    "α_t",
    "β_t",
    "non-real",
    "min Re λ",
    "max Re λ",
    "max |Im λ|",
    "proved low",
    "proved high",
    "proved |Im λ|",
    "verdict",
];

fn verdict(report: &SpectrumReport) -> Cell {
    match report.contained {
        Some(true) => "inside".into(),
        Some(false) => "OUTSIDE".into(),
        None => Cell::Missing,
    }
}

/// The cells of one analysed C after the first three.
fn numbers(report: &SpectrumReport) -> [Cell; 12] {
    let b = &report.bounds;
    [
        b.alpha_u.into(),
        b.beta_u.into(),
        b.alpha_t.into(),
        b.beta_t.into(),
        report.n_complex.into(),
        report.re_min.into(),
        report.re_max.into(),
        report.im_max.into(),
        b.real_low.into(),
        b.real_high.into(),
        b.im_max.into(),
        verdict(report),
    ]
}

/// All eigenvalues for every C, with and without H.
fn whole_spectra(
    findings: &mut Findings,
    level: Level,
    observer: &mut dyn Observer,
) -> anyhow::Result<()> {
    let cells = match level {
        Level::Smoke => ["mesh.x.cells=6", "mesh.y.cells=4", "mesh.z.cells=4"],
        Level::Paper => ["mesh.x.cells=8", "mesh.y.cells=6", "mesh.z.cells=6"],
    };
    let mut table = Table::new(
        "e02b_spectra",
        "All eigenvalues with multigrid (f64, W-cycle, at least two levels) for S_u⁻¹; α and β are the extreme values in the bounds.",
        &HEADINGS,
    );
    for with_h in [false, true] {
        let blocks = blocks(SCENE, &cells, with_h)?;
        let words = if with_h { "H ≠ 0" } else { "H = 0" };
        for augmentation in CHOICES {
            let request = SpectrumRequest {
                augmentation,
                inner: multigrid(Precision::F64, COARSEST),
                conditions: false,
                ..SpectrumRequest::default()
            };
            let head = [
                if with_h { "H" } else { "0" }.into(),
                augmentation.to_string().into(),
            ];
            let report = match analysed(&blocks, &request, observer)? {
                Ok(report) => report,
                Err(reason) => {
                    let mut cells = head.to_vec();
                    cells.extend(std::iter::repeat_n(Cell::Failed, 12));
                    cells.push("no C".into());
                    table.rows.push(cells);
                    findings
                        .notes
                        .push(format!("{words}, C = {augmentation}: {reason}."));
                    continue;
                }
            };
            let levels = levels(&blocks, &request)?;
            let mut cells = head.to_vec();
            cells.push(levels.into());
            cells.extend(numbers(&report));
            table.rows.push(cells);
            findings.checks.push(Check::at_least(
                format!("{augmentation}, {words}: levels"),
                2.0,
                levels as f64,
            ));
            let in_words = format!("multigrid of {levels} levels");
            let inner = ["multigrid", in_words.as_str()];
            let (check, figure) = region("e02b_amg", inner, with_h, &report);
            findings.checks.push(check);
            findings.figures.push(figure);
            if with_h && augmentation == AugmentationChoice::LocalH {
                single(findings, &blocks, &request, &report, observer)?;
            }
        }
    }
    findings.tables.push(table);
    Ok(())
}

/// The same hierarchy in f32: no longer symmetric to the digits of f64, so nothing is proved; how far do eigenvalues move?
fn single(
    findings: &mut Findings,
    blocks: &SaddleBlocks,
    request: &SpectrumRequest,
    double: &SpectrumReport,
    observer: &mut dyn Observer,
) -> anyhow::Result<()> {
    let request = SpectrumRequest {
        inner: multigrid(Precision::F32, COARSEST),
        ..request.clone()
    };
    let report = analyse(blocks, &request, observer)?;
    let moved = distance(&double.eigenvalues, &report.eigenvalues);
    // an eigenvalue of a k × k Jordan block moves by ε^{1/k}: 2e-4 for k = 2 and ε = 6e-8
    findings.checks.push(Check::at_most(
        "local_h, H ≠ 0: an eigenvalue moves from f64 to f32 by",
        1e-3,
        moved,
    ));
    findings.notes.push(format!(
        "Multigrid in f32 moves the eigenvalues of local_h with H ≠ 0 by {moved:.1e} at most."
    ));
    Ok(())
}

/// The ends of the spectrum where it is too large to be dense.
fn ends(findings: &mut Findings, level: Level, observer: &mut dyn Observer) -> anyhow::Result<()> {
    let (cells, dense) = match level {
        Level::Smoke => (["mesh.x.cells=5", "mesh.y.cells=4", "mesh.z.cells=4"], true),
        Level::Paper => (LARGE_CELLS, false),
    };
    let mut table = Table::new(
        "e02b_ends",
        "Extreme values behind the bounds by Lanczos, with the largest relative error bar among them, and what Arnoldi finds of \
         the outer eigenvalues.",
        &[
            "n_u",
            "n_t",
            "(2,2)",
            "C",
            "α_u",
            "β_u",
            "α_t",
            "β_t",
            "error bar",
            "min Re λ",
            "max Re λ",
            "proved low",
            "proved high",
            "verdict",
        ],
    );
    let blocks = blocks(LARGE, &cells, true)?;
    if !dense {
        findings.checks.push(Check::at_least(
            format!("{LARGE}: unknowns"),
            ENOUGH,
            blocks.size() as f64,
        ));
    }
    for augmentation in [AugmentationChoice::LocalH, AugmentationChoice::Local] {
        let request = SpectrumRequest {
            augmentation,
            inner: multigrid(
                Precision::F64,
                Amg::default()
                    .coarsest
                    .min(if dense { COARSEST } else { usize::MAX }),
            ),
            dense_limit: 0,
            conditions: false,
            ..SpectrumRequest::default()
        };
        let report = analyse(&blocks, &request, observer)?;
        let b = &report.bounds;
        table.push([
            report.n_u.into(),
            report.n_t.into(),
            "H".into(),
            augmentation.to_string().into(),
            b.alpha_u.into(),
            b.beta_u.into(),
            b.alpha_t.into(),
            b.beta_t.into(),
            report.error_bar.into(),
            report.re_min.into(),
            report.re_max.into(),
            b.real_low.into(),
            b.real_high.into(),
            verdict(&report),
        ]);
        findings.checks.push(Check::holds(
            format!(
                "{augmentation}, {} unknowns: every outer eigenvalue in the proved region",
                blocks.size()
            ),
            "inside",
            format!("{} outside", report.outside.len()),
            report.contained == Some(true),
        ));
        if dense {
            let all = analyse(
                &blocks,
                &SpectrumRequest {
                    dense_limit: SpectrumRequest::default().dense_limit,
                    ..request
                },
                observer,
            )?;
            let difference = [
                (b.alpha_u, all.bounds.alpha_u),
                (b.beta_u, all.bounds.beta_u),
                (b.alpha_t, all.bounds.alpha_t),
                (b.beta_t, all.bounds.beta_t),
            ]
            .into_iter()
            .filter_map(|(x, y)| x.zip(y).map(|(x, y)| (x - y).abs() / y.abs().max(1e-3)))
            .fold(0.0, f64::max);
            findings.checks.push(Check::at_most(
                format!("{augmentation}: α and β by Lanczos beside those of dense matrices"),
                AGREE,
                difference,
            ));
        }
    }
    findings.tables.push(table);
    Ok(())
}

/// One of the two questions of this experiment.
type Part = fn(&mut Findings, Level, &mut dyn Observer) -> anyhow::Result<()>;

impl Experiment for SpectrumAmg {
    fn id(&self) -> &'static str {
        "e02b"
    }

    fn title(&self) -> &'static str {
        "Spectra with multigrid for S_u"
    }

    fn question(&self) -> &'static str {
        "Where do the eigenvalues of M⁻¹𝒜 go when multigrid takes the place of S_u⁻¹, and do the theorems still hold every one?"
    }

    fn setup(&self) -> &'static str {
        "`clamped` at a size whose eigenvalues can all be computed, for every C, with and without H; multigrid in f64 with at \
         least two levels (the right panel of the published figure). Then `analogue_b` at 100 thousand unknowns: α_u, β_u, α_t, β_t by \
         Lanczos on pencils, the outer eigenvalues by Arnoldi."
    }

    fn expect(&self) -> &'static str {
        "Non-real eigenvalues appear, all of them in the rectangle of theorem 2 and, for H = 0, in the disc |λ − ½| ≤ ½ \
         (derived); real ones between the proved ends. With a good multigrid α_u and β_u stay close to those of exact S_u, and \
         f32 moves no eigenvalue that can be seen."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings
            .set("scene", SCENE)
            .set("large_scene", LARGE)
            .set("coarsest", COARSEST)
            .set("level", level.word());
        let parts: [Part; 2] = [whole_spectra, ends];
        for (done, part) in parts.into_iter().enumerate() {
            let step = Step::Progress {
                stage: "spectra with multigrid",
                done,
                total: parts.len(),
            };
            if observer.observe(&step) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            part(&mut findings, level, observer)?;
        }
        Ok(findings)
    }
}
