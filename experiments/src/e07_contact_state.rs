//! e07: iterations against the contact state.

mod patch;

use crate::measure::{Measured, cost_cell, count_cell};
use crate::plot::{Axis, Figure, Mark, Series};
use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::scene::{Scene, named};
use fracas_operators::sparse::Csr;
use fracas_solvers::krylov::{KrylovChoice, Sqmr};
use fracas_solvers::saddle::{
    AugmentationChoice, Elimination, InnerChoice, RELAXATION, Racp, RacpInverse, SaddleBlocks,
};
use fracas_solvers::{Observer, Prepare, SetupError, Step};
use patch::{Laboratory, Linearized, Shares};
use std::ops::ControlFlow;

/// What do slip and opening do to the preconditioner?
#[derive(Debug)]
pub struct ContactStates;

/// The scene: a well posed body with four fractures inside.
const SCENE: &str = "analogue_b";

/// Fractures dip 60 deg under 10 MPa from above and 2 MPa from the side; they are weaker than their stress ratio, so that
/// every face slips along the load once it is let go.
const OVERRIDES: [&str; 5] = [
    "mesh.map.incline.plane=x",
    "mesh.map.incline.dip=60 deg",
    "mesh.map.incline.fade=true",
    "boundary.2.pressure=2 MPa",
    "fracture.fault.friction_angle=10 deg",
];

/// Shares of (slip, open) faces: slip alone, opening alone, and slip around opening.
const SWEEP: [(f64, f64); 13] = [
    (0.0, 0.0),
    (0.1, 0.0),
    (0.25, 0.0),
    (0.5, 0.0),
    (0.75, 0.0),
    (1.0, 0.0),
    (0.0, 0.1),
    (0.0, 0.25),
    (0.0, 0.5),
    (0.15, 0.1),
    (0.25, 0.25),
    (0.5, 0.25),
    (0.5, 0.5),
];

/// Largest n_it over that of all faces in stick.
const GROWTH: f64 = 2.0;

/// One state, solved in several ways.
struct Solved {
    shares: Shares,
    linearized: Linearized,
    /// Rows with a law of their own.
    local: usize,
    symmetric: bool,
    exact: Option<Measured>,
    amg: Option<Measured>,
    sqmr: Option<Measured>,
    /// RACP as if every row were a constraint: C = C_local + |diag H| and B1 throughout.
    blind: Option<Measured>,
}

