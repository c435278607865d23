//! e01: the checkerboard of Q1–P0 tractions, and what the jump stabilization does to it.

mod columns;
mod constant;
mod networks;

use crate::report::{Check, Experiment, Findings, Level, Table};
use constant::{Row, measure};
use fracas::contact::JumpStabilization;
use fracas::elasticity::Elastic;
use fracas::mesh::{BoxGrid, BuiltMesh, PlaneFracture};
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Any rock: only ν enters the dimensionless results.
const ROCK: Elastic = Elastic {
    young: 25e9,
    poisson: 0.25,
};

/// Side of the square fracture [m].
const SIDE: f64 = 1.0;

/// Does the inf-sup constant of Q1–P0 vanish, and does H bring it back?
#[derive(Debug)]
pub struct Checkerboard;

/// How the border of the fracture is treated by the body around it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Border {
    /// The fracture ends inside the body: nodes of the border are not split.
    Tip,
    /// The fracture cuts the body: every node is split.
    Split,
}

impl Border {
    const BOTH: [Self; 2] = [Self::Tip, Self::Split];

    fn word(self) -> &'static str {
        match self {
            Self::Tip => "embedded",
            Self::Split => "through-going",
        }
    }

    /// A square fracture of N × N faces in the middle of a body that is fixed below and above.
    fn mesh(self, n: usize) -> anyhow::Result<BuiltMesh> {
        let h = SIDE / n as f64;
        let rim = if self == Self::Tip {
            n.div_ceil(4).max(1)
        } else {
            0
        };
        let (width, layers) = (n + 2 * rim, 2 * n.div_ceil(4).max(2));
        let size = [width as f64 * h, width as f64 * h, layers as f64 * h];
        let mut grid = BoxGrid::uniform([0.0; 3], size, [width, width, layers]);
        let mut fracture = PlaneFracture::through("square", 2, 0.5 * size[2]);
        if self == Self::Tip {
            let inside = Some([rim as f64 * h, (rim + n) as f64 * h]);
            fracture.spans = [inside, inside, None];
        }
        grid.fractures.push(fracture);
        Ok(grid.build()?)
    }
}

/// The weakest mode on the fracture: faces that pull and faces that push.
fn mode_figure(built: &BuiltMesh, row: &Row, n: usize) -> Figure {
    let faces = |positive: bool| {
        let chosen = built.fractures.faces.iter().zip(&row.weakest);
        chosen
            .filter(|(_, t)| (**t > 0.0) == positive)
            .map(|(f, _)| [f.center[0], f.center[1]])
            .collect()
    };
    let mut figure = Figure::new(
        "e01_mode",
        "",
        &format!(
            "Sign of the normal traction in the weakest mode of the pair without H on a through-going {n} × {n} \
             fracture, a marker per face: neighbours alternate."
        ),
        Axis::linear("x [m]").range(0.0, SIDE),
        Axis::linear("y [m]").range(0.0, SIDE),
    )
    .with(Series::new("t_N > 0", Mark::Points, faces(true)))
    .with(Series::new("t_N < 0", Mark::Points, faces(false)));
    figure.equal_aspect = true;
    figure
}

