//! Tractions where fractures cross and stick, H with neighbours across junctions and without.

use super::field::{self, Solved};
use crate::report::{Check, Findings, Level, Table};
use fracas::contact::{JumpStabilization, Junctions};
use fracas::mesh::PlaneFracture;
use fracas_solvers::amg::Amg;
use fracas_solvers::saddle::InnerChoice;

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

/// Columns per side from which growth of iterations is counted, where there are more.
const FROM: usize = 8;

/// Iterations of one solve of columns.
#[derive(Clone, Copy)]
struct Counted {
    n: usize,
    /// With exact S_u and with AMG.
    iterations: [usize; 2],
}

/// Table and checks.
pub(super) fn add(level: Level, findings: &mut Findings) -> anyhow::Result<()> {
    let mut table = Table::new(
        "e13_junctions",
        "Fractures that cross and stick under the same stress: errors of tractions over 5 MPa and iterations with exact S_u and with AMG, with H \
         apart at junctions, as published, and joined across them. Columns without H have tractions that nothing determines.",
        &["network", "H", "N", "n_t", "t_N", "t_T", "n_it", "n_it amg"],
    );
    for network in [Network::Cross, Network::Columns] {
        let sizes: &[usize] = match (level, network) {
            (Level::Smoke, _) => &[4, 8],
            (Level::Paper, Network::Cross) => &[4, 8, 12, 16],
            (Level::Paper, Network::Columns) => &[4, 8, 12, 16, 24],
        };
        let mut counted = [Vec::new(), Vec::new()];
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
                // without H the count says nothing of junctions
                let others: &[InnerChoice] = match form {
                    Some(_) => &[InnerChoice::Amg(Amg::default())],
                    None => &[],
                };
                let solved = field::solve(*n, network.fractures(*n), form, others)?;
                let [normal, shear] = errors(&solved);
                let amg = solved.around.first().copied();
                table.push([
                    network.word().into(),
                    name.into(),
                    (*n).into(),
                    solved.tractions.len().into(),
                    normal.into(),
                    shear.into(),
                    solved.iterations.into(),
                    amg.into(),
                ]);
                if let Some(amg) = amg {
                    let iterations = [solved.iterations, amg];
                    own.push((normal.hypot(shear), Counted { n: *n, iterations }));
                }
            }
            if let [apart, joined] = own[..] {
                findings.checks.push(Check::at_most(
                    format!("{}, N = {n}: error of t joined over apart", network.word()),
                    1.25,
                    joined.0 / apart.0,
                ));
                counted[0].push(apart.1);
                counted[1].push(joined.1);
            }
        }
        if network == Network::Columns {
            growth(&counted, findings);
        }
    }
    findings.tables.push(table);
    Ok(())
}

/// How iterations grow with the number of columns, and what joining saves.
fn growth([apart, joined]: &[Vec<Counted>; 2], findings: &mut Findings) {
    let (Some(first), Some(last)) = (joined.first(), joined.last()) else {
        return;
    };
    let later = |n: usize| joined.iter().find(|c| c.n == n && c.n < last.n);
    let from = later(FROM).unwrap_or(first);
    // with AMG counts rise from 8² to 12², and hardly beyond
    let grown = [("exact S_u", 0, Some(from), 1.2)]
        .into_iter()
        .chain([("AMG", 1, Some(from), 2.0), ("AMG", 1, later(12), 1.2)]);
    for (inner, k, from, most) in grown {
        let Some(from) = from else { continue };
        findings.checks.push(Check::at_most(
            format!(
                "columns, {inner}: iterations joined, {0} × {0} over {1} × {1}",
                last.n, from.n
            ),
            most,
            last.iterations[k] as f64 / from.iterations[k] as f64,
        ));
    }
    let Some(alone) = apart.last() else { return };
    for (k, inner) in ["exact S_u", "AMG"].into_iter().enumerate() {
        findings.checks.push(Check::at_most(
            format!(
                "columns, {inner}: iterations joined over apart, {0} × {0}",
                last.n
            ),
            0.8,
            last.iterations[k] as f64 / alone.iterations[k] as f64,
        ));
    }
}
