//! e17: parallel fractures that a fluid opens: four of them coarse and fine, and nine on six meshes.

use crate::flow_runs::{FlowRun, table};
use crate::report::{Check, Experiment, Findings, Level, Table};
use crate::scenes::with_cells;
use fracas::scene::Scene;
use fracas_solvers::Observer;

/// How many iterations do flow and mechanics together take, and how do they grow with the mesh?
#[derive(Debug)]
pub struct FourFractures;

/// A scene and its meshes.
struct Family {
    file: &'static str,
    text: &'static str,
    /// Cells per axis and the printed sizes.
    meshes: &'static [(usize, &'static str)],
}

/// Four fractures, on 25 and 50 cells per axis.
const FOUR: &str = include_str!("e17_four_fractures.toml");

/// Nine fractures of 6m × 6m faces among (10m)³ cells, m = 1 to 6.
const NINE: &str = include_str!("e17_nine_fractures.toml");

const NOT_PRINTED: &str = "not printed";

/// Growth of the median of iterations over the meshes of a family. Unit: 1.
const GROWTH: f64 = 1.2;

/// Displacements from which on a mesh tells how iterations grow: coarser ones are solved by few levels.
const TELLS: usize = 10_000;

impl Family {
    fn all(level: Level) -> [Self; 2] {
        let [four, nine]: [&'static [_]; 2] = match level {
            Level::Smoke => [
                &[(5, NOT_PRINTED), (10, NOT_PRINTED)],
                &[(10, "4,668 + 972 + 324")],
            ],
            Level::Paper => [
                &[
                    (25, "55,080 + 2,700 + 900"),
                    (50, "408,045 + 10,800 + 3,600"),
                ],
                &[
                    (10, "4,668 + 972 + 324"),
                    (20, "31,050 + 3,888 + 1,296"),
                    (30, "97,176 + 8,749 + 2,916"),
                    (40, "221,046 + 15,552 + 5,184"),
                    (50, "420,600 + 24,300 + 8,100"),
                    (60, "714,018 + 34,992 + 11,664"),
                ],
            ],
        };
        [
            Self {
                file: "e17_four_fractures.toml",
                text: FOUR,
                meshes: four,
            },
            Self {
                file: "e17_nine_fractures.toml",
                text: NINE,
                meshes: nine,
            },
        ]
    }

    /// A row of `sheet` and the claims of every mesh, coarse to fine.
    fn run(&self, sheet: &mut Table, observer: &mut dyn Observer) -> anyhow::Result<Vec<Check>> {
        let scene = Scene::from_toml(self.text, self.file)?;
        let (mut checks, mut medians) = (Vec::new(), Vec::new());
        for (cells, printed) in self.meshes {
            let scene = with_cells(&scene, [*cells; 3])?;
            let run = FlowRun::of(&format!("{cells}³"), &scene, observer)?;
            sheet.rows.push(run.row(printed));
            checks.extend(run.checks());
            if 3 * run.body.mesh.nodes.len() >= TELLS {
                medians.push(run.median_iterations());
            }
        }
        if let [first, finer @ ..] = &medians[..]
            && let Some(most) = finer.iter().max()
        {
            let claim = format!(
                "{}: growth of the median of Krylov iterations over the meshes from {TELLS} displacements on",
                sheet.id
            );
            let growth = *most as f64 / *first as f64;
            checks.push(Check::at_most(claim, GROWTH, growth));
        }
        Ok(checks)
    }
}

impl Experiment for FourFractures {
    fn id(&self) -> &'static str {
        "e17"
    }

    fn title(&self) -> &'static str {
        "Parallel fractures opened by a fluid"
    }

    fn question(&self) -> &'static str {
        "How many iterations do flow and mechanics together take, and how do they grow with the mesh and with the share of the fractures?"
    }

    fn setup(&self) -> &'static str {
        "A cube of 25 m under 5 to 9 MPa, four parallel fractures of 15 m × 15 m, 5 L/s of water into the middle of each, four steps of 1 s. \
         Paper 25 and 50 cells per axis, smoke 5 and 10. Then a cube of 10 m with nine parallel fractures of 6 m × 6 m and 0.8 L/s each, on 10 to 60 cells per axis, \
         smoke 10: the printed sizes of the test of ratios follow from 6m × 6m faces among (10m)³ cells, n_u = 3((10m + 1)³ + 9(6m − 1)²), n_p = 324 m². \
         The printed 8,749 and 420,600 are 8,748 and 420,660 then, as the printed totals have them. n_u counts all displacements, as printed; place and load of the fractures are \
         not printed. FGMRES around RACP, S_p of half order."
    }

    fn expect(&self) -> &'static str {
        "At most 25 Krylov iterations to 1e-8 per Newton step, at most 1.2 times as many on finer meshes of a family, counted from 10,000 displacements on: with 4,668 of them there are fewer, since few levels solve them. \
         At most six Newton steps per step; no volume is lost."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings
            .set("scene", FOUR)
            .set("scene_of_ratios", NINE)
            .set("level", level.word());
        for (family, (id, caption)) in Family::all(level).iter().zip([
            (
                "e17_four_fractures",
                "Iterations of every mesh; medians over the steps with flow.",
            ),
            (
                "e17_ratios",
                "The same for nine fractures, whose share of the unknowns falls as the mesh is refined.",
            ),
        ]) {
            let mut sheet = table(id, caption);
            let checks = family.run(&mut sheet, observer)?;
            findings.checks.extend(checks);
            findings.tables.push(sheet);
        }
        Ok(findings)
    }
}
