//! Fractures that meet: a tee, a crossing, a network, in flat cells and in rock that hardly changes its volume.

use super::constant::{Constant, constant};
use super::{ROCK, SIDE};
use crate::report::{Check, Findings, Level, Table};
use fracas::contact::{JumpStabilization, Junctions, Lengths};
use fracas::elasticity::Elastic;
use fracas::mesh::{BoxGrid, BuiltMesh, PlaneFracture};

/// Fractures in a body of N × N × N cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Network {
    /// A plane across the body, and one that comes from below and ends on it.
    Tee,
    /// A plane across the body, and one that goes through it.
    Crossing,
    /// A plane across the body, and planes along x and y one and two cells apart that go through it.
    Network,
}

impl Network {
    const ALL: [Self; 3] = [Self::Tee, Self::Crossing, Self::Network];

    fn word(self) -> &'static str {
        match self {
            Self::Tee => "tee",
            Self::Crossing => "crossing",
            Self::Network => "network",
        }
    }

    /// Cells of side 1/N, `thin.1` times less along the axis `thin.0`; upright planes end a cell below and above within the body.
    pub(super) fn mesh(self, n: usize, thin: (usize, f64)) -> anyhow::Result<BuiltMesh> {
        let mut h = [SIDE / n as f64; 3];
        h[thin.0] /= thin.1;
        let at = |axis: usize, k: usize| k as f64 * h[axis];
        let mut grid = BoxGrid::uniform([0.0; 3], h.map(|h| n as f64 * h), [n; 3]);
        let middle = n / 2;
        let top = if self == Self::Tee { middle } else { n - 1 };
        let upright: Vec<(usize, usize)> = match self {
            Self::Tee | Self::Crossing => vec![(0, middle)],
            // every third grid line is left out
            Self::Network => [0, 1]
                .into_iter()
                .flat_map(|axis| (1..n).map(move |k| (axis, k)))
                .filter(|(_, k)| k % 3 != 0)
                .collect(),
        };
        let across = PlaneFracture::through("across", 2, at(2, middle));
        grid.fractures.push(across);
        for (axis, k) in upright {
            let name = format!("{}{k}", ["x", "y"][axis]);
            let mut plane = PlaneFracture::through(&name, axis, at(axis, k));
            plane.spans[2] = Some([at(2, 1), at(2, top)]);
            grid.fractures.push(plane);
        }
        Ok(grid.build()?)
    }
}

/// Which side of the cells is the thin one, and what it is to the fractures.
const THIN: [(usize, &str); 3] = [(0, "x"), (1, "y"), (2, "z")];

/// H on a network: weights and junctions.
const FORMS: [(Lengths, Junctions); 3] = [
    (Lengths::Deep, Junctions::Apart),
    (Lengths::Deep, Junctions::Joined),
    (Lengths::Box, Junctions::Joined),
];

/// Table and checks.
pub(super) fn add(level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let _ = level;
    let mut table = Table::new(
        "e01_networks",
        "x",
        &[
            "network",
            "N",
            "n_t",
            "thin",
            "ratio",
            "ν",
            "β_h apart",
            "β_h joined",
            "proved β_h joined",
            "β_h joined, boxes",
        ],
    );
    let list = |k: &str, d: &str| -> Vec<f64> {
        let t = std::env::var(k).unwrap_or_else(|_| d.into());
        t.split(',').filter_map(|v| v.parse().ok()).collect()
    };
    let ns: Vec<usize> = list("E_N", "4").into_iter().map(|v| v as usize).collect();
    let (ratios, nus, axes, kinds) = (
        list("E_A", "1,50"),
        list("E_NU", "0.25,0.499"),
        list("E_X", "0,1,2"),
        list("E_K", "0,1,2"),
    );
    let (sizes, ratios) = (&ns, &ratios);
    for network in kinds.iter().map(|k| Network::ALL[*k as usize]) {
        for n in sizes {
            for (axis, name) in THIN {
                for ratio in ratios {
                    if (*ratio == 1.0 && axis > 0) || !axes.contains(&(axis as f64)) {
                        continue;
                    }
                    let built = network.mesh(*n, (axis, *ratio))?;
                    for poisson in nus.clone() {
                        let rock = Elastic { poisson, ..ROCK };
                        let t = std::time::Instant::now();
                        let found: Vec<String> = FORMS
                            .iter()
                            .map(|(lengths, junctions)| {
                                let form = JumpStabilization {
                                    lengths: *lengths,
                                    junctions: *junctions,
                                    ..JumpStabilization::default()
                                };
                                match constant(&built, rock, form) {
                                    Ok(Constant { n_t, beta, .. }) => format!("{n_t} {beta:.4}"),
                                    Err(e) => format!("{e}"),
                                }
                            })
                            .collect();
                        println!(
                            "{} {n} {name} {ratio} {poisson} {found:?} {:.2}",
                            network.word(),
                            t.elapsed().as_secs_f64()
                        );
                    }
                }
            }
        }
    }
    let _ = (&mut table, Check::equal("", 0, 0));
    findings.tables.push(table);
    Ok(())
}