impl Experiment for Checkerboard {
    fn id(&self) -> &'static str {
        "e01"
    }

    fn title(&self) -> &'static str {
        "The checkerboard and its stabilization"
    }

    fn question(&self) -> &'static str {
        "How many tractions does the pair Q1–P0 not see, does its inf-sup constant vanish with h, and does H repair both?"
    }

    fn setup(&self) -> &'static str {
        "A square fracture of N × N faces, side 1 m, closed, in a cube-meshed body (E = 25 GPa, ν = 0.25) fixed below and \
         above; once with its border inside the body (tip nodes not split), once cutting it. \
         β_h² = λ_min(C_local⁻¹(S + H)), S = BᵀA⁻¹B by a sparse direct factorization: the inf-sup constant in the \
         mesh-dependent norm of the tractions that the local augmentation defines. The same for N × N columns one cell wide, fractures between all of them, \
         with neighbours across junctions and without, and for a tee, a crossing and a network of N × N × N cells, cubes and cells of 1:10 and 1:50, \
         ν to 0.499."
    }

    fn expect(&self) -> &'static str {
        "dim ker B = 2N−1 per component where the tips are not split; zero but β_h → 0 where every node is split; with the \
         jump stabilization β_h is bounded below, on columns only with neighbours across junctions (SNA'25 lecture: the kernel of the Schur complement is not empty; count derived). Where \
         fractures meet, it stays above a bound in flat cells and as ν → ½, which is lower where both come together."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let sizes: &[usize] = match level {
            Level::Smoke => &[4, 8],
            Level::Paper => &[4, 5, 8, 12, 16],
        };
        let mut findings = Findings::default();
        findings
            .set("young_Pa", ROCK.young)
            .set("poisson", ROCK.poisson)
            .set("N", sizes.to_vec());
        let mut table = Table::new(
            "e01_inf_sup",
            "Kernel of B and inf-sup constants. Expected kernel: 3(2N−1) embedded, 0 through-going.",
            &[
                "fracture",
                "N",
                "n_u",
                "n_t",
                "dim ker B",
                "expected",
                "β_h without H",
                "β_h with H",
            ],
        );
        let mut figure = Figure::new(
            "e01_beta",
            "",
            "Inf-sup constant against mesh size. The embedded fracture without H has β_h = 0 and cannot be shown.",
            Axis::log("h [m]"),
            Axis::log("β_h"),
        );
        let total = 2 * sizes.len();
        for (b, border) in Border::BOTH.into_iter().enumerate() {
            let mut lines = [Vec::new(), Vec::new()];
            for (k, n) in sizes.iter().enumerate() {
                let step = Step::Progress {
                    stage: "meshes",
                    done: b * sizes.len() + k,
                    total,
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                let built = border.mesh(*n)?;
                let row = measure(&built, ROCK, JumpStabilization::PUBLISHED)?;
                let expected = if border == Border::Tip {
                    3 * (2 * n - 1)
                } else {
                    0
                };
                findings.checks.push(
                    Check::equal(
                        format!("dim ker B, {} N = {n}", border.word()),
                        expected,
                        row.kernel,
                    )
                    .closed_form(),
                );
                for (line, beta) in lines.iter_mut().zip(row.beta) {
                    if beta > 0.0 {
                        line.push([SIDE / *n as f64, beta]);
                    }
                }
                if border == Border::Split && *n == 8 {
                    findings.figures.push(mode_figure(&built, &row, *n));
                }
                let [without, with] = row.beta;
                table.push([
                    border.word().into(),
                    (*n).into(),
                    row.n_u.into(),
                    row.n_t.into(),
                    row.kernel.into(),
                    expected.into(),
                    without.into(),
                    with.into(),
                ]);
            }
            let [bare, stabilized] = lines;
            let ratio = |line: &[[f64; 2]]| match (line.first(), line.last()) {
                (Some(first), Some(last)) => last[1] / first[1],
                _ => f64::NAN,
            };
            findings.checks.push(Check::at_least(
                format!("{}: β_h with H, finest over coarsest mesh", border.word()),
                0.8,
                ratio(&stabilized),
            ));
            if border == Border::Split {
                findings.checks.push(Check::at_most(
                    "through-going: β_h without H, finest over coarsest mesh",
                    0.7,
                    ratio(&bare),
                ));
                if let Some(coarsest) = bare.first() {
                    figure = figure.slope(2.0, [coarsest[0], 0.3 * coarsest[1]]);
                }
                figure = figure.with(Series::new("through-going, H = 0", Mark::LinePoints, bare));
            }
            let name = format!("{}, with H", border.word());
            figure = figure.with(Series::new(&name, Mark::LinePoints, stabilized));
        }
        findings.figures.insert(0, figure);
        findings.tables.push(table);
        columns::add(level, &mut findings)?;
        networks::add(level, &mut findings)?;
        Ok(findings)
    }
}
