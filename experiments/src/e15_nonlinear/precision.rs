//! Error against work: multipliers and springs on one fault.

use super::fault::{Profile, fractured};
use super::run::{Counts, Run, Way};
use crate::report::{Cell, Check, Findings, Level, Table};
use fracas::nonlinear::ContactProblem;
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::Observer;
use fracas_solvers::direct::{DirectChoice, DirectSolver};
use fracas_solvers::saddle::AugmentationMatrix;
use fracas_solvers::spectrum::condition::schur_ends;

const WAYS: [Way; 12] = [
    Way::Lagrange,
    Way::Penalty(1e0),
    Way::Penalty(1e1),
    Way::Penalty(1e2),
    Way::Penalty(1e3),
    Way::Penalty(1e4),
    Way::Penalty(1e5),
    Way::Penalty(1e6),
    Way::Augmented(1e0),
    Way::Augmented(1e1),
    Way::Augmented(1e2),
    Way::Augmented(1e3),
];

/// The judge of the same mesh: multipliers updated until the overlap is this small, relative.
const REFERENCE: [&str; 2] = [
    "solver.method={ augmented_lagrangian = { factor = 100.0 } }",
    "solver.state_tolerance=1e-10",
];

/// The inner solver of large systems; residuals of 1e-10 lie below rounding for the stiffest springs.
const AMG: [&str; 2] = ["solver.inner=amg", "solver.tolerance=1e-8"];

/// What a way gives.
struct Row {
    way: Way,
    /// Slip and traction against the same mesh and against the fine one.
    same: [f64; 2],
    fine: [f64; 2],
    overlap: f64,
    counts: Counts,
    seconds: f64,
    /// Krylov iterations and time [s] with AMG, where it does not fail.
    amg: Option<(usize, f64)>,
}

fn table() -> Table {
    Table::new(
        "e15_precision",
        "One load step of the fault. Errors in L² of the fault, relative: against exact contact on the same mesh without \
         stabilization (multipliers updated to 1e-10), and against multipliers on cells of half the size. κ(S): of A + BκBᵀ with \
         every face in stick; κω = κ times the local compliance. Direct solver inside; in the columns AMG algebraic multigrid and a residual of 1e-8 instead of 1e-10. Processor time of one thread, the least of three runs.",
        &[
            "method",
            "κω",
            "slip error, same mesh",
            "traction error, same mesh",
            "slip error, fine mesh",
            "traction error, fine mesh",
            "largest overlap [µm]",
            "κ(S)",
            "n_it rounds",
            "n_it Newton",
            "n_it Krylov",
            "n_it set-ups",
            "time [s]",
            "n_it Krylov, AMG",
            "time, AMG [s]",
        ],
    )
}

/// κ(A + B κ Bᵀ) with every face in stick.
fn condition(run: &Run, factor: f64, direct: &dyn DirectSolver) -> anyhow::Result<f64> {
    let problem = ContactProblem::new(&run.body)?;
    let faces = problem.faces().iter().zip(problem.compliance());
    let c = faces.flat_map(|(f, omega)| [f.area * omega / factor; 3]);
    let c = AugmentationMatrix::from_diagonal(c.collect())?;
    Ok(schur_ends(&problem.stick_blocks()?, &c, None, direct)?.condition())
}

