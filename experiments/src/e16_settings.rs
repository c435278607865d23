//! e16: every setting that steers, halved and doubled.

mod runs;
mod solves;
mod sweep;

use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::Observer;
use sweep::{Count, Row};

/// Which settings steer?
#[derive(Debug)]
pub struct Sensitivity;

/// Cost with the default over the least with half, default and double, at most, over all cases of a setting.
const WORSE: f64 = 1.15;

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(
        "e16_settings",
        "All cases of a setting together: n_it counts iterations of systems and rounds of states in runs; the cost is C_s of systems and Krylov iterations of \
         runs. Changes: cases in which half or double counts otherwise. Failed: cases that end without a solution. Half and double \
         end where the range of the setting does.",
        &[
            "of",
            "setting",
            "half",
            "default",
            "double",
            "cases",
            "n_it changes in",
            "n_it half",
            "n_it default",
            "n_it double",
            "C_s, cost half",
            "C_s, cost default",
            "C_s, cost double",
            "failed half",
            "failed default",
            "failed double",
        ],
    );
    for row in rows {
        let totals = row.totals();
        let [n_it, cost, failed] = [0, 1, 2].map(|k: usize| totals.map(|total| total[k]));
        let mut cells: Vec<Cell> = vec![row.of.into(), row.setting.into()];
        cells.extend(row.values.map(Cell::from));
        cells.extend([Cell::from(row.cases.len()), row.changed().into()]);
        cells.extend(n_it.map(|n| Cell::from(n as usize)));
        cells.extend(cost.map(Cell::from));
        cells.extend(failed.map(|n| Cell::from(n as usize)));
        table.rows.push(cells);
    }
    table
}

/// Case by case; on paper those that change, lest rows depend on the processor elsewhere.
fn cases(level: Level, rows: &[Row]) -> Table {
    let mut table = Table::new(
        "e16_cases",
        "Case by case, at paper level those that change. X: no solution.",
        &[
            "of",
            "setting",
            "case",
            "n_it half",
            "n_it default",
            "n_it double",
        ],
    );
    for row in rows {
        for (case, counts) in &row.cases {
            if level == Level::Paper && !sweep::differ(counts) {
                continue;
            }
            let mut cells: Vec<Cell> = vec![row.of.into(), row.setting.into(), case.clone().into()];
            cells.extend(counts.map(|count| match count {
                Some(Count { n_it, .. }) => n_it.into(),
                None => Cell::Failed,
            }));
            table.rows.push(cells);
        }
    }
    table
}

fn figure(rows: &[Row]) -> Figure {
    let names = rows
        .iter()
        .rev()
        .map(|row| format!("{}: {}", row.of, row.setting));
    let axis = Axis::categories("", names.collect());
    let mut figure = Figure::new(
        "e16_ratios",
        "",
        "Cost (C_s of systems, Krylov iterations of runs) with half and with double of a setting over that with its default, all cases of a setting together.",
        Axis::linear("cost over that with the default"),
        axis,
    );
    for (name, k) in [("half", 0), ("double", 2)] {
        let points = rows.iter().rev().enumerate();
        let points = points.map(|(height, row)| [row.ratio(k), height as f64]);
        figure = figure.with(Series::new(name, Mark::Points, points.collect()));
    }
    figure
}

fn checks(rows: &[Row]) -> Vec<Check> {
    let of = |row: &Row| format!("{}: {}", row.of, row.setting);
    let failures = rows.iter().map(|row| row.totals()[1][2]);
    let worst = rows.iter().map(|row| (row.excess(), of(row)));
    let (excess, name) = worst.fold(
        (1.0, "none".to_owned()),
        |a, b| if b.0 > a.0 { b } else { a },
    );
    vec![
        Check::at_most(
            "cases without a solution by the defaults",
            0.0,
            failures.fold(0.0, f64::max),
        ),
        Check::at_most(
            format!("cost by the defaults over the least by half or double, the largest ({name})"),
            WORSE,
            excess,
        ),
    ]
}

impl Experiment for Sensitivity {
    fn id(&self) -> &'static str {
        "e16"
    }

    fn title(&self) -> &'static str {
        "Sensitivity of settings"
    }

    fn question(&self) -> &'static str {
        "Which numbers steer multigrid and the search for contact states, and does half or double of one serve better?"
    }

    fn setup(&self) -> &'static str {
        "Every setting with a range (degrees, sizes, shares and thresholds of geometric and algebraic multigrid, rounds of contact states), one after \
         the other, at half, at its default and at double of it. Systems: scenes of the gallery with all faces in stick, RACP, relative residual 1e-8, \
         hierarchies down to 60 unknowns (geometric) and 100 (algebraic) so that small bodies have levels. Runs: scenes of the gallery \
         with friction and a time, tolerance 1e-8. Smoke level: a few small scenes; paper level: all."
    }

    fn expect(&self) -> &'static str {
        "Defaults cost at most 15 % more than the best of the three. A setting that changes nothing in any case is needed by other scenes, or by \
         none: a candidate to go. (No publication asks this.)"
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("level", level.word());
        let mut rows = solves::rows(level, observer)?;
        rows.extend(runs::rows(level, observer)?);
        findings.tables.push(table(&rows));
        findings.tables.push(cases(level, &rows));
        findings.figures.push(figure(&rows));
        findings.checks = checks(&rows);
        Ok(findings)
    }
}
