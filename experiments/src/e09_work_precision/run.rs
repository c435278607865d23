//! One body by one method to several tolerances.

use super::narrow::Narrow;
use super::sample::Sample;
use crate::clock::{Clock, fastest};
use anyhow::Context;
use fracas::contact::JumpStabilization;
use fracas::matrix_free::{MatrixFreeSaddle, MatrixFreeSystem, RacpParts};
use fracas::multigrid::Geometric;
use fracas::scene::Body;
use fracas_operators::vector::norm2;
use fracas_operators::{LinearOperator, Preconditioner, Real};
use fracas_solvers::Silent;
use fracas_solvers::amg::Amg;
use fracas_solvers::krylov::{Breakdown, Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::multigrid::Precision;
use fracas_solvers::saddle::{Cost, InnerChoice, Racp, SaddleMethod, SaddleOperator, U};

/// Iterations after which a method counts as failed.
const LIMIT: usize = 1000;

/// S̃_u⁻¹, and which digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Method {
    /// Sparse Cholesky in f64.
    Exact,
    /// Algebraic multigrid of the assembled matrix.
    Algebraic(Precision),
    /// Geometric multigrid, nothing assembled.
    Geometric(Precision),
    /// The same with operator, vectors and scalar products in f32, too.
    AllSingle,
}

impl Method {
    pub(super) const ALL: [Self; 6] = [
        Self::Exact,
        Self::Algebraic(Precision::F64),
        Self::Algebraic(Precision::F32),
        Self::Geometric(Precision::F64),
        Self::Geometric(Precision::F32),
        Self::AllSingle,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact S_u",
            Self::Algebraic(Precision::F64) => "AMG, f64",
            Self::Algebraic(Precision::F32) => "AMG, f32 inside",
            Self::Geometric(Precision::F64) => "geometric, f64",
            Self::Geometric(Precision::F32) => "geometric, f32 inside",
            Self::AllSingle => "geometric, all f32",
        }
    }
}

/// What a body is compared with.
pub(super) struct Reference {
    /// Displacements and tractions of the same mesh [m, Pa].
    pub(super) u: Vec<f64>,
    pub(super) t: Vec<f64>,
    /// Relative residual of them.
    pub(super) residual: f64,
}

/// A tolerance by a method.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) tolerance: f64,
    /// The true residual met it.
    pub(super) met: bool,
    /// Made until then, or until the residual no longer fell.
    pub(super) iterations: usize,
    /// C_s of them.
    pub(super) cost: f64,
    /// Against the same mesh: displacements, tractions; relative, in ℓ².
    pub(super) algebraic: [f64; 2],
    /// Against the finer mesh: displacements at its nodes, relative, in ℓ².
    pub(super) total: f64,
    /// Processor time [s]; the solve is the fastest of its repetitions.
    pub(super) setup: f64,
    pub(super) solve: f64,
}

/// `‖a − b‖ / ‖b‖`.
fn relative(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    norm2(&difference) / norm2(b)
}

/// What an iteration came to; x is what it reached.
struct Reached {
    krylov: KrylovChoice,
    met: bool,
    iterations: usize,
    residual: f64,
}

fn iterate<R: Real>(
    operator: &dyn LinearOperator<R>,
    preconditioner: &dyn Preconditioner<R>,
    rhs: &[R],
    tolerance: f64,
    x: &mut [R],
) -> Reached {
    let system = System {
        operator,
        preconditioner,
        rhs,
    };
    let criteria = Criteria {
        relative_tolerance: tolerance,
        max_iterations: LIMIT,
    };
    let krylov = KrylovChoice::default().flexible_for(preconditioner);
    let method = krylov.own_method().expect("GMRES or FGMRES");
    match method.solve(&system, &criteria, x, &mut Silent) {
        Ok(report) => Reached {
            krylov,
            met: report.outcome == Outcome::Converged,
            iterations: report.iterations,
            residual: report.relative_residual,
        },
        Err(breakdown) => Reached {
            krylov,
            met: false,
            iterations: breakdown.iteration(),
            residual: match breakdown {
                Breakdown::Stagnation {
                    relative_residual, ..
                } => relative_residual,
                _ => f64::INFINITY,
            },
        },
    }
}

/// Settings of RACP around geometric multigrid in this precision.
fn geometric(precision: Precision) -> Racp {
    Racp {
        inner: InnerChoice::Geometric(Geometric {
            precision,
            ..Geometric::default()
        }),
        ..Racp::default()
    }
}

