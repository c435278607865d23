//! C against the ratio of the sides of cells.

use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Findings, Level, Table};
use crate::trial::{Budget, Candidate, Load, Problem, Trial, trials};
use fracas::scene::named;
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, RELAXATION, Racp, SaddleMethod};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

const SCENE: &str = "stretched";

/// Half the height of the body, and of its fracture [m].
const HALF: [u32; 2] = [6, 4];

/// Wide over high.
fn ratios(level: Level) -> &'static [u32] {
    match level {
        Level::Paper => &[1, 2, 5, 10, 20, 50, 100, 200],
        Level::Smoke => &[1, 50],
    }
}

/// Cells per axis; the tips are on grid planes.
fn cells(level: Level) -> u32 {
    match level {
        Level::Paper => 48,
        Level::Smoke => 12,
    }
}

/// n_it with fitted_h, whatever the ratio, at most.
const MOST: f64 = 30.0;

/// Axes along which cells are wide; the fracture is normal to x.
const SHAPES: [(&str, &[&str]); 2] = [("flat", &["x", "y"]), ("long", &["x"])];

/// C and γ: as published, half of H, and what the project takes.
const METHODS: [(AugmentationChoice, f64); 3] = [
    (AugmentationChoice::LocalH, 0.0),
    (AugmentationChoice::HalfH, RELAXATION),
    (AugmentationChoice::FittedH, RELAXATION),
];

struct Row {
    shape: &'static str,
    ratio: u32,
    n: [usize; 2],
    c: AugmentationChoice,
    gamma: f64,
    trial: Trial,
}

fn problem(wide: &[&str], ratio: u32, cells: u32) -> anyhow::Result<Problem> {
    let entry = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
    let [body, fracture] = HALF;
    let overrides: Vec<String> = ["x", "y", "z"]
        .into_iter()
        .flat_map(|axis| {
            let factor = if wide.contains(&axis) { ratio } else { 1 };
            let (body, fracture) = (body * factor, fracture * factor);
            let mut all = vec![
                format!("mesh.{axis}.from='-{body} m'"),
                format!("mesh.{axis}.to='{body} m'"),
                format!("mesh.{axis}.cells={cells}"),
            ];
            if axis != "x" {
                all.push(format!(
                    "fracture.fault.{axis}=['-{fracture} m','{fracture} m']"
                ));
            }
            all
        })
        .collect();
    Problem::new(&entry.scene()?.with_overrides(&overrides)?)
}

fn rows(level: Level, observer: &mut dyn Observer) -> anyhow::Result<Vec<Row>> {
    let mut rows = Vec::new();
    let ratios = ratios(level);
    for (k, (shape, wide)) in SHAPES.into_iter().enumerate() {
        for (i, &ratio) in ratios.iter().enumerate() {
            let step = Step::Progress {
                stage: shape,
                done: ratios.len() * k + i,
                total: ratios.len() * SHAPES.len(),
            };
            if observer.observe(&step) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            let problem = problem(wide, ratio, cells(level))?;
            for (c, gamma) in METHODS {
                let candidate = Candidate {
                    name: c.name(),
                    method: SaddleMethod::Racp(Racp {
                        augmentation: c,
                        relaxation: gamma,
                        ..Racp::geometric()
                    }),
                    krylov: KrylovChoice::default(),
                };
                let budget = Budget {
                    iterations: 1000,
                    cost: f64::INFINITY,
                };
                let loads = [Load::Physical];
                let trial = trials(&problem, &candidate, &loads, budget, observer).remove(0);
                rows.push(Row {
                    shape,
                    ratio,
                    n: [problem.blocks.n_u(), problem.blocks.n_t()],
                    c,
                    gamma,
                    trial,
                });
            }
        }
    }
    Ok(rows)
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "e06b_flat_cells",
        "Iterations around geometric multigrid on cells that are wider along x and y (flat) or along x (long), under the load of the scene; \
         the fracture is normal to x.",
        &["cells", "ratio", "n_u", "n_t", "C", "γ", "n_it"],
    );
    for row in rows {
        let n_it = row.trial.iterations.map_or(Cell::Failed, Cell::from);
        let cells: [Cell; 7] = [
            row.shape.into(),
            (row.ratio as usize).into(),
            row.n[0].into(),
            row.n[1].into(),
            row.c.name().into(),
            row.gamma.into(),
            n_it,
        ];
        table.push(cells);
    }
    table
}

/// n_it against the ratio.
fn figure(rows: &[Row]) -> Figure {
    let caption = "Iterations around geometric multigrid against the ratio of the sides of cells.";
    let axes = (Axis::log("wide over high"), Axis::linear("n_it"));
    let mut figure = Figure::new("e06b_ratio", "", caption, axes.0, axes.1);
    for (k, (c, _)) in METHODS.into_iter().enumerate() {
        for (i, (shape, _)) in SHAPES.into_iter().enumerate() {
            let points = rows.iter().filter(|row| row.c == c && row.shape == shape);
            let points = points
                .filter_map(|row| Some([f64::from(row.ratio), row.trial.iterations? as f64]))
                .collect();
            let name = format!("{}, {shape} cells", c.name());
            figure = figure
                .with(Series::new(&name, Mark::LinePoints, points).tone(SHAPES.len() * k + i));
        }
    }
    figure
}

/// Table, figure and check.
pub(super) fn add(
    findings: &mut Findings,
    level: Level,
    observer: &mut dyn Observer,
) -> anyhow::Result<()> {
    let rows = rows(level, observer)?;
    let ours = rows
        .iter()
        .filter(|row| row.c == AugmentationChoice::FittedH);
    let most = ours.fold(0.0, |most, row| row.trial.count().max(most));
    findings.checks.push(Check::at_most(
        "flat and long cells, geometric multigrid: n_it with fitted_h, whatever the ratio of sides",
        MOST,
        most,
    ));
    findings.tables.push(table(&rows));
    findings.figures.push(figure(&rows));
    Ok(())
}
