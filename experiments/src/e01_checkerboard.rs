//! e01: the checkerboard of Q1–P0 tractions, and what the jump stabilization does to it.

use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Check, Experiment, Findings, Level, Table};
use faer::Mat;
use fracas::contact::{JumpStabilization, Junctions, Rocks};
use fracas::elasticity::{Constraints, Elastic};
use fracas::mesh::{BoxGrid, BuiltMesh, PlaneFracture};
use fracas::system::StickSystem;
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::eigen::dense::{symmetric_eigen, symmetric_eigenvalues, to_dense};
use fracas_solvers::saddle::{AugmentationChoice, SaddleBlocks};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Any rock: only ν enters the dimensionless results.
const ROCK: Elastic = Elastic {
    young: 25e9,
    poisson: 0.25,
};

/// Side of the square fracture [m].
const SIDE: f64 = 1.0;

/// A singular value below this fraction of the largest belongs to the kernel (rounding gives 1e-8 in the square root).
const KERNEL: f64 = 1e-6;

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

/// N × N columns one cell wide and two tall, with fractures between all of them, in a body of four layers.
fn columns(n: usize) -> anyhow::Result<BuiltMesh> {
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
fn junctions(sizes: &[usize], findings: &mut Findings) -> anyhow::Result<()> {
    let mut table = Table::new(
        "e01_junctions",
        "Inf-sup constants with H on N × N columns one cell wide, fractures between all of them: H as published, without neighbours across \
         junctions, and with them.",
        &["N", "n_t", "β_h apart", "N β_h apart", "β_h joined"],
    );
    let (mut apart, mut joined) = (Vec::new(), Vec::new());
    for n in sizes {
        let built = columns(*n)?;
        let row = |junctions| {
            let form = JumpStabilization {
                junctions,
                ..JumpStabilization::PUBLISHED
            };
            measure(&built, form)
        };
        let Row { n_t, beta, .. } = row(Junctions::Apart)?;
        let (alone, with) = (beta[1], row(Junctions::Joined)?.beta[1]);
        table.push([
            (*n).into(),
            n_t.into(),
            alone.into(),
            (*n as f64 * alone).into(),
            with.into(),
        ]);
        apart.push(alone);
        joined.push(with);
    }
    let ratio = |values: &[f64]| match (values.first(), values.last()) {
        (Some(first), Some(last)) => last / first,
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
    let least = joined.iter().copied().fold(f64::INFINITY, f64::min);
    findings.checks.push(Check::at_least(
        "columns: least β_h with fractures joined",
        0.9,
        least,
    ));
    findings.tables.push(table);
    Ok(())
}

/// Blocks of the body, fixed below and above.
fn blocks(
    built: &BuiltMesh,
    stabilization: Option<JumpStabilization>,
) -> anyhow::Result<SaddleBlocks> {
    let mut prescribed = vec![None; 3 * built.mesh.nodes.len()];
    for node in built.sides[4]
        .iter()
        .chain(&built.sides[5])
        .flat_map(|face| face.nodes)
    {
        for i in 0..3 {
            prescribed[3 * node as usize + i] = Some(0.0);
        }
    }
    let constraints = Constraints::new(prescribed);
    let system = StickSystem {
        mesh: &built.mesh,
        fractures: &built.fractures,
        materials: &[ROCK],
        jump_rocks: Rocks {
            elastic: &[ROCK],
            first_alike: &[0],
        },
        constraints: &constraints,
        stabilization,
    };
    Ok(system.assemble(&vec![0.0; constraints.full_len()])?)
}

/// `S = BᵀA⁻¹B`, dense, by one factorization.
fn dual_schur(blocks: &SaddleBlocks) -> anyhow::Result<Mat<f64>> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let solver = DirectChoice::Auto.solver()?;
    let factor = solver.analyze(&blocks.a, Kind::Spd)?.factor(&blocks.a)?;
    let b = to_dense(&blocks.b1);
    let mut columns: Vec<f64> = (0..n_t)
        .flat_map(|j| (0..n_u).map(move |i| (i, j)))
        .map(|at| b[at])
        .collect();
    factor.solve_many(n_t, &mut columns);
    let mut s = Mat::<f64>::zeros(n_t, n_t);
    for j in 0..n_t {
        for (i, row) in blocks.b1.outer_iterator().enumerate() {
            let x = columns[j * n_u + i];
            row.iter().for_each(|(k, value)| s[(k, j)] += value * x);
        }
    }
    Ok(Mat::from_fn(n_t, n_t, |i, j| 0.5 * (s[(i, j)] + s[(j, i)])))
}

/// What one mesh says.
struct Row {
    n_u: usize,
    n_t: usize,
    kernel: usize,
    beta: [f64; 2],
    /// Normal traction of the weakest mode without H, per face.
    weakest: Vec<f64>,
}

/// Kernel of B, and `β_h = λ_min(C_local⁻¹ (S + θH))^{1/2}` for θ = 0 and 1.
fn measure(built: &BuiltMesh, stabilization: JumpStabilization) -> anyhow::Result<Row> {
    let blocks = blocks(built, Some(stabilization))?;
    let n_t = blocks.n_t();
    let b = to_dense(&blocks.b1);
    let gram = b.transpose() * &b;
    let squares = symmetric_eigenvalues(gram.as_ref())?;
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let kernel = squares
        .iter()
        .filter(|v| **v < KERNEL * KERNEL * largest)
        .count();

    let s = dual_schur(&blocks)?;
    let solver = DirectChoice::Auto.solver()?;
    let c = AugmentationChoice::Local
        .compute(&blocks, &*solver)?
        .matrix
        .diagonal_entries();
    let h = blocks
        .h
        .as_ref()
        .map_or_else(|| Mat::zeros(n_t, n_t), to_dense);
    // C^{-1/2} (S + θH) C^{-1/2} has the eigenvalues of the pencil
    let scaled = |theta: f64| {
        Mat::from_fn(n_t, n_t, |i, j| {
            (s[(i, j)] + theta * h[(i, j)]) / (c[i] * c[j]).sqrt()
        })
    };
    let (bare, modes) = symmetric_eigen(scaled(0.0).as_ref())?;
    let stabilized = symmetric_eigenvalues(scaled(1.0).as_ref())?;
    let root = |v: f64| v.max(0.0).sqrt();
    Ok(Row {
        n_u: blocks.n_u(),
        n_t,
        kernel,
        beta: [
            if kernel > 0 { 0.0 } else { root(bare[0]) },
            root(stabilized[0]),
        ],
        weakest: (0..n_t / 3).map(|f| modes[(3 * f, 0)]).collect(),
    })
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
         with neighbours across junctions and without."
    }

    fn expect(&self) -> &'static str {
        "dim ker B = 2N−1 per component where the tips are not split; zero but β_h → 0 where every node is split; with the \
         jump stabilization β_h is bounded below, on columns only with neighbours across junctions (SNA'25 lecture: the kernel of the Schur complement is not empty; count derived)."
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
                let row = measure(&built, JumpStabilization::PUBLISHED)?;
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
        junctions(sizes, &mut findings)?;
        Ok(findings)
    }
}
