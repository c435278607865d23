//! One iteration around what is set up, and its report.

use super::precision::{self, Double, InDouble, Watch};
use super::report::SolveReport;
use super::stages::Stages;
use super::{RightHandSide, Solve, Status, memory, output};
use crate::command::progress::Progress;
use fracas_operators::Preconditioner;
use fracas_operators::matrix_market::write_vector;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::multigrid::Summary;
use fracas_solvers::saddle::{
    Accurate, Cost, Measure, P, RelaxationSummary, SaddleBlocks, SaddleSystem, T, U,
};
use fracas_solvers::spectrum::Explanation;
use std::io::Write;
use std::time::Instant;

/// What the report calls the parts.
pub(super) struct Names {
    pub(super) method: String,
    pub(super) augmentation: Option<String>,
    pub(super) inner: Option<String>,
    pub(super) relaxation: RelaxationSummary,
}

/// Explains a solve that took so many seconds.
pub(super) type Explain<'a> = &'a dyn Fn(f64) -> anyhow::Result<Explanation>;

/// Everything that is ready before the iteration.
pub(super) struct Built<'a> {
    pub(super) equations: &'a dyn SaddleSystem,
    pub(super) preconditioner: &'a dyn Preconditioner<f64>,
    pub(super) hierarchy: Option<Summary>,
    pub(super) names: Names,
    pub(super) rhs: RightHandSide,
    pub(super) b: &'a [f64],
    /// Of the tractions.
    pub(super) unit: f64,
    pub(super) setup_s: f64,
    pub(super) findings: Vec<String>,
    pub(super) explain: Option<Explain<'a>>,
    /// Times that f32 gave way to f64 while setting up.
    pub(super) fallbacks: usize,
    /// Inner solvers that could not be set up.
    pub(super) inner_fallbacks: usize,
    /// The preconditioner in f64, where f32 is inside.
    pub(super) in_double: Option<InDouble<'a>>,
    /// The blocks, where the iteration is one without them.
    pub(super) in_entries: Option<InEntries<'a>>,
}

/// Assembles the blocks in the unit of the tractions.
pub(super) type InEntries<'a> = Box<dyn Fn(&mut Progress) -> anyhow::Result<SaddleBlocks> + 'a>;

