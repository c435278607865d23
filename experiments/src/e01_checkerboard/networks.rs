//! Fractures that meet: a tee, a crossing, a network, in flat cells and in rock that hardly changes its volume.

use super::constant::{all, constant};
use super::{ROCK, SIDE};
use crate::report::{Check, Findings, Level, Table};
use fracas::contact::{JumpStabilization, Junctions, Lengths};
use fracas::elasticity::Elastic;
use fracas::mesh::{BoxGrid, BuiltMesh, PlaneFracture};
use fracas_figures::{Axis, Figure, Mark, Series};

/// Fractures in a body of N × N × N cells.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Meeting {
    /// A plane across the body, and one that comes from below and ends on it.
    Tee,
    /// A plane across the body, and one that goes through it.
    Crossing,
    /// A plane across the body, and planes along x and y one and two cells apart that go through it.
    Network,
}

impl Meeting {
    const ALL: [Self; 3] = [Self::Tee, Self::Crossing, Self::Network];

    fn word(self) -> &'static str {
        match self {
            Self::Tee => "tee",
            Self::Crossing => "crossing",
            Self::Network => "network",
        }
    }

    /// Axes along which cells are thin; x and y are alike in the network.
    fn thin(self) -> &'static [usize] {
        match self {
            Self::Tee | Self::Crossing => &[0, 1, 2],
            Self::Network => &[0, 2],
        }
    }

    /// Cells of side 1/N that are `ratio` times less along the axis `thin`; upright planes end a cell above the bottom, and below the top.
    fn mesh(self, n: usize, thin: usize, ratio: f64) -> anyhow::Result<BuiltMesh> {
        let mut h = [SIDE / n as f64; 3];
        h[thin] /= ratio;
        let at = |axis: usize, k: usize| k as f64 * h[axis];
        let mut grid = BoxGrid::uniform([0.0; 3], h.map(|h| n as f64 * h), [n; 3]);
        let middle = n / 2;
        let top = match self {
            Self::Tee => middle,
            Self::Crossing | Self::Network => n - 1,
        };
        let upright: Vec<(usize, usize)> = match self {
            Self::Tee | Self::Crossing => vec![(0, middle)],
            // two grid lines of three
            Self::Network => [0, 1]
                .into_iter()
                .flat_map(|axis| (1..n).map(move |k| (axis, k)))
                .filter(|(_, k)| k % 3 != 0)
                .collect(),
        };
        let across = PlaneFracture::through("across", 2, at(2, middle));
        grid.fractures.push(across);
        for (axis, k) in upright {
            let name = format!("{}{k}", AXES[axis]);
            let mut plane = PlaneFracture::through(&name, axis, at(axis, k));
            plane.spans[2] = Some([at(2, 1), at(2, top)]);
            grid.fractures.push(plane);
        }
        Ok(grid.build()?)
    }
}

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Poisson's ratios.
const POISSON: [f64; 3] = [0.25, 0.45, 0.499];

/// H by default, with these lengths and junctions.
const fn form(lengths: Lengths, junctions: Junctions) -> JumpStabilization {
    JumpStabilization {
        lengths,
        junctions,
        ..JumpStabilization::PUBLISHED
    }
}

/// H as it is by default in one rock: apart at junctions and joined; joined with published weights.
const FORMS: [JumpStabilization; 3] = [
    form(Lengths::Deep, Junctions::Apart),
    form(Lengths::Deep, Junctions::Joined),
    form(Lengths::Box, Junctions::Joined),
];

/// One row.
struct Row {
    network: Meeting,
    n: usize,
    ratio: f64,
    poisson: f64,
    /// With each of the forms.
    beta: [f64; 3],
}

/// Tables, figure and checks.
pub(super) fn add(level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let rows = rows(level, findings)?;
    checks(&rows, findings);
    thin_tee(level, findings)
}

fn rows(level: Level, findings: &mut Findings) -> anyhow::Result<Vec<Row>> {
    let ratios: &[f64] = match level {
        Level::Smoke => &[1.0, 50.0],
        Level::Paper => &[1.0, 10.0, 50.0],
    };
    let mut table = Table::new(
        "e01_networks",
        "Inf-sup constants where fractures meet, in cubes and in cells that are thin along one axis. H is apart at junctions or joined across them, \
         with the weights of this program; the last column has the published weights, made of the boxes of the cells.",
        &[
            "network",
            "N",
            "n_t",
            "thin",
            "ratio",
            "ν",
            "β_h apart",
            "β_h joined",
            "β_h joined, boxes",
        ],
    );
    let mut rows = Vec::new();
    for network in Meeting::ALL {
        let sizes: &[usize] = match (level, network) {
            (Level::Smoke, _) => &[4],
            (Level::Paper, Meeting::Network) => &[4, 6],
            (Level::Paper, _) => &[4, 8],
        };
        for n in sizes {
            let shapes = ratios.iter().flat_map(|ratio| {
                let thin = match *ratio == 1.0 {
                    true => &network.thin()[..1],
                    false => network.thin(),
                };
                thin.iter().map(move |axis| (*axis, *ratio))
            });
            for (thin, ratio) in shapes {
                let built = network.mesh(*n, thin, ratio)?;
                for poisson in POISSON {
                    let beta = all(&built, Elastic { poisson, ..ROCK }, FORMS)?;
                    let [apart, joined, boxes] = beta;
                    table.push([
                        network.word().into(),
                        (*n).into(),
                        (3 * built.fractures.faces.len()).into(),
                        if ratio == 1.0 { "–" } else { AXES[thin] }.into(),
                        ratio.into(),
                        poisson.into(),
                        apart.into(),
                        joined.into(),
                        boxes.into(),
                    ]);
                    rows.push(Row {
                        network,
                        n: *n,
                        ratio,
                        poisson,
                        beta,
                    });
                }
            }
        }
    }
    findings.tables.push(table);
    Ok(rows)
}

