//! e17: four fractures that a fluid opens, coarse to fine.

use crate::flow_runs::{FlowRun, table};
use crate::report::{Check, Experiment, Findings, Level};
use fracas::scene::Scene;
use fracas_solvers::Observer;

/// How many iterations do flow and mechanics together take, and how do they grow with the mesh?
#[derive(Debug)]
pub struct FourFractures;

/// The scene, on 25 cells per axis.
const SCENE: &str = include_str!("e17_four_fractures.toml");

/// Cells per axis and the printed sizes.
const PAPER: [(usize, &str); 2] = [
    (25, "55,080 + 2,700 + 900"),
    (50, "408,045 + 10,800 + 3,600"),
];
const SMOKE: [(usize, &str); 2] = [(5, "not printed"), (10, "not printed")];

impl Experiment for FourFractures {
    fn id(&self) -> &'static str {
        "e17"
    }

    fn title(&self) -> &'static str {
        "Four fractures opened by a fluid"
    }

    fn question(&self) -> &'static str {
        "How many iterations do flow and mechanics together take, and how do they grow with the mesh?"
    }

    fn setup(&self) -> &'static str {
        "A cube of 25 m under 5 to 9 MPa, four parallel fractures of 15 m × 15 m, 5 L/s of water into the middle of each, four steps of 1 s. \
         Paper 25 and 50 cells per axis, smoke 5 and 10. n_u counts all displacements, as printed; place and size of the fractures are \
         not printed. FGMRES around RACP, S_p of half order."
    }

    fn expect(&self) -> &'static str {
        "At most 25 Krylov iterations to 1e-8 per Newton step, at most 1.2 times as many on the fine mesh; at most six Newton steps per step; \
         no volume is lost."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("scene", SCENE).set("level", level.word());
        let scene = Scene::from_toml(SCENE, "e17_four_fractures.toml")?;
        let sizes = match level {
            Level::Smoke => SMOKE,
            Level::Paper => PAPER,
        };
        let mut sheet = table(
            "e17_four_fractures",
            "Iterations of every mesh; medians over the steps with flow.",
        );
        let mut medians = Vec::new();
        for (cells, printed) in sizes {
            let sets = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells={cells}"));
            let run = FlowRun::of(
                &format!("{cells}³"),
                &scene.with_overrides(&sets)?,
                observer,
            )?;
            sheet.rows.push(run.row(printed));
            findings.checks.extend(run.checks());
            let iterations = run.iterations();
            medians.push(iterations.get(iterations.len() / 2).copied().unwrap_or(0));
        }
        if level == Level::Paper {
            let growth = medians[1] as f64 / medians[0] as f64;
            let claim = "growth of the median of Krylov iterations from coarse to fine";
            findings.checks.push(Check::at_most(claim, 1.2, growth));
        }
        findings.tables.push(sheet);
        Ok(findings)
    }
}
