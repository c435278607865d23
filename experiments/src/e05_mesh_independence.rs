//! e05: iterations against the size of the mesh.

use crate::measure::{LIMIT, TOLERANCE};
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use crate::trial::{Budget, Candidate, HEADINGS, Load, Problem, Trial, trials};
use fracas::scene::named;
use fracas_solvers::fsai::Fsai;
use fracas_solvers::krylov::{KrylovChoice, Minres};
use fracas_solvers::saddle::{
    AugmentationChoice, BlockDiagonal, InnerChoice, Mcp, Racp, SaddleMethod, Simple,
};
use fracas_solvers::{Observer, Step};
use std::ops::ControlFlow;

/// Does n_it depend on the mesh?
#[derive(Debug)]
pub struct MeshIndependence;

/// The scene: a well posed body of 25 × 24 × 24 m with four square fractures inside.
const SCENE: &str = "analogue_b";

/// Cells in x (a multiple of 5), y and z (of 4), so that the fractures lie on grid planes; nearly cubes.
const SMOKE: [[usize; 3]; 3] = [[5, 4, 4], [10, 8, 8], [10, 12, 12]];

/// The same in print: from 13 thousand to a million unknowns.
const PAPER: [[usize; 3]; 6] = [
    [15, 16, 16],
    [20, 20, 20],
    [30, 32, 32],
    [40, 40, 40],
    [50, 52, 52],
    [70, 68, 68],
];

/// C_s at which an iteration is given up: twice the most expensive published solution that converged.
const COST: f64 = 3000.0;

/// Unknowns from which growth is judged.
const LARGE: usize = 100_000;

/// Largest growth of n_it from [`LARGE`] unknowns to a million.
const GROWTH: f64 = 1.1;

/// Largest n_it at a million unknowns.
const MOST: f64 = 25.0;

/// A method and the unknowns up to which it is tried, in memory and time that two cores have.
struct Entry {
    candidate: Candidate,
    limit: usize,
}

const REFERENCE: &str = "RACP, AMG";
const GEOMETRIC: &str = "RACP, geometric";
const PUBLISHED: &str = "as published, local_h, AMG";

fn entries() -> Vec<Entry> {
    let gmres = KrylovChoice::default();
    let amg = InnerChoice::Amg(Default::default());
    let exact = InnerChoice::default();
    let relaxed = |inner| Racp {
        inner,
        ..Racp::default()
    };
    let published = |augmentation, inner| Racp {
        augmentation,
        ..Racp::published(inner)
    };
    let other = |name, method: SaddleMethod, krylov, limit| Entry {
        candidate: Candidate {
            name,
            method,
            krylov,
        },
        limit,
    };
    let racp = |name, racp: Racp, limit| other(name, SaddleMethod::Racp(racp), gmres, limit);
    let mcp = |inner| {
        SaddleMethod::Mcp(Mcp {
            inner,
            ..Mcp::default()
        })
    };
    let diagonal = SaddleMethod::BlockDiagonal(BlockDiagonal {
        inner: amg,
        ..BlockDiagonal::default()
    });
    let simple = SaddleMethod::Simple(Simple {
        inner: amg,
        ..Simple::default()
    });
    vec![
        racp(REFERENCE, relaxed(amg), usize::MAX),
        Entry {
            candidate: Candidate {
                name: GEOMETRIC,
                method: SaddleMethod::Racp(Racp::geometric()),
                krylov: gmres,
            },
            limit: usize::MAX,
        },
        racp("RACP, exact S_u", relaxed(exact), 30_000),
        racp(
            PUBLISHED,
            published(AugmentationChoice::LocalH, amg),
            usize::MAX,
        ),
        racp(
            "as published, local, AMG",
            published(AugmentationChoice::Local, amg),
            usize::MAX,
        ),
        racp(
            "as published, global, AMG",
            published(AugmentationChoice::Global, amg),
            usize::MAX,
        ),
        racp(
            "as published, face_block, AMG",
            published(AugmentationChoice::FaceBlock, amg),
            usize::MAX,
        ),
        racp(
            "as published, local_h, exact S_u",
            published(AugmentationChoice::LocalH, exact),
            30_000,
        ),
        racp(
            "as published, exact_h, exact S_u",
            published(AugmentationChoice::ExactH, exact),
            30_000,
        ),
        other("MCP, AMG", mcp(amg), gmres, 500_000),
        other(
            "MCP, FSAI",
            mcp(InnerChoice::Fsai(Fsai::default())),
            gmres,
            500_000,
        ),
        other(
            "block diagonal, AMG",
            diagonal,
            KrylovChoice::Minres(Minres {}),
            500_000,
        ),
        other("SIMPLE, AMG", simple, gmres, 500_000),
    ]
}

fn problem(cells: [usize; 3]) -> anyhow::Result<Problem> {
    let entry = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
    let [x, y, z] = cells;
    let overrides = [
        format!("mesh.x.cells={x}"),
        format!("mesh.y.cells={y}"),
        format!("mesh.z.cells={z}"),
    ];
    Problem::new(&entry.scene()?.with_overrides(&overrides)?)
}

fn table() -> Table {
    let mut headings = vec!["cells", "n", "n_u", "n_t", "method", "Krylov"];
    headings.extend(HEADINGS);
    Table::new(
        "e05_mesh_independence",
        "Iterations to a true relative residual of 1e-8 under the load of the scene, on ever finer meshes of one body; X: failed, –: not tried.",
        &headings,
    )
}

/// One measured row.
struct Measured {
    n: usize,
    name: &'static str,
    trial: Trial,
}

