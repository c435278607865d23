//! e03: conditioning of A and S_u on analogues of the published tests A, B and C.

use crate::plot::{Axis, Figure, Mark, Series};
use crate::published::TESTS;
use crate::report::{Check, Experiment, Findings, Level, Table};
use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::AugmentationChoice;
use fracas_solvers::spectrum::condition::{schur_ends, stiffness_ends};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Does the augmentation make A worse or better conditioned?
#[derive(Debug)]
pub struct Conditioning;

/// Unknowns from which an analogue counts as one.
const ENOUGH: usize = 20_000;

impl Experiment for Conditioning {
    fn id(&self) -> &'static str {
        "e03"
    }

    fn title(&self) -> &'static str {
        "Conditioning of A and of the primal Schur complement"
    }

    fn question(&self) -> &'static str {
        "What does the augmentation do to the condition number of the block that multigrid will have to invert?"
    }

    fn setup(&self) -> &'static str {
        "Analogues of tests A, B, C: same character and n_t/n_u, 30,000 to 60,000 unknowns each (the published meshes are \
         not public). κ₂ by Lanczos on A and S_u and on their inverses by sparse Cholesky, with residual error bars; the \
         kernel of a singular A is counted and κ is then taken on its complement."
    }

    fn expect(&self) -> &'static str {
        "A: κ(A) infinite (blocks held only by fractures), κ(S_u) finite. B, C: S_u is a stiffness with springs across the \
         fractures, so κ(S_u) stays within a small factor of κ(A) with a local C; a bad C (γ too small) ruins it."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word());
        let choices = [
            AugmentationChoice::LocalH,
            AugmentationChoice::Local,
            AugmentationChoice::Global,
            AugmentationChoice::GlobalTimes(1e-3),
        ];
        let mut table = Table::new(
            "e03_conditioning",
            "Condition numbers on the analogues; error bars are relative.",
            &[
                "test (analogue)",
                "n_u",
                "n_t",
                "n_t/n_u [%]",
                "published n_t/n_u [%]",
                "C",
                "dim ker A",
                "κ(A) off ker A",
                "κ(S_u)",
                "error bar",
            ],
        );
        let direct = DirectChoice::Auto.solver()?;
        let mut bars: Vec<(String, f64)> = Vec::new();
        let total = TESTS.len() * choices.len();
        for (k, test) in TESTS.iter().enumerate() {
            let entry =
                named(test.scene).ok_or_else(|| anyhow::anyhow!("no scene {}", test.scene))?;
            let scene = match level {
                Level::Smoke => entry.small_scene()?,
                Level::Paper => entry.scene()?,
            };
            let blocks = scene
                .build()?
                .saddle_blocks(Some(JumpStabilization::PUBLISHED))?;
            let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
            let percent = |n_t: usize, n_u: usize| 100.0 * n_t as f64 / n_u as f64;
            if level == Level::Paper {
                findings.checks.push(Check::at_least(
                    format!("{}: unknowns", test.scene),
                    ENOUGH as f64,
                    (n_u + n_t) as f64,
                ));
                findings.checks.push(Check::close(
                    format!("{}: n_t/n_u [%] beside the published one", test.scene),
                    percent(test.n_t, test.n_u),
                    percent(n_t, n_u),
                    0.05,
                ));
            }
            let a = stiffness_ends(&blocks, &*direct)?;
            let singular = a.kernel > 0;
            let kappa_a = a.ends.map_or(f64::INFINITY, |e| e.condition());
            for (c, choice) in choices.iter().enumerate() {
                let step = Step::Progress {
                    stage: "condition numbers",
                    done: k * choices.len() + c,
                    total,
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                let matrix = choice.compute(&blocks, &*direct)?.matrix;
                let s_u = schur_ends(&blocks, &matrix, None, &*direct)?;
                if c == 0 {
                    bars.push((format!("{}: A", test.name), kappa_a));
                    findings.checks.push(Check::holds(
                        format!(
                            "{}: A is {}",
                            test.scene,
                            if test.name == "A" {
                                "singular"
                            } else {
                                "regular"
                            }
                        ),
                        if test.name == "A" {
                            "singular"
                        } else {
                            "regular"
                        },
                        format!("dim ker A = {}", a.kernel),
                        singular == (test.name == "A"),
                    ));
                    findings.checks.push(Check::holds(
                        format!("{}: S_u is regular", test.scene),
                        "finite",
                        format!("κ(S_u) = {:.3e}", s_u.condition()),
                        s_u.condition().is_finite(),
                    ));
                }
                bars.push((format!("{}: S_u, {choice}", test.name), s_u.condition()));
                table.push([
                    test.name.into(),
                    n_u.into(),
                    n_t.into(),
                    percent(n_t, n_u).into(),
                    percent(test.n_t, test.n_u).into(),
                    choice.to_string().into(),
                    a.kernel.into(),
                    kappa_a.into(),
                    s_u.condition().into(),
                    (s_u.error() + a.ends.map_or(0.0, |e| e.error())).into(),
                ]);
            }
        }
        let names = bars.iter().rev().map(|(name, _)| name.clone()).collect();
        let mut figure = Figure::new(
            "e03_kappa",
            "",
            "Condition numbers of A (off its kernel) and of S_u for four choices of C.",
            Axis::log("κ₂"),
            Axis::categories("", names),
        );
        for test in &TESTS {
            let points = bars
                .iter()
                .rev()
                .enumerate()
                .filter(|(_, (name, _))| name.starts_with(test.name))
                .map(|(height, (_, kappa))| [*kappa, height as f64])
                .collect();
            let name = format!("analogue of test {}", test.name);
            figure = figure.with(Series::new(&name, Mark::Points, points));
        }
        findings.figures.push(figure);
        findings.tables.push(table);
        findings.notes.push(
            "The published slide prints no numbers; the comparison is of character, not of values."
                .into(),
        );
        Ok(findings)
    }
}
