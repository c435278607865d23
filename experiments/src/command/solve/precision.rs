//! A preconditioner in f32 that failed: the same one in f64, where f32 is to blame.

use super::iteration::Built;
use crate::command::progress::Progress;
use fracas_operators::Preconditioner;
use fracas_operators::vector::norm2;
use fracas_solvers::SetupError;
use fracas_solvers::amg::Precision;
use fracas_solvers::krylov::{Breakdown, Outcome, Report};
use fracas_solvers::saddle::{InnerChoice, Ready, SaddleBlocks, SaddleMethod};

/// Builds the preconditioner in f64.
pub(super) type InDouble<'a> =
    Box<dyn Fn(&mut Progress) -> anyhow::Result<Box<dyn Preconditioner<f64>>> + 'a>;

/// Difference of `M⁻¹r` in f32 and in f64, relative to the latter, from which f32 is to blame. Unit: 1.
const LOST: f64 = 1e-2;

/// What is done after an iteration that failed around f32.
pub(super) struct Again {
    /// The preconditioner to go on with; `None` where f32 is not to blame.
    pub(super) double: Option<Box<dyn Preconditioner<f64>>>,
    /// What to say.
    pub(super) finding: String,
}

/// The method with its inner solver in f64, where it has one in f32.
pub(super) fn in_double(method: &SaddleMethod) -> Option<SaddleMethod> {
    match method.inner() {
        Some(InnerChoice::Amg(amg)) if amg.precision == Precision::F32 => {
            let amg = fracas_solvers::amg::Amg {
                precision: Precision::F64,
                ..amg
            };
            let double = method.with_parts(None, Some(InnerChoice::Amg(amg)));
            double.ok()
        }
        _ => None,
    }
}

/// The method set up; where that fails in f32 and not in f64 it is the latter, with a finding that says so.
///
/// # Errors
/// Of the method as it was asked for.
pub(super) fn ready(
    method: &SaddleMethod,
    blocks: &SaddleBlocks,
) -> Result<(Ready, Option<String>), SetupError> {
    let error = match method.ready(blocks) {
        Ok(ready) => return Ok((ready, None)),
        Err(error) => error,
    };
    match in_double(method).map(|double| double.ready(blocks)) {
        Some(Ok(ready)) => {
            let finding = format!("precision: with f32 {error}; the hierarchy is in f64");
            Ok((ready, Some(finding)))
        }
        _ => Err(error),
    }
}

/// Iterations made.
pub(super) fn iterations_of(result: &Result<Report, Breakdown>) -> usize {
    match result {
        Ok(report) => report.iterations,
        Err(breakdown) => breakdown.iteration(),
    }
}

/// Why the iteration failed, if it did.
fn failure(result: &Result<Report, Breakdown>) -> Option<String> {
    match result {
        Ok(report) if report.outcome == Outcome::IterationLimit => {
            Some(format!("not converged in {} iterations", report.iterations))
        }
        Ok(_) => None,
        Err(breakdown) => Some(breakdown.to_string()),
    }
}

/// After a failed iteration around f32: the preconditioner in f64 and, where its `M⁻¹r` differs for the residual r of x, the word
/// to go on with it.
///
/// # Errors
/// Of setting up in f64.
pub(super) fn again(
    built: &Built<'_>,
    result: &Result<Report, Breakdown>,
    x: &mut [f64],
    progress: &mut Progress,
) -> anyhow::Result<Option<Again>> {
    let (Some(failure), Some(in_double)) = (failure(result), &built.in_double) else {
        return Ok(None);
    };
    if !built.preconditioner.is_single() {
        return Ok(None);
    }
    if !x.iter().all(|x| x.is_finite()) {
        x.fill(0.0);
    }
    progress.say("f32 failed: setting up in f64");
    let double = in_double(progress)?;
    let mut r = built.b.to_vec();
    let operator = built.equations.operator();
    operator.apply_add(-1.0, x, &mut r, &mut vec![0.0; operator.work_len()]);
    let lost = difference(built.preconditioner, &*double, &r);
    Ok(Some(if lost < LOST {
        let finding = format!(
            "precision: {failure}; f32 inside is not to blame, its M⁻¹r is that of f64 to {lost:.0e}"
        );
        Again {
            double: None,
            finding,
        }
    } else {
        let finding = format!(
            "precision: {failure}; M⁻¹r in f32 is off by {lost:.0e} of that in f64, so the iteration went on with f64"
        );
        Again {
            double: Some(double),
            finding,
        }
    }))
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