fn error_figure(rows: &[Row]) -> Figure {
    let mut figure = Figure::new(
        "e15_error_factor",
        "",
        "Relative errors of slip against exact contact on the same mesh, and of tractions against multipliers on cells of half the \
         size, over the stiffness of the springs. Dashed: multipliers with jump stabilization, which know no κ.",
        Axis::log("κω"),
        Axis::log("relative error"),
    );
    let of = |pick: fn(&Way) -> bool, value: fn(&Row) -> f64| -> Vec<[f64; 2]> {
        let kept = rows.iter().filter(|r| pick(&r.way));
        kept.filter_map(|r| Some([r.way.factor()?, value(r)]))
            .collect()
    };
    let penalty = |w: &Way| matches!(w, Way::Penalty(_));
    let augmented = |w: &Way| matches!(w, Way::Augmented(_));
    for (tone, name, points) in [
        (0, "penalty, slip", of(penalty, |r| r.same[0])),
        (1, "penalty, tractions", of(penalty, |r| r.fine[1])),
        (2, "augmented, slip", of(augmented, |r| r.same[0])),
        (4, "augmented, tractions", of(augmented, |r| r.fine[1])),
    ] {
        figure = figure.with(Series::new(name, Mark::LinePoints, points).tone(tone));
    }
    if let Some(lagrange) = rows.iter().find(|r| r.way == Way::Lagrange) {
        for (tone, name, error) in [
            (0, "multipliers, slip", lagrange.same[0]),
            (1, "multipliers, tractions", lagrange.fine[1]),
        ] {
            let line = vec![[1.0, error], [1e6, error]];
            figure = figure.with(Series::new(name, Mark::Dashed, line).tone(tone));
        }
    }
    figure
}

fn work_figure(rows: &[Row]) -> Figure {
    let mut figure = Figure::new(
        "e15_work_precision",
        "",
        "Error of tractions against the fine mesh over Krylov iterations with algebraic multigrid inside (each a product with the operator and a solve \
         with the preconditioner). Springs from soft to stiff; those on which the iteration failed are left out.",
        Axis::log("Krylov iterations"),
        Axis::log("error of tractions"),
    );
    for (tone, name, pick) in [
        (
            0,
            "penalty",
            (|w| matches!(w, Way::Penalty(_))) as fn(&Way) -> bool,
        ),
        (2, "augmented", |w| matches!(w, Way::Augmented(_))),
        (6, "multipliers", |w| matches!(w, Way::Lagrange)),
    ] {
        let kept = rows.iter().filter(|r| pick(&r.way));
        let points: Vec<[f64; 2]> = kept
            .filter_map(|r| Some([r.amg?.0 as f64, r.fine[1]]))
            .collect();
        if !points.is_empty() {
            figure = figure.with(Series::new(name, Mark::LinePoints, points).tone(tone));
        }
    }
    figure
}