/// A method that does not apply is a value.
fn applicable<T>(result: Result<T, SetupError>) -> anyhow::Result<Option<T>> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(SetupError::NotApplicable { .. } | SetupError::NotPositiveDefinite { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// n_it of RACP with this inner solver, one number per Krylov method, from the start that meets the eliminated rows.
fn racp<const N: usize>(
    blocks: &SaddleBlocks,
    inner: InnerChoice,
    methods: [KrylovChoice; N],
) -> anyhow::Result<[Option<Measured>; N]> {
    let settings = Racp {
        inner,
        ..Racp::default()
    };
    let rhs = blocks.rhs();
    let start = match Elimination::new(blocks) {
        Some(elimination) => elimination.start(&rhs),
        None => vec![0.0; rhs.len()],
    };
    let ready = applicable(settings.prepare(blocks))?;
    Ok(methods.map(|krylov| {
        let m = ready.as_deref()?;
        Some(Measured::new(blocks, m, krylov, &rhs, start.clone()))
    }))
}

/// The same with no row eliminated.
fn blind(blocks: &SaddleBlocks) -> anyhow::Result<Option<Measured>> {
    let direct = fracas_solvers::direct::DirectChoice::Auto.solver()?;
    let ready = AugmentationChoice::FittedH
        .compute(blocks, direct.as_ref())
        .and_then(|c| {
            let s_u = InnerChoice::default().prepare(blocks, &c.matrix)?.inverse;
            let m = RacpInverse::new(blocks.b1.clone(), c.matrix, s_u);
            Ok(match &blocks.h {
                Some(h) => m.relaxed(Box::new(Csr::new(h.clone())), RELAXATION),
                None => m,
            })
        });
    let rhs = blocks.rhs();
    let zero = vec![0.0; rhs.len()];
    Ok(applicable(ready)?.map(|m| Measured::new(blocks, &m, KrylovChoice::default(), &rhs, zero)))
}

fn solved(laboratory: &Laboratory<'_>, shares: Shares) -> anyhow::Result<Solved> {
    let linearized = laboratory.linearize(shares)?;
    let blocks = &linearized.blocks;
    let elimination = Elimination::new(blocks);
    let symmetric = elimination
        .as_ref()
        .map_or(blocks.b2.is_none(), Elimination::is_symmetric);
    let local = elimination.map_or(0, |e| e.rows().len());
    let (gmres, short) = (KrylovChoice::default(), KrylovChoice::Sqmr(Sqmr {}));
    let (exact, sqmr) = if symmetric {
        racp(blocks, InnerChoice::default(), [gmres, short])?.into()
    } else {
        let [exact] = racp(blocks, InnerChoice::default(), [gmres])?;
        (exact, None)
    };
    let [amg] = racp(blocks, InnerChoice::Amg(Default::default()), [gmres])?;
    Ok(Solved {
        shares,
        local,
        symmetric,
        exact,
        amg,
        sqmr,
        blind: blind(blocks)?,
        linearized,
    })
}

fn table(rows: &[Solved]) -> Table {
    let mut table = Table::new(
        "e07_contact_state",
        "Iterations to a true residual of 1e-8 against the contact state. C = fitted_h, H relaxed; rows with a law of their own \
         (slip tangentially, open) are eliminated, except in the last column.",
        &[
            "slip [%]",
            "open [%]",
            "n_u",
            "n_t",
            "own rows",
            "symmetric",
            "Newton steps",
            "closed in tension",
            "open but overlapping",
            "n_it GMRES exact",
            "C_s exact",
            "n_it SQMR exact",
            "n_it GMRES AMG",
            "C_s AMG",
            "n_it blind exact",
        ],
    );
    for s in rows {
        let [stick, slip, open] = s.linearized.faces;
        let percent = |n: usize| 100.0 * n as f64 / (stick + slip + open) as f64;
        table.push([
            percent(slip).into(),
            percent(open).into(),
            s.linearized.blocks.n_u().into(),
            s.linearized.blocks.n_t().into(),
            s.local.into(),
            if s.symmetric { "yes" } else { "no" }.into(),
            s.linearized.newton.into(),
            s.linearized.tension.into(),
            s.linearized.overlap.into(),
            count_cell(s.exact.as_ref()),
            cost_cell(s.exact.as_ref()),
            if s.symmetric {
                count_cell(s.sqmr.as_ref())
            } else {
                Cell::Missing
            },
            count_cell(s.amg.as_ref()),
            cost_cell(s.amg.as_ref()),
            count_cell(s.blind.as_ref()),
        ]);
    }
    table
}

/// n_it against the share of one kind of face (0 slip, 1 open), in percent.
fn figure(id: &str, caption: &str, label: &str, rows: &[&Solved], kind: usize) -> Figure {
    let share = |s: &Solved| {
        let faces = s.linearized.faces;
        100.0 * faces[1 + kind] as f64 / faces.iter().sum::<usize>() as f64
    };
    let points = |measured: &dyn Fn(&Solved) -> Option<Measured>| -> Vec<[f64; 2]> {
        rows.iter()
            .filter_map(|s| Some([share(s), measured(s)?.iterations? as f64]))
            .collect()
    };
    let series = [
        ("eliminated, exact S_u", points(&|s| s.exact)),
        ("eliminated, AMG", points(&|s| s.amg)),
        ("augmented, exact S_u", points(&|s| s.blind)),
        ("eliminated, exact S_u, SQMR", points(&|s| s.sqmr)),
    ];
    let highest = series
        .iter()
        .flat_map(|(_, points)| points)
        .fold(0.0, |m: f64, p| m.max(p[1]));
    let n_it = Axis::linear("n_it").range(0.0, 1.15 * highest);
    let mut figure = Figure::new(id, "", caption, Axis::linear(label), n_it);
    for (k, (name, points)) in series.into_iter().enumerate() {
        if points.len() > 1 {
            // SQMR often agrees with GMRES: crosses stay visible on circles
            let (mark, tone) = match k {
                3 => (Mark::Points, 6),
                k => (Mark::LinePoints, k),
            };
            figure = figure.with(Series::new(name, mark, points).tone(tone));
        }
    }
    figure
}

fn checks(rows: &[Solved]) -> Vec<Check> {
    let count = |m: &Option<Measured>| m.as_ref().map_or(f64::INFINITY, Measured::count);
    let worst = |rows: &mut dyn Iterator<Item = f64>| rows.fold(0.0, f64::max);
    let stick = &rows[0];
    let mut checks = vec![
        Check::holds(
            "Newton converges in every fixed state",
            "all",
            format!(
                "{} of {}",
                rows.iter().filter(|s| s.linearized.converged).count(),
                rows.len()
            ),
            rows.iter().all(|s| s.linearized.converged),
        ),
        Check::at_most(
            "exact S_u: n_it in any state over n_it in stick",
            GROWTH,
            worst(&mut rows.iter().map(|s| count(&s.exact))) / count(&stick.exact),
        ),
        Check::at_most(
            "AMG: n_it in any state over n_it in stick",
            GROWTH,
            worst(&mut rows.iter().map(|s| count(&s.amg))) / count(&stick.amg),
        ),
        Check::holds(
            "the system without its own rows is symmetric exactly where no face slips",
            "as stated",
            format!("{} symmetric", rows.iter().filter(|s| s.symmetric).count()),
            rows.iter()
                .all(|s| s.symmetric == (s.linearized.faces[1] == 0)),
        ),
        Check::at_most(
            "no face slips: n_it of SQMR over that of GMRES",
            1.5,
            worst(
                &mut rows
                    .iter()
                    .filter(|s| s.symmetric)
                    .map(|s| count(&s.sqmr) / count(&s.exact)),
            ),
        ),
    ];
    let against = rows.iter().filter(|s| s.shares.slip + s.shares.open > 0.0);
    let gain = against
        .map(|s| count(&s.blind) / count(&s.exact))
        .fold(f64::INFINITY, f64::min);
    checks.push(Check::at_least(
        "own rows augmented instead of eliminated: smallest growth of n_it",
        1.0,
        gain,
    ));
    checks
}

impl Experiment for ContactStates {
    fn id(&self) -> &'static str {
        "e07"
    }

    fn title(&self) -> &'static str {
        "Iterations against the contact state"
    }

    fn question(&self) -> &'static str {
        "Fractures stick, slip and open during a simulation: does one preconditioner serve every state?"
    }

    fn setup(&self) -> &'static str {
        "`analogue_b` with fractures of 60 deg dip, 10 MPa from above, 2 MPa from the side, φ = 10 deg: every face slips \
         along the load once it is let go. A patch around a hypocentre slips or opens (fluid at 1.5 times the compression \
         of the sticking fracture); Newton's method with fixed states gives displacements and tractions, and the last \
         Jacobian is solved for them. RACP, H relaxed, true residual 1e-8; GMRES(100), flexible where S̃_u⁻¹ computes in f32 (AMG)."
    }

    fn expect(&self) -> &'static str {
        "Rows that determine their own traction leave the saddle point exactly, so n_it stays within a factor of two of all \
         stick (derived). Without slip the rest is symmetric and SQMR does in three-term recurrences what GMRES does; \
         friction makes it unsymmetric through tan φ alone. Augmenting those rows as if they were constraints stiffens \
         S_u by springs that the body does not have, and costs iterations (derived)."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings
            .set("scene", SCENE)
            .set("overrides", OVERRIDES.to_vec())
            .set("level", level.word());
        let entry = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
        let scene: Scene = match level {
            Level::Smoke => entry.small_scene()?,
            Level::Paper => entry.scene()?,
        };
        let body = scene.with_overrides(&OVERRIDES)?.build()?;
        let laboratory = Laboratory::new(&body)?;
        let mut rows = Vec::new();
        for (k, (slip, open)) in SWEEP.into_iter().enumerate() {
            let step = Step::Progress {
                stage: "contact states",
                done: k,
                total: SWEEP.len(),
            };
            if observer.observe(&step) == ControlFlow::Break(()) {
                anyhow::bail!("stopped on request");
            }
            rows.push(solved(&laboratory, Shares { slip, open })?);
        }
        let chosen = |keep: &dyn Fn(&Shares) -> bool| -> Vec<&Solved> {
            rows.iter().filter(|s| keep(&s.shares)).collect()
        };
        findings.figures.push(figure(
            "e07_slip",
            "Iterations against the share of slipping faces, the others in stick; rows of slip eliminated, or augmented as if \
             they were constraints.",
            "slipping faces [%]",
            &chosen(&|s| s.open == 0.0),
            0,
        ));
        findings.figures.push(figure(
            "e07_open",
            "Iterations against the share of open faces, the others in stick; their rows eliminated, or augmented as if they \
             were constraints.",
            "open faces [%]",
            &chosen(&|s| s.slip == 0.0),
            1,
        ));
        findings.checks = checks(&rows);
        findings.tables.push(table(&rows));
        Ok(findings)
    }
}
