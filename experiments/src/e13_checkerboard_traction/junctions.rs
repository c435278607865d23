//! Tractions where fractures cross and stick, H with neighbours across junctions and without.

use super::field::{self, Solved};
use crate::report::{Check, Findings, Level, Table};
use fracas::contact::{JumpStabilization, Junctions};
use fracas::mesh::PlaneFracture;

/// What the block is cut into.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Network {
    /// Planes z = 0 and x = ½.
    Cross,
    /// Columns one cell wide, half as tall as the block.
    Columns,
}

impl Network {
    fn word(self) -> &'static str {
        match self {
            Self::Cross => "cross",
            Self::Columns => "columns",
        }
    }

    fn fractures(self, n: usize) -> Vec<PlaneFracture> {
        match self {
            Self::Cross => vec![
                PlaneFracture::through("z", 2, 0.0),
                PlaneFracture::through("x", 0, 0.5),
            ],
            Self::Columns => [(0, "x"), (1, "y")]
                .into_iter()
                .flat_map(|(axis, name)| (1..n).map(move |k| (axis, name, k)))
                .map(|(axis, name, k)| {
                    let at = k as f64 / n as f64;
                    let mut plane = PlaneFracture::through(&format!("{name}{k}"), axis, at);
                    plane.spans[2] = Some([-0.25, 0.25]);
                    plane
                })
                .collect(),
        }
    }
}

/// H on this network, `None` to leave it out.
const CHOICES: [(&str, Option<Junctions>); 3] = [
    ("without H", None),
    ("apart", Some(Junctions::Apart)),
    ("joined", Some(Junctions::Joined)),
];

/// Errors of (t_N, t_T), root mean squares over the amplitude of t_N.
fn errors(solved: &Solved) -> [f64; 2] {
    let (mut normal, mut shear, mut faces) = (0.0, 0.0, 0.0);
    for [n, t1, t2] in solved.errors() {
        normal += n * n;
        shear += t1 * t1 + t2 * t2;
        faces += 1.0;
    }
    [normal, shear].map(|sum: f64| (sum / faces).sqrt() / field::AMPLITUDE)
}

/// Table and checks.
pub(super) fn add(level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let sizes: &[usize] = match level {
        Level::Smoke => &[4, 8],
        Level::Paper => &[4, 8, 12, 16],
    };
    let mut table = Table::new(
        "e13_junctions",
        "Fractures that cross and stick under the same stress: errors of tractions over 5 MPa and iterations with exact S_u, with H \
         apart at junctions, as published, and joined across them. Columns without H have tractions that nothing determines.",
        &["network", "H", "N", "n_t", "t_N", "t_T", "n_it"],
    );
    for network in [Network::Cross, Network::Columns] {
        let mut iterations = [Vec::new(), Vec::new()];
        for n in sizes {
            let mut own = Vec::new();
            for (name, junctions) in CHOICES {
                let form = junctions.map(|junctions| JumpStabilization {
                    junctions,
                    ..JumpStabilization::PUBLISHED
                });
                if form.is_none() && network == Network::Columns {
                    continue;
                }
                let solved = field::solve(*n, network.fractures(*n), form)?;
                let [normal, shear] = errors(&solved);
                table.push([
                    network.word().into(),
                    name.into(),
                    (*n).into(),
                    solved.tractions.len().into(),
                    normal.into(),
                    shear.into(),
                    solved.iterations.into(),
                ]);
                if form.is_some() {
                    own.push((normal.hypot(shear), solved.iterations));
                }
            }
            if let [apart, joined] = own[..] {
                findings.checks.push(Check::at_most(
                    format!("{}, N = {n}: error of t joined over apart", network.word()),
                    1.25,
                    joined.0 / apart.0,
                ));
                iterations[0].push(apart.1);
                iterations[1].push(joined.1);
            }
        }
        if let ([.., apart], [first, .., joined]) = (&iterations[0][..], &iterations[1][..])
            && network == Network::Columns
        {
            findings.checks.push(Check::at_most(
                "columns: iterations joined, finest over coarsest",
                1.2,
                *joined as f64 / *first as f64,
            ));
            findings.checks.push(Check::at_most(
                "columns: iterations joined over apart, finest",
                0.8,
                *joined as f64 / *apart as f64,
            ));
        }
    }
    findings.tables.push(table);
    Ok(())
}
