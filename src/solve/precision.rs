//! A preconditioner in f32 that failed: the same one in f64, where f32 is to blame.

use super::Rounding;
use super::solver::{Double, Equations, Solver};
use crate::inner::PLATEAU;
use fracas_operators::vector::norm2;
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::krylov::{Breakdown, Outcome, Report};
use fracas_solvers::saddle::{Ready, SaddleMethod};
use fracas_solvers::{Observer, SetupError};

/// Difference of `M⁻¹r` in f32 and in f64, relative to the latter, from which f32 is to blame. Unit: 1.
const LOST: f64 = 1e-2;

/// What is done after an iteration that failed around f32.
pub(super) struct Again {
    /// To go on with; `None` where f32 is not to blame or f64 is not to be had.
    pub(super) double: Option<Double>,
    /// What to say.
    pub(super) rounding: Rounding,
}

/// The inner solver of the method in f64, as results call it.
pub(super) fn name_in_double(method: &SaddleMethod) -> Option<String> {
    method.inner().map(|inner| format!("{inner} (f64)"))
}

/// The method with its inner solver in f64, where it has one in f32.
pub(super) fn in_double(method: &SaddleMethod) -> Option<SaddleMethod> {
    let double = method.inner()?.in_double()?;
    method.with_parts(None, Some(double)).ok()
}

/// The method set up; where A spreads over the digits of f32, or that fails in f32 and not in f64, it is the latter, with a
/// finding that says so.
///
/// # Errors
/// Of the method as it was asked for.
pub(super) fn ready(
    method: &SaddleMethod,
    equations: &Equations,
) -> Result<(Ready, Option<Rounding>), SetupError> {
    let stiffness = equations.blocks().map(|blocks| blocks.stiffness());
    if let (Some(double), Some(stiffness)) = (in_double(method), stiffness)
        && stiffness.exceeds_single()
        && let Ok(ready) = equations.ready(&double)
    {
        let spread = stiffness.spread();
        return Ok((ready, Some(Rounding::Spread { spread })));
    }
    let error = match equations.ready(method) {
        Ok(ready) => return Ok((ready, None)),
        Err(error) => error,
    };
    match in_double(method).map(|double| equations.ready(&double)) {
        Some(Ok(ready)) => {
            let failure = of_single(error).to_string();
            Ok((ready, Some(Rounding::SetUp { failure })))
        }
        _ => Err(error),
    }
}

/// A failure in f32 that f64 does not have: no support is missing.
fn of_single(mut error: SetupError) -> SetupError {
    if let SetupError::Singular { advice, .. } | SetupError::NotPositiveDefinite { advice, .. } =
        &mut error
    {
        "it is the rounding of f32, in f64 it is not".clone_into(advice);
    }
    error
}

/// Iterations made.
pub(super) fn iterations_of(result: &Result<Report, Breakdown>) -> usize {
    match result {
        Ok(report) => report.iterations,
        Err(breakdown) => breakdown.iteration(),
    }
}

/// Why f32 may have failed; an iteration that met its limit while its residual fell has not.
fn failure(result: &Result<Report, Breakdown>, flat: Option<f64>) -> Option<String> {
    match (result, flat) {
        (Ok(report), Some(residual)) if report.outcome == Outcome::Stopped => Some(format!(
            "at {residual:.1e} the residual did not halve in {PLATEAU} iterations"
        )),
        (Ok(_), _) => None,
        (Err(breakdown), _) => Some(breakdown.to_string()),
    }
}

/// After an iteration around f32 that broke down or stood still: the preconditioner in f64, where its `M⁻¹r` differs for the
/// residual r of x. f64 that cannot be set up, for want of memory too, is a finding like others.
pub(super) fn again(
    solver: &Solver,
    operator: &dyn LinearOperator<f64>,
    (result, flat): (&Result<Report, Breakdown>, Option<f64>),
    x: &mut [f64],
    observer: &mut dyn Observer,
) -> Option<Again> {
    if !is_single(solver) {
        return None;
    }
    let failure = failure(result, flat)?;
    if !x.iter().all(|x| x.is_finite()) {
        x.fill(0.0);
    }
    observer.say(&"f32 failed: setting up in f64");
    let double = match solver.in_double(observer) {
        Ok(double) => double,
        Err(error) => {
            let reason = error.in_full();
            return Some(Again {
                double: None,
                rounding: Rounding::NoDouble { failure, reason },
            });
        }
    };
    let mut r = solver.b.clone();
    operator.apply_add(-1.0, x, &mut r, &mut vec![0.0; operator.work_len()]);
    let difference = difference(&*solver.ready.inverse, &*double.ready.inverse, &r);
    Some(match difference < LOST {
        true => Again {
            double: None,
            rounding: Rounding::NotToBlame {
                failure,
                difference,
            },
        },
        false => Again {
            double: Some(double),
            rounding: Rounding::WentOn {
                failure,
                difference,
            },
        },
    })
}

/// True where the preconditioner is in f32 and there is the same one in f64.
pub(super) fn is_single(solver: &Solver) -> bool {
    solver.double.is_some() && solver.ready.inverse.properties().single
}

/// `‖M₁⁻¹r − M₂⁻¹r‖₂ / ‖M₂⁻¹r‖₂`; infinite where one is no number.
fn difference(
    single: &dyn Preconditioner<f64>,
    double: &dyn Preconditioner<f64>,
    r: &[f64],
) -> f64 {
    let image = |m: &dyn Preconditioner<f64>| {
        let mut z = vec![0.0; r.len()];
        m.solve(r, &mut z, &mut vec![0.0; m.work_len()]);
        z
    };
    let (mut a, b) = (image(single), image(double));
    a.iter_mut().zip(&b).for_each(|(a, b)| *a -= b);
    let off = norm2(&a) / norm2(&b);
    if off.is_nan() { f64::INFINITY } else { off }
}
