//! e02: the spectrum of M⁻¹𝒜 for every C, with exact S_u and with a simple approximation, against the theorems.

use crate::plot::{Axis, Figure, Mark, Region, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::contact::JumpStabilization;
use fracas::scene::{Scene, named};
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, SaddleBlocks};
use fracas_solvers::smoothers::Ssor;
use fracas_solvers::spectrum::{Bounds, SpectrumReport, SpectrumRequest, Theorem, analyse};
use fracas_solvers::{Observer, SetupError, Step};
use std::ops::ControlFlow;

/// Every C but half_h and fitted_h, which belong to RACP that relaxes H (e06b).
pub(crate) const CHOICES: [AugmentationChoice; 6] = [
    AugmentationChoice::Local,
    AugmentationChoice::Global,
    AugmentationChoice::Exact,
    AugmentationChoice::LocalH,
    AugmentationChoice::ExactH,
    AugmentationChoice::FaceBlock,
];

/// Where do the eigenvalues lie for each choice of C, and do the theorems contain them?
#[derive(Debug)]
pub struct Spectra;

/// Scene of the figures: a fracture cuts a body that is held at both ends, so A is regular and B of full rank.
const SCENE: &str = "clamped";

/// Scene whose bare pair has a kernel: what needs C = BᵀA⁻¹B regular does not apply without H.
const DEFICIENT: &str = "crossing";

/// Scene of the stress test: layers with a stiffness contrast of 1000.
const CONTRAST: &str = "layered";

/// Blocks of a scene with or without stabilization.
fn blocks(scene: &Scene, with_h: bool) -> anyhow::Result<SaddleBlocks> {
    Ok(scene
        .build()?
        .saddle_blocks(with_h.then_some(JumpStabilization::PUBLISHED))?)
}

/// A scene of the gallery at the size of this level.
fn scene(name: &str, level: Level) -> anyhow::Result<Scene> {
    let entry = named(name).ok_or_else(|| anyhow::anyhow!("the gallery has no scene {name}"))?;
    Ok(match level {
        Level::Smoke => entry.small_scene()?,
        Level::Paper => entry.scene()?,
    })
}

/// Eigenvalues besides the n_u ones that an exact S_u always gives.
fn others(report: &SpectrumReport) -> Vec<f64> {
    let mut values = report.eigenvalues.re.clone();
    let mut ones = report.n_u;
    values.retain(|v| {
        let drop = ones > 0 && *v == 1.0;
        ones -= usize::from(drop);
        !drop
    });
    values
}

/// The interval that holds all eigenvalues when S_u is exact.
fn interval(report: &SpectrumReport) -> Option<(f64, f64)> {
    report
        .exact_S_u_interval
        .or(report.bounds.real_low.zip(report.bounds.real_high))
}