/// Least of a column among some rows.
fn least<'a>(rows: impl Iterator<Item = &'a Row>, column: usize) -> f64 {
    rows.map(|row| row.beta[column])
        .fold(f64::INFINITY, f64::min)
}

fn checks(rows: &[Row], findings: &mut Findings) {
    let [apart, joined, boxes] = [0, 1, 2];
    let worst = rows.iter().map(|row| row.beta[joined] / row.beta[apart]);
    findings.checks.push(
        Check::at_least(
            "β_h joined over apart, least of all networks, cells and ν: H only grows",
            1.0 - 1e-6,
            worst.fold(f64::INFINITY, f64::min),
        )
        .closed_form(),
    );
    for network in Meeting::ALL {
        let own = || rows.iter().filter(|row| row.network == network);
        let usual = |row: &&Row| row.poisson < 0.499 || row.ratio == 1.0;
        for (claim, limit, found) in [
            (
                "least β_h joined, cubes, or ν up to 0.45 in cells to 1:50",
                0.8,
                least(own().filter(usual), joined),
            ),
            (
                "least β_h joined, ν = 0.499 in flat cells",
                0.6,
                least(own().filter(|row| !usual(row)), joined),
            ),
            (
                "least β_h joined, boxes, all cells and ν",
                0.8,
                least(own(), boxes),
            ),
        ] {
            let claim = format!("{}: {claim}", network.word());
            findings.checks.push(Check::at_least(claim, limit, found));
        }
    }
    let small = |row: &&Row| row.network == Meeting::Network && row.n == 4;
    findings.checks.push(Check::at_most(
        "network, N = 4: least β_h apart",
        0.5,
        least(rows.iter().filter(small), apart),
    ));
}

/// The tee in cells of 1:50 across the plane, ever more of them: what the weights of this program cost as ν → ½.
fn thin_tee(level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let sizes: &[usize] = match level {
        Level::Smoke => &[4, 8],
        Level::Paper => &[4, 8, 12, 16],
    };
    let mut table = Table::new(
        "e01_thin_tee",
        "The tee in cells that are 1:50 thin across the plane, fractures joined: inf-sup constants with the weights of this program and the \
         published ones.",
        &["ν", "N", "n_t", "β_h joined", "β_h joined, boxes"],
    );
    let mut figure = Figure::new(
        "e01_thin_cells",
        "",
        "Inf-sup constant of a tee in cells that are 1:50 thin across its plane, against the number of cells per side, fractures joined: with the weights \
         of this program, and with the published ones, made of the boxes of the cells. At ν = 0.25 both lines lie on each other from N = 8 on.",
        Axis::linear("N"),
        Axis::linear("β_h").range(0.0, 2.0),
    );
    for poisson in [0.25, 0.499] {
        let mut lines = [Vec::new(), Vec::new()];
        for n in sizes {
            let built = Meeting::Tee.mesh(*n, 2, 50.0)?;
            let rock = Elastic { poisson, ..ROCK };
            let [deep, boxes] = [FORMS[1], FORMS[2]].map(|form| constant(&built, rock, form));
            let (deep, boxes) = (deep?, boxes?);
            table.push([
                poisson.into(),
                (*n).into(),
                deep.n_t.into(),
                deep.beta.into(),
                boxes.beta.into(),
            ]);
            lines[0].push([*n as f64, deep.beta]);
            lines[1].push([*n as f64, boxes.beta]);
        }
        let [deep, boxes] =
            [&lines[0], &lines[1]].map(|line| line.last().map_or(f64::NAN, |p| p[1]));
        if poisson > 0.4 {
            findings.checks.push(Check::at_least(
                "tee in cells of 1:50, ν = 0.499: β_h joined, most cells",
                0.5,
                deep,
            ));
            findings.checks.push(Check::at_most(
                "tee in cells of 1:50, ν = 0.499: β_h joined with the weights of this program over that with boxes, most cells",
                0.6,
                deep / boxes,
            ));
        } else {
            findings.checks.push(Check::close(
                "tee in cells of 1:50, ν = 0.25: β_h joined with the weights of this program over that with boxes, most cells",
                1.0,
                deep / boxes,
                0.1,
            ));
        }
        for (line, weights) in lines.into_iter().zip(["", ", boxes"]) {
            let name = format!("ν = {poisson}{weights}");
            figure = figure.with(Series::new(&name, Mark::LinePoints, line));
        }
    }
    findings.notes.push(
        "Where cells are thin and ν → ½, β_h with the weights of this program falls: they take a cell for as deep as its face is wide, so that H in \
         shear is a face over λ, while C_local in shear is a thin cell over μ. With boxes it does not fall, and in thin cells of ν = 0.25 both are alike. \
         At ν = 0.499 the fall levels off as cells become more."
            .into(),
    );
    findings.tables.push(table);
    findings.figures.push(figure);
    Ok(())
}