/// The solution of `body` to this tolerance, or to rounding where that is larger.
pub(super) fn reference(body: &Body, tolerance: f64) -> anyhow::Result<Reference> {
    let system = body.stick_system(Some(JumpStabilization::PUBLISHED));
    let saddle = MatrixFreeSystem::new(&system, None)?.saddle;
    let b = saddle.rhs(&system, &body.forces()?);
    let inverse =
        RacpParts::new(&geometric(Precision::F64), &saddle, &system, &mut Silent)?.inverse;
    let mut x = vec![0.0; b.len()];
    let residual = iterate(&saddle, &inverse, &b, tolerance, &mut x).residual;
    let t = x.split_off(saddle.layout().length(U));
    Ok(Reference {
        u: x,
        t: t.into_iter().map(|t| saddle.unit() * t).collect(),
        residual,
    })
}

/// All tolerances by one method; the set-up is made once and counted in every row.
pub(super) fn rows(
    body: &Body,
    method: Method,
    tolerances: &[f64],
    repetitions: usize,
    reference: &Reference,
    sample: &Sample,
) -> anyhow::Result<Vec<Row>> {
    let clock = Clock::start();
    let system = body.stick_system(Some(JumpStabilization::PUBLISHED));
    let judged =
        |tolerance, x: &[f64], unit: f64, reached: &Reached, cost: &Cost, times: [f64; 2]| {
            let (u, t) = x.split_at(reference.u.len());
            let t: Vec<f64> = t.iter().map(|t| unit * t).collect();
            Row {
                tolerance,
                met: reached.met,
                iterations: reached.iterations,
                cost: cost.c_s(reached.iterations, &reached.krylov),
                algebraic: [relative(u, &reference.u), relative(&t, &reference.t)],
                total: sample.error(body, u),
                setup: times[0],
                solve: times[1],
            }
        };
    let mut rows = Vec::new();
    let mut in_double = |operator: &dyn LinearOperator<f64>,
                         inverse: &dyn Preconditioner<f64>,
                         b: &[f64],
                         unit: f64,
                         setup: f64| {
        let cost = Cost::new(operator, inverse);
        for tolerance in tolerances {
            let ((x, reached), solve) = fastest(repetitions, || {
                let mut x = vec![0.0; b.len()];
                let reached = iterate(operator, inverse, b, *tolerance, &mut x);
                (x, reached)
            });
            let times = [setup, solve];
            rows.push(judged(*tolerance, &x, unit, &reached, &cost, times));
        }
    };
    let inner = match method {
        Method::Exact => Some(InnerChoice::default()),
        Method::Algebraic(precision) => Some(InnerChoice::Amg(Amg {
            precision,
            ..Amg::default()
        })),
        Method::Geometric(_) | Method::AllSingle => None,
    };
    if let Some(inner) = inner {
        let blocks = body.saddle_blocks(Some(JumpStabilization::PUBLISHED))?;
        let unit = blocks.traction_unit();
        let blocks = blocks.into_traction_unit(unit);
        let racp = SaddleMethod::Racp(Racp {
            inner,
            ..Racp::default()
        });
        let inverse = racp.ready(&blocks)?.inverse;
        let operator = SaddleOperator::new(&blocks);
        let setup = clock.seconds();
        in_double(&operator, &*inverse, &blocks.rhs(), unit, setup);
        return Ok(rows);
    }
    let saddle = MatrixFreeSystem::new(&system, None)?.saddle;
    let unit = saddle.unit();
    let b = saddle.rhs(&system, &body.forces()?);
    let precision = match method {
        Method::Geometric(precision) => precision,
        _ => Precision::F32,
    };
    let ready = RacpParts::new(&geometric(precision), &saddle, &system, &mut Silent)?;
    if let Some(lost) = ready.lost {
        anyhow::bail!("{}: {lost}", method.name());
    }
    let inverse = ready.inverse;
    if method != Method::AllSingle {
        in_double(&saddle, &inverse, &b, unit, clock.seconds());
        return Ok(rows);
    }
    let single = MatrixFreeSaddle::<f32>::in_traction_unit(&system, unit)?;
    // a power of two brings b near 1 and changes no digit
    let size = norm2(&b).log2().round().exp2();
    let b: Vec<f32> = b.iter().map(|b| (b / size) as f32).collect();
    let cost = Cost::new(&saddle, &inverse);
    let narrow = Narrow::new(inverse);
    let setup = clock.seconds();
    for tolerance in tolerances {
        let ((x, reached), solve) = fastest(repetitions, || {
            let mut x = vec![0.0_f32; b.len()];
            let reached = iterate(&single, &narrow, &b, *tolerance, &mut x);
            (x, reached)
        });
        let times = [setup, solve];
        let x: Vec<f64> = x.iter().map(|x| size * f64::from(*x)).collect();
        rows.push(judged(*tolerance, &x, unit, &reached, &cost, times));
    }
    Ok(rows)
}

/// The body of `scene` with this many cells along every axis.
pub(super) fn body(scene: &str, cells: usize) -> anyhow::Result<Body> {
    let entry = fracas::scene::named(scene).with_context(|| format!("no scene {scene}"))?;
    let cells = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells={cells}"));
    Ok(entry.scene()?.with_overrides(&cells)?.build()?)
}