/// Runs one choice and adds its row; a choice that does not apply is a row too.
fn row(
    table: &mut Table,
    scene: &str,
    blocks: &SaddleBlocks,
    request: &SpectrumRequest,
    notes: &mut Vec<String>,
    observer: &mut dyn Observer,
) -> anyhow::Result<Option<SpectrumReport>> {
    let stage = Step::Progress {
        stage: "spectra",
        done: table.rows.len(),
        total: 4 * CHOICES.len(),
    };
    if observer.observe(&stage) == ControlFlow::Break(()) {
        anyhow::bail!("stopped on request");
    }
    let h = if blocks.h.is_some() { "H" } else { "0" };
    let head = [
        scene.into(),
        h.into(),
        request.inner.name().into(),
        request.augmentation.to_string().into(),
    ];
    match analyse(blocks, request, observer) {
        Ok(report) => {
            let [a, b, c, d] = head;
            let (low, high) = interval(&report).unzip();
            table.push([
                a,
                b,
                c,
                d,
                report.c_max.into(),
                report.cond_S_u.into(),
                report.re_min.into(),
                report.re_max.into(),
                report.im_max.into(),
                low.into(),
                high.into(),
                match report.contained {
                    Some(true) => "inside".into(),
                    Some(false) => "OUTSIDE".into(),
                    None => Cell::Missing,
                },
            ]);
            Ok(Some(report))
        }
        Err(
            reason @ (SetupError::NotApplicable { .. } | SetupError::NotPositiveDefinite { .. }),
        ) => {
            let mut cells: Vec<Cell> = head.into();
            cells.extend(std::iter::repeat_n(Cell::Failed, 7));
            cells.push("no C".into());
            table.rows.push(cells);
            notes.push(format!("{scene}, C = {}: {reason}.", request.augmentation));
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// One row per C: eigenvalues as points, the proved interval as a line below them.
fn strip(id: &str, caption: &str, reports: &[SpectrumReport]) -> Figure {
    let rows: Vec<(String, Vec<f64>)> = reports
        .iter()
        .map(|r| {
            let mut values = others(r);
            // stands for the n_u ones
            values.push(1.0);
            (r.augmentation.clone(), values)
        })
        .collect();
    let mut figure = Figure::rows(id, "", caption, Axis::log("λ"), &rows);
    for (k, report) in reports.iter().enumerate() {
        if let Some((low, high)) = interval(report) {
            let height = (reports.len() - 1 - k) as f64 - 0.3;
            let name = if k == 0 { "proved interval" } else { "" };
            let line = vec![[low, height], [high, height]];
            figure = figure.with(Series::new(name, Mark::Line, line).tone(7));
        }
    }
    figure
}

/// The check that the proved region has every eigenvalue, and the figure `{id}_{C}_{h or 0}` of both; `inner` stands in for
/// S_u⁻¹: its name, and the same in more words.
pub(crate) fn region(
    id: &str,
    inner: [&str; 2],
    with_h: bool,
    report: &SpectrumReport,
) -> (Check, Figure) {
    let [name, in_words] = inner;
    let c = &report.augmentation;
    let (h, tag, theorem) = if with_h {
        ("H ≠ 0", "h", "the extension of theorem 2")
    } else {
        ("H = 0", "0", "theorem 2 (with the sharper disc)")
    };
    let check = Check::holds(
        format!("{c}, {h}: {name} for S_u, every eigenvalue in the proved region"),
        "inside",
        format!("{} outside", report.outside.len()),
        report.contained == Some(true),
    );
    let caption = format!(
        "{h}, C = {c}, {in_words} for S_u⁻¹: all {} eigenvalues over the region that {theorem} proves.",
        report.n_u + report.n_t,
    );
    (check, plane(&format!("{id}_{c}_{tag}"), &caption, report))
}

/// Eigenvalues in the complex plane over the proved region.
fn plane(id: &str, caption: &str, report: &SpectrumReport) -> Figure {
    let points = report.eigenvalues.iter().map(|(re, im)| [re, im]).collect();
    let mut figure = Figure::complex_plane(id, "", caption, &[("eigenvalues", points)]);
    let Bounds {
        real_low,
        real_high,
        re_low,
        re_high,
        im_max,
        theorem,
        ..
    } = report.bounds;
    if let (Some(a), Some(b), Some(im)) = (re_low, re_high, im_max) {
        figure = figure.shade(
            "bound, non-real",
            Region::Rectangle {
                x: [a, b],
                y: [-im, im],
            },
        );
    }
    if let (Some(a), Some(b)) = (real_low, real_high) {
        figure = figure.shade("bound, real", Region::RealInterval([a, b]));
    }
    if theorem == Theorem::WithoutH {
        figure = figure.shade(
            "disc |λ − ½| ≤ ½",
            Region::Disc {
                center: [0.5, 0.0],
                radius: 0.5,
            },
        );
    }
    figure
}

impl Experiment for Spectra {
    fn id(&self) -> &'static str {
        "e02"
    }

    fn title(&self) -> &'static str {
        "Spectra of the preconditioned system for every C"
    }

    fn question(&self) -> &'static str {
        "Where do the eigenvalues of M⁻¹𝒜 lie for each choice of C, and do the theorems contain every one of them?"
    }

    fn setup(&self) -> &'static str {
        "Gallery scene `clamped` (one fracture cuts a body held at both ends), with and without the jump stabilization H; all \
         eigenvalues, S_u exact (the left panel of the published figure), then SSOR for S_u⁻¹ at a small size as the first \
         inexact one. `crossing` (rank-deficient B) and `layered` (stiffness contrast 1000) are the stress tests of C."
    }

    fn expect(&self) -> &'static str {
        "Theorem 1: with H = 0 and C = BᵀA⁻¹B, 1 (n_u times) and ½ (n_t times). Exact S_u: real spectra, in the proved \
         interval; C = H-blind choices reach far beyond 1 when H ≠ 0, local_h does not (derived). Inexact S_u: inside the \
         region of theorem 2 for H = 0 and of its extension for H ≠ 0, where the printed region fails (derived)."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings
            .set("scene", SCENE)
            .set("contrast_scene", CONTRAST)
            .set("level", level.word());
        let mut table = Table::new(
            "e02_spectra",
            "Extreme eigenvalues and the proved interval. A choice that does not apply says why.",
            &[
                "scene",
                "(2,2)",
                "inner",
                "C",
                "max C [m³/Pa]",
                "κ(S_u)",
                "min Re λ",
                "max Re λ",
                "max |Im λ|",
                "proved low",
                "proved high",
                "verdict",
            ],
        );
        let full = scene(SCENE, level)?;
        for with_h in [false, true] {
            let blocks = blocks(&full, with_h)?;
            let mut reports = Vec::new();
            for augmentation in CHOICES {
                let request = SpectrumRequest {
                    augmentation,
                    ..SpectrumRequest::default()
                };
                let Some(report) = row(
                    &mut table,
                    SCENE,
                    &blocks,
                    &request,
                    &mut findings.notes,
                    observer,
                )?
                else {
                    continue;
                };
                let label = format!("{augmentation}, {}", if with_h { "H ≠ 0" } else { "H = 0" });
                findings.checks.push(Check::holds(
                    format!("{label}: exact S_u, every eigenvalue in the proved region"),
                    "inside",
                    format!("{:?} outside", report.outside.len()),
                    report.contained == Some(true),
                ));
                if augmentation == AugmentationChoice::Exact && !with_h {
                    findings.checks.push(Check::equal(
                        "theorem 1: eigenvalues at 1 (n_u)",
                        report.n_u,
                        report.n_at_one,
                    ));
                    findings.checks.push(Check::equal(
                        "theorem 1: eigenvalues at ½ (n_t)",
                        report.n_t,
                        report.n_at_half,
                    ));
                }
                reports.push(report);
            }
            let (id, words) = if with_h {
                ("e02_exact_h", "H ≠ 0")
            } else {
                ("e02_exact", "H = 0")
            };
            let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
            let caption = format!(
                "{words}: exact S_u, a row per C; n_u = {n_u} eigenvalues are 1, the marks show that and the other n_t = {n_t}; below each row the \
                 interval that the theorem proves."
            );
            findings.figures.push(strip(id, &caption, &reports));
        }

        let deficient = blocks(&scene(DEFICIENT, Level::Smoke)?, false)?;
        for augmentation in [AugmentationChoice::Exact, AugmentationChoice::Local] {
            let request = SpectrumRequest {
                augmentation,
                ..SpectrumRequest::default()
            };
            row(
                &mut table,
                DEFICIENT,
                &deficient,
                &request,
                &mut findings.notes,
                observer,
            )?;
        }
        let contrast = blocks(&scene(CONTRAST, Level::Smoke)?, true)?;
        let mut highest = [f64::NAN; 2];
        for (slot, augmentation) in [AugmentationChoice::Local, AugmentationChoice::LocalH]
            .into_iter()
            .enumerate()
        {
            let request = SpectrumRequest {
                augmentation,
                ..SpectrumRequest::default()
            };
            if let Some(report) = row(
                &mut table,
                CONTRAST,
                &contrast,
                &request,
                &mut findings.notes,
                observer,
            )? {
                highest[slot] = report.re_max.unwrap_or(f64::NAN);
            }
        }
        findings.checks.push(Check::at_most(
            "contrast 1000, local_h: largest eigenvalue",
            3.0,
            highest[1],
        ));
        findings.checks.push(Check::at_least(
            "contrast 1000: local over local_h, largest eigenvalue",
            2.0,
            highest[0] / highest[1],
        ));

        let small = scene(SCENE, Level::Smoke)?;
        let mut printed_fails = 0;
        for with_h in [false, true] {
            let blocks = blocks(&small, with_h)?;
            for augmentation in [AugmentationChoice::Local, AugmentationChoice::LocalH] {
                if !with_h && augmentation == AugmentationChoice::LocalH {
                    continue;
                }
                let request = SpectrumRequest {
                    augmentation,
                    inner: InnerChoice::Ssor(Ssor::default()),
                    ..SpectrumRequest::default()
                };
                let Some(report) = row(
                    &mut table,
                    SCENE,
                    &blocks,
                    &request,
                    &mut findings.notes,
                    observer,
                )?
                else {
                    continue;
                };
                let (check, figure) = region("e02_ssor", ["SSOR"; 2], with_h, &report);
                findings.checks.push(check);
                findings.figures.push(figure);
                if with_h {
                    printed_fails += report.printed.as_ref().map_or(0, |p| p.outside.len());
                }
            }
        }
        findings.checks.push(Check::at_least(
            "H ≠ 0: eigenvalues outside the region as printed (valid for H = 0 only)",
            1.0,
            printed_fails as f64,
        ));
        findings.tables.push(table);
        Ok(findings)
    }
}
