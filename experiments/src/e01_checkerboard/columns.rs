//! Columns one cell wide: H with neighbours across junctions and without.

use super::constant::constant;
use super::{ROCK, SIDE};
use crate::report::{Check, Findings, Level, Table};
use fracas::contact::{JumpStabilization, Junctions};
use fracas::mesh::{BoxGrid, BuiltMesh, PlaneFracture};

/// N × N columns one cell wide and two tall, with fractures between all of them, in a body of four layers.
pub(super) fn mesh(n: usize) -> anyhow::Result<BuiltMesh> {
    let h = SIDE / n as f64;
    let mut grid = BoxGrid::uniform([0.0; 3], [SIDE, SIDE, 4.0 * h], [n, n, 4]);
    for (axis, name) in [(0, "x"), (1, "y")] {
        for k in 1..n {
            let mut plane = PlaneFracture::through(&format!("{name}{k}"), axis, k as f64 * h);
            plane.spans[2] = Some([h, 3.0 * h]);
            grid.fractures.push(plane);
        }
    }
    Ok(grid.build()?)
}

/// Inf-sup constants of columns, their fractures apart or joined where they meet.
pub(super) fn add(level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let sizes: &[usize] = match level {
        Level::Smoke => &[4, 8],
        Level::Paper => &[4, 8, 12, 16, 24],
    };
    let mut table = Table::new(
        "e01_junctions",
        "Inf-sup constants with H on N × N columns one cell wide, fractures between all of them: H as published, without neighbours across \
         junctions, and with them. The last column bounds the one before from below, but for one case in 10⁹.",
        &[
            "N",
            "n_t",
            "β_h apart",
            "N β_h apart",
            "β_h joined",
            "β_h joined, from below",
        ],
    );
    let (mut apart, mut joined) = (Vec::new(), Vec::new());
    let mut least = f64::INFINITY;
    for n in sizes {
        let built = mesh(*n)?;
        let [alone, with] = [Junctions::Apart, Junctions::Joined].map(|junctions| {
            let form = JumpStabilization {
                junctions,
                ..JumpStabilization::PUBLISHED
            };
            constant(&built, ROCK, form)
        });
        let (alone, with) = (alone?, with?);
        table.push([
            (*n).into(),
            with.n_t.into(),
            alone.beta.into(),
            (*n as f64 * alone.beta).into(),
            with.beta.into(),
            with.at_least.into(),
        ]);
        apart.push(alone.beta);
        joined.push(with.beta);
        least = least.min(with.at_least);
    }
    let ratio = |values: &[f64]| match values {
        [first, .., last] => last / first,
        _ => f64::NAN,
    };
    findings.checks.push(Check::at_most(
        "columns: β_h with fractures apart, most columns over fewest",
        0.7,
        ratio(&apart),
    ));
    findings.checks.push(Check::at_least(
        "columns: β_h with fractures joined, most columns over fewest",
        0.9,
        ratio(&joined),
    ));
    findings.checks.push(Check::at_least(
        "columns: least bound of β_h with fractures joined",
        0.9,
        least,
    ));
    findings.notes.push(
        "On columns with fractures joined another mode is the least from N = 16 on: β_h is 1 + 19/N² there, up to N = 40 (1.012), so that 1 is what it falls to."
            .into(),
    );
    findings.tables.push(table);
    Ok(())
}