/// A number, or nothing.
fn number(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// M⁻¹ in use.
fn inverse<'b>(built: &Built<'b>, double: &'b Option<Double>) -> &'b dyn Preconditioner<f64> {
    match double {
        Some(double) => &*double.preconditioner,
        None => built.preconditioner,
    }
}

impl Solve {
    /// The iteration that was asked for, or the one that fits.
    fn krylov(&self, built: &Built<'_>) -> anyhow::Result<(KrylovChoice, Option<String>)> {
        if let Some(asked) = self.krylov {
            let choice = asked.flexible_for(built.preconditioner);
            if !built.preconditioner.properties().linear && !choice.is_flexible() {
                let krylov = choice.name();
                let inner = built.names.inner.as_deref().unwrap_or_default();
                anyhow::bail!(
                    "--krylov {krylov} needs a linear preconditioner, and --inner {inner} is none; take gmres or fgmres"
                );
            }
            return Ok((choice, None));
        }
        let fitted = memory::krylov_that_fits(
            built.equations.operator(),
            built.preconditioner,
            built.equations.has_short_recurrences(),
        )?;
        Ok((fitted.choice, fitted.reason))
    }

    /// Iterates, judges, reports.
    pub(super) fn iterate(
        &self,
        built: &Built<'_>,
        mut progress: Progress,
        out: &mut dyn Write,
    ) -> anyhow::Result<Status> {
        let (krylov, reason) = self.krylov(built)?;
        let mut findings = built.findings.clone();
        if let Some(reason) = reason {
            progress.say(&format!("krylov: {reason}"));
            findings.push(format!("krylov: {reason}"));
        }
        progress.say("iterating");
        let operator = built.equations.operator();
        let system = System {
            operator,
            preconditioner: built.preconditioner,
            rhs: built.b,
        };
        let criteria = Criteria {
            relative_tolerance: self.tolerance,
            max_iterations: self.max_iterations,
        };
        let mut x = vec![0.0; built.b.len()];
        let method = krylov.method();
        let own = built.rhs == RightHandSide::Folder;
        let norms = built.equations.norms(own);
        // T of a folder may be no norm of pressures
        let layout = built.equations.layout();
        let measure = match layout.length(P) {
            0 => Measure::from(self.measure),
            _ => Measure::Residual,
        };
        let may_stop = built.in_double.is_some() && built.preconditioner.properties().single;
        let mut watch = Watch::new(&mut progress, may_stop);
        let judged = (measure, &norms);
        let mut stages = Stages::begin(method, criteria, judged, &system, &mut x, &mut watch);
        let flat = watch.flat;
        let (mut setup_s, mut double) = (built.setup_s, None);
        let start = Instant::now();
        let again = precision::again(built, (&stages.last.result, flat), &mut x, &mut progress);
        setup_s += start.elapsed().as_secs_f64();
        if let Some(again) = again {
            progress.say(&again.finding);
            findings.push(again.finding);
            double = again.double;
            // what only stood still goes on, be it with f32
            if double.is_some() || flat.is_some() {
                let system = System {
                    preconditioner: inverse(built, &double),
                    ..system
                };
                stages.go_on(&norms, &system, &mut x, &mut progress);
            }
        }
        let start = Instant::now();
        let entries = (built.in_entries.as_ref()).filter(|_| stages.is_rounding());
        let entries = entries.and_then(|in_entries| {
            in_entries(&mut progress)
                .map_err(|error| {
                    findings.push(format!(
                        "refinement: f64 holds no more digits of the residual, and entries for twice the digits could not be had: {error:#}"
                    ));
                })
                .ok()
        });
        setup_s += start.elapsed().as_secs_f64();
        let of_entries = entries.as_ref().filter(|_| own).map(SaddleBlocks::rhs);
        let b = of_entries.as_deref().unwrap_or(built.b);
        let norms = match &entries {
            None => norms,
            Some(blocks) => {
                let norms = norms.with_entries(blocks);
                let system = System {
                    preconditioner: inverse(built, &double),
                    rhs: b,
                    ..system
                };
                stages.go_on(&norms, &system, &mut x, &mut progress);
                norms
            }
        };
        let Stages {
            last: Accurate { result, error, .. },
            before,
            refinements,
            solve_s,
            ..
        } = stages;
        if refinements > 0 {
            let finding = format!(
                "refinement: f64 holds no more digits of the residual; passes with residuals in twice the digits: {refinements}"
            );
            progress.say(&finding);
            findings.push(finding);
        }
        let preconditioner = inverse(built, &double);
        let fallbacks = built.fallbacks + usize::from(double.is_some());
        let explanation = match built.explain {
            Some(explain) => {
                progress.say("explaining");
                Some(explain(solve_s)?)
            }
            None => None,
        };
        drop(progress);

        let cost = Cost::new(operator, preconditioner);
        let sharp = norms.entries().filter(|_| refinements > 0);
        let residual = built.equations.residual(&x, b, sharp);
        let mut report = SolveReport {
            outcome: "breakdown",
            iterations: 0,
            relative_residual: residual.relative,
            measure,
            error_u: number(error[U]),
            error_t: number(error[T]),
            smallest_ritz: (result.as_ref().ok()).and_then(|report| report.smallest_ritz),
            backward_error: residual.backward,
            contact_residual: residual.contact,
            method: built.names.method.clone(),
            augmentation: built.names.augmentation.clone(),
            inner: match &double {
                Some(double) => Some(double.inner.clone()),
                None => built.names.inner.clone(),
            },
            relaxation: built.names.relaxation.gamma,
            relaxation_degree: built.names.relaxation.degree,
            krylov: krylov.to_string(),
            rhs: built.rhs,
            tolerance: self.tolerance,
            traction_unit: built.unit,
            n_u: layout.length(U),
            n_t: layout.length(T),
            n_p: layout.length(P),
            c_app: cost.c_app(),
            c_s: None,
            cost_convention: Cost::CONVENTION,
            products: None,
            setup_s,
            solve_s,
            peak_memory_bytes: memory::peak_bytes(),
            amg: match &double {
                Some(double) => double.hierarchy.clone(),
                None => built.hierarchy.clone(),
            },
            reason: None,
            findings,
            precision_fallbacks: fallbacks,
            inner_fallbacks: built.inner_fallbacks,
            explain: explanation,
        };
        report.record(&result, before, |iterations| cost.c_s(iterations, &krylov));
        if let Some(path) = &self.solution {
            let [t] = layout.split_mut([T], &mut x);
            t.iter_mut().for_each(|t| *t *= built.unit);
            write_vector(path, &x)?;
        }
        match &self.json {
            Some(path) => output::json(path, &report, out)?,
            None => report.print(out)?,
        }
        Ok(if report.outcome == "converged" {
            Status::Done
        } else {
            Status::NotConverged
        })
    }
}