/// The fault by every way.
pub(super) fn precision(
    level: Level,
    findings: &mut Findings,
    observer: &mut dyn Observer,
) -> anyhow::Result<()> {
    let n = match level {
        Level::Smoke => 16,
        Level::Paper => 32,
    };
    let scene = fractured(n)?;
    let with = |settings: &[String], n: Option<usize>| {
        let scene = match n {
            Some(n) => fractured(n)?,
            None => scene.clone(),
        };
        // one step: what fails fails
        let scene = scene.with_overrides(&["solver.max_cuts=0", "solver.measure=residual"])?;
        Ok::<_, anyhow::Error>(scene.with_overrides(settings)?)
    };
    let reference = Run::of(&with(&REFERENCE.map(str::to_owned), None)?, observer)?
        .map_err(anyhow::Error::msg)?;
    let same = Profile::of(&reference)?;
    let fine = Run::of(
        &with(&["solver.inner=auto".to_owned()], Some(2 * n))?,
        observer,
    )?
    .map_err(anyhow::Error::msg)?;
    let fine = Profile::of(&fine)?.onto(&same);
    let direct = DirectChoice::Auto.solver()?;
    let measured = |seconds: f64| match level {
        Level::Paper => Cell::from(seconds),
        Level::Smoke => Cell::Missing,
    };
    let (mut table, mut rows, mut conditions) = (table(), Vec::new(), Vec::new());
    for way in WAYS {
        let kappa = match way {
            Way::Penalty(factor) => {
                let kappa = condition(&reference, factor, direct.as_ref())?;
                conditions.push([factor, kappa]);
                Some(kappa)
            }
            _ => None,
        };
        let around_amg = with(&[way.setting(), AMG[0].into(), AMG[1].into()], None)?;
        let amg = Run::timed(level, &around_amg, observer)?;
        let row = match Run::timed(level, &with(&[way.setting()], None)?, observer)? {
            Ok(run) => {
                let profile = Profile::of(&run)?;
                Row {
                    way,
                    same: profile.errors(&same),
                    fine: profile.errors(&fine),
                    overlap: run
                        .steps
                        .iter()
                        .fold(0.0, |m, s| s.record.max_pen.max(s.record.h_overlap).max(m)),
                    counts: Counts::total(&run.steps),
                    seconds: run.seconds,
                    amg: amg
                        .as_ref()
                        .ok()
                        .map(|r| (Counts::total(&r.steps).krylov, r.seconds)),
                }
            }
            Err(reason) => {
                findings.notes.push(format!("{}: {reason}.", way.setting()));
                let mut cells: Vec<Cell> = vec![way.name().into(), way.factor().into()];
                cells.extend(std::iter::repeat_n(Cell::Failed, 13));
                table.rows.push(cells);
                continue;
            }
        };
        if let Err(reason) = amg {
            findings
                .notes
                .push(format!("{} with AMG: {reason}.", way.setting()));
        }
        table.push([
            way.name().into(),
            way.factor().into(),
            row.same[0].into(),
            row.same[1].into(),
            row.fine[0].into(),
            row.fine[1].into(),
            (1e6 * row.overlap).into(),
            kappa.into(),
            row.counts.rounds.into(),
            row.counts.newton.into(),
            row.counts.krylov.into(),
            row.counts.setups.into(),
            measured(row.seconds),
            row.amg.map_or(Cell::Failed, |(krylov, _)| krylov.into()),
            row.amg
                .map_or(Cell::Failed, |(_, seconds)| measured(seconds)),
        ]);
        rows.push(row);
    }
    findings.set("cells", n);
    findings.tables.push(table);
    findings.figures.push(error_figure(&rows));
    findings.figures.push(work_figure(&rows));
    findings.figures.push(
        Figure::new(
            "e15_condition",
            "",
            "Condition number of A + BκBᵀ against the stiffness of the springs, every face in stick.",
            Axis::log("κω"),
            Axis::log("κ(A + BκBᵀ)"),
        )
        .with(Series::new("A + BκBᵀ", Mark::LinePoints, conditions.clone())),
    );
    findings.checks.extend(checks(&rows, &conditions));
    Ok(())
}

fn checks(rows: &[Row], conditions: &[[f64; 2]]) -> Vec<Check> {
    let of = |way: Way| rows.iter().find(|r| r.way == way);
    let same = |way: Way| of(way).map_or(f64::NAN, |r| r.same[0]);
    let rounds = |way: Way| of(way).map_or(f64::NAN, |r| r.counts.rounds as f64);
    let kappa = |factor: f64| {
        let found = conditions.iter().find(|c| c[0] == factor);
        found.map_or(f64::NAN, |c| c[1])
    };
    vec![
        Check::close(
            "penalty: slip error of κω = 10³ over that of 10⁴, same mesh (first order)",
            10.0,
            same(Way::Penalty(1e3)) / same(Way::Penalty(1e4)),
            0.5,
        ),
        Check::close(
            "κ(A + BκBᵀ) of κω = 10⁵ over that of 10⁴ (proportional)",
            10.0,
            kappa(1e5) / kappa(1e4),
            0.5,
        ),
        Check::at_most(
            "augmented Lagrangian, κω = 10: slip error on the same mesh",
            1e-5,
            same(Way::Augmented(1e1)),
        ),
        Check::at_least(
            "augmented Lagrangian: updates of κω = 10 over those of κω = 1000",
            1.5,
            rounds(Way::Augmented(1e1)) / rounds(Way::Augmented(1e3)),
        ),
        Check::at_most(
            "multipliers: slip error on the same mesh (the work of H)",
            1e-2,
            same(Way::Lagrange),
        ),
        Check::at_most(
            "multipliers: traction error against the fine mesh",
            1e-2,
            of(Way::Lagrange).map_or(f64::NAN, |r| r.fine[1]),
        ),
    ]
}
