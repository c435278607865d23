//! No fracture at all: a layer of weak elastic cells in its place.

use super::fault::{Profile, across, fractured, layered};
use super::run::Run;
use crate::report::{Check, Findings, Level, Table};
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_operators::Preconditioner;
use fracas_solvers::Observer;
use fracas_solvers::saddle::InnerChoice;

/// Thickness of the layer [m].
const THICKNESSES: [f64; 3] = [0.4, 0.1, 0.025];

/// Stiffness of the layer over that of the rock.
const RATIOS: [f64; 6] = [1e0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5];

fn table() -> Table {
    Table::new(
        "e15_weak_layer",
        "The fault as one layer of isotropic linear-elastic cells, E times a ratio, ν that of the rock, no yield cap, no opening, \
         no contact. Jumps across it in its middle over the slip that multipliers give for the fracture.",
        &[
            "thickness [m]",
            "E ratio",
            "n_u",
            "slip over that of the fracture",
            "overlap over that slip",
        ],
    )
}

/// Jump (x, z) across the layer in the middle.
fn jump(n: usize, thickness: f64, ratio: f64) -> anyhow::Result<([f64; 2], usize)> {
    let body = layered(n, thickness, ratio)?.build()?;
    let blocks = body.saddle_blocks(None)?;
    let inverse = InnerChoice::default()
        .of_matrix(&blocks.a, blocks.coordinates.as_deref())?
        .inverse;
    let mut u = vec![0.0; blocks.n_u()];
    let mut work = vec![0.0; inverse.work_len()];
    inverse.solve(&blocks.rhs_u, &mut u, &mut work);
    let displacement = body.constraints.expand(&u);
    Ok((across(&body, &displacement, thickness), blocks.n_u()))
}

/// Layers of several thicknesses and stiffnesses beside the fracture.
pub(super) fn weak(
    level: Level,
    findings: &mut Findings,
    observer: &mut dyn Observer,
) -> anyhow::Result<()> {
    let n = match level {
        Level::Smoke => 16,
        Level::Paper => 32,
    };
    let scene = fractured(n)?;
    let run = Run::of(&scene, observer)?.map_err(anyhow::Error::msg)?;
    // the two rows of faces next to z = 0
    let slip = Profile::of(&run)?.middle(8.0 / n as f64)[1];
    let mut table = table();
    let mut figure = Figure::new(
        "e15_weak_layer_slip",
        "",
        "Jumps across a layer of weak elastic cells over the slip of the fracture: every stiffness gives another slip (lines with marks), and the \
         sides overlap where they should not (dashed); the true slip is that of the fracture.",
        Axis::log("E of the layer over E of the rock"),
        Axis::log("jump over true slip"),
    );
    let mut spread = Vec::new();
    for (tone, thickness) in THICKNESSES.into_iter().enumerate() {
        let (mut slips, mut overlaps) = (Vec::new(), Vec::new());
        for ratio in RATIOS {
            let ([x, z], n_u) = jump(n, thickness, ratio)?;
            table.push([
                thickness.into(),
                ratio.into(),
                n_u.into(),
                (z / slip).into(),
                (-x / slip).into(),
            ]);
            slips.push([ratio, z / slip]);
            overlaps.push([ratio, -x / slip]);
        }
        spread.push((
            slips[0][1],
            slips[RATIOS.len() - 1][1],
            overlaps[RATIOS.len() - 1][1],
        ));
        let name = format!("slip, {thickness} m");
        figure = figure.with(Series::new(&name, Mark::LinePoints, slips).tone(tone));
        let name = format!("overlap, {thickness} m");
        figure = figure.with(Series::new(&name, Mark::Dashed, overlaps).tone(tone));
    }
    findings.tables.push(table);
    findings.figures.push(figure);
    let thin = spread[THICKNESSES.len() - 1];
    findings.checks.push(Check::holds(
        "thinnest layer: its slip lies below that of the fracture at the stiffness of the rock and above it at the least one",
        "below, above",
        format!("{:.3}, {:.3}", thin.0, thin.1),
        thin.0 < 1.0 && thin.1 > 1.0,
    ));
    findings.checks.push(Check::at_least(
        "thinnest and weakest layer: overlap over the slip of the fracture",
        0.1,
        thin.2,
    ));
    Ok(())
}