/// One quantity of every method against n.
fn figure(
    id: &str,
    caption: &str,
    y: Axis,
    rows: &[Measured],
    value: impl Fn(&Trial) -> Option<f64>,
) -> Figure {
    let mut figure = Figure::new(id, "", caption, Axis::log("unknowns n"), y);
    // the reference last: face_block, which agrees with it nearly everywhere, would cover it
    for (tone, entry) in entries().iter().enumerate().rev() {
        let name = entry.candidate.name;
        let points: Vec<[f64; 2]> = rows
            .iter()
            .filter(|r| r.name == name)
            .filter_map(|r| Some([r.n as f64, value(&r.trial)?]))
            .collect();
        if !points.is_empty() {
            figure = figure.with(Series::new(name, Mark::LinePoints, points).tone(tone));
        }
    }
    figure
}

fn checks(rows: &[Measured]) -> Vec<Check> {
    let of = |name: &str| -> Vec<&Measured> { rows.iter().filter(|r| r.name == name).collect() };
    let reference = of(REFERENCE);
    let finest = reference.last();
    let count = |row: Option<&&Measured>| row.map_or(f64::INFINITY, |r| r.trial.count());
    let mut checks = vec![Check::at_most(
        format!("{REFERENCE}: n_it on the finest mesh"),
        MOST,
        count(finest),
    )];
    if reference.iter().all(|r| r.n < LARGE) {
        // coarse meshes take fewer iterations: growth means nothing there
        return checks;
    }
    let unknowns = finest.map_or(0.0, |r| r.n as f64);
    checks.push(Check::at_least(
        "unknowns of the finest mesh",
        1e6,
        unknowns,
    ));
    for name in [PUBLISHED, GEOMETRIC] {
        let rows = of(name);
        let first = rows.iter().find(|r| r.n >= LARGE);
        checks.push(Check::at_most(
            format!("{name}: n_it on the finest mesh over that at 100 thousand unknowns"),
            GROWTH,
            count(rows.last()) / count(first),
        ));
    }
    checks.push(Check::at_most(
        format!("n_it of {REFERENCE} over that of {PUBLISHED}, finest mesh"),
        1.0,
        count(finest) / count(of(PUBLISHED).last()),
    ));
    checks
}

impl Experiment for MeshIndependence {
    fn id(&self) -> &'static str {
        "e05"
    }

    fn title(&self) -> &'static str {
        "Iterations against the size of the mesh"
    }

    fn question(&self) -> &'static str {
        "Does the number of iterations stay the same when the mesh is refined, up to a million unknowns?"
    }

    fn setup(&self) -> &'static str {
        "`analogue_b`, one body of 25 × 24 × 24 m with four fractures inside, nearly cubic cells from 1.6 m to 0.35 m; all faces \
         in stick, jump stabilization. GMRES(100), flexible where multigrid works in f32; MINRES for block diagonal. True \
         relative residual 1e-8, load of the scene; given up above C_s = 3000."
    }

    fn expect(&self) -> &'static str {
        "C scales with the mesh as BᵀA⁻¹B does on a closed fracture, so with a multigrid that does not see the mesh neither does \
         RACP: at most 10 % more iterations from 100 thousand to a million unknowns and at most 25 there. FSAI in place of \
         multigrid grows like 1/h; set-up and iteration are linear in n."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings
            .set("scene", SCENE)
            .set("level", level.word())
            .set("tolerance", TOLERANCE)
            .set("cost limit", COST);
        let meshes: &[[usize; 3]] = match level {
            Level::Smoke => &SMOKE,
            Level::Paper => &PAPER,
        };
        let budget = Budget {
            iterations: LIMIT,
            cost: COST,
        };
        let entries = entries();
        let mut table = table();
        let mut rows: Vec<Measured> = Vec::new();
        for (k, cells) in meshes.iter().enumerate() {
            let problem = problem(*cells)?;
            let blocks = &problem.blocks;
            let (n_u, n_t, n) = (blocks.n_u(), blocks.n_t(), blocks.size());
            for (e, Entry { candidate, limit }) in entries.iter().enumerate() {
                let step = Step::Progress {
                    stage: candidate.name,
                    done: k * entries.len() + e,
                    total: meshes.len() * entries.len(),
                };
                if observer.observe(&step) == ControlFlow::Break(()) {
                    anyhow::bail!("stopped on request");
                }
                let measured = if n > *limit {
                    vec![Trial::not_run(format!("not tried above {limit} unknowns"))]
                } else {
                    trials(&problem, candidate, &[Load::Physical], budget, observer)
                };
                for trial in measured {
                    let [x, y, z] = cells;
                    let mut row: Vec<Cell> = vec![
                        format!("{x} × {y} × {z}").into(),
                        n.into(),
                        n_u.into(),
                        n_t.into(),
                        candidate.name.into(),
                        trial.krylov_cell(candidate),
                    ];
                    row.extend(trial.cells(level));
                    if let Some(failure) = trial.failure.as_ref().filter(|_| trial.setup.is_some())
                    {
                        let name = candidate.name;
                        findings
                            .notes
                            .push(format!("{n} unknowns, {name}: {}.", failure.reason));
                    }
                    table.rows.push(row);
                    rows.push(Measured {
                        n,
                        name: candidate.name,
                        trial,
                    });
                }
            }
        }
        findings.figures.push(figure(
            "e05_iterations",
            "Iterations against the number of unknowns; methods that failed or were not tried have no point.",
            Axis::log("n_it"),
            &rows,
            |t| t.iterations.map(|n| n as f64),
        ));
        findings.figures.push(figure(
            "e05_cost",
            "C_s = n_it (1 + c_app) against the number of unknowns.",
            Axis::log("C_s"),
            &rows,
            |t| t.cost,
        ));
        findings.checks = checks(&rows);
        findings.tables.push(table);
        Ok(findings)
    }
}
