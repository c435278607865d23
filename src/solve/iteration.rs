//! One iteration around what is set up: in stages, judged, recorded.

use super::giving_way::Before;
use super::precision::{self, is_single};
use super::solver::{Double, Solver};
use super::stages::Stages;
use super::{End, Finding, RightHandSide, SolveError, Solved};
use crate::inner::{Hope, Standstill};
use crate::memory;
use fracas_operators::Preconditioner;
use fracas_solvers::Observer;
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::{Accurate, Cost, P, SaddleBlocks, SaddleSystem, T, U};
use fracas_solvers::spectrum::{Explanation, Solved as Explained};
use std::time::Instant;

/// A number, or nothing.
fn number(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

impl Solver {
    /// The iteration that was asked for, or the one that fits.
    fn krylov(
        &self,
        equations: &dyn SaddleSystem,
    ) -> Result<(KrylovChoice, Option<String>), SolveError> {
        let preconditioner = &*self.ready.inverse;
        if let Some(asked) = self.settings.krylov {
            let choice = asked.flexible_for(preconditioner);
            if !preconditioner.properties().linear && !choice.is_flexible() {
                return Err(SolveError::Nonlinear {
                    krylov: choice.name(),
                    inner: self.names.inner.clone().unwrap_or_default(),
                });
            }
            let reason = (choice != asked).then(|| {
                let inner = self.names.inner.as_deref().unwrap_or("this method");
                format!("{choice} in place of {asked}, because M⁻¹ with {inner} is linear to the digits of f32 only, or not at all")
            });
            return Ok((choice, reason));
        }
        let symmetric = equations.has_short_recurrences();
        let fitted = memory::krylov_that_fits(equations.operator(), preconditioner, symmetric)?;
        Ok((fitted.choice, fitted.reason))
    }

    /// Iterates from where the inner solvers `before` ended; one that `may_give_way` does where the iteration gets nowhere.
    pub(super) fn iterate(
        &self,
        equations: &dyn SaddleSystem,
        (before, may_give_way): (&Before, bool),
        observer: &mut dyn Observer,
    ) -> Result<(Solved, Option<Double>), SolveError> {
        let (krylov, reason) = self.krylov(equations)?;
        let mut findings = before.findings(self);
        let mut found = |observer: &mut dyn Observer, finding: Finding| {
            observer.say(&finding);
            findings.push(finding);
        };
        if let Some(reason) = reason {
            found(observer, Finding::Krylov { reason });
        }
        observer.say(&"iterating");
        let settings = &self.settings;
        let operator = equations.operator();
        let system = System {
            operator,
            preconditioner: &*self.ready.inverse,
            rhs: &self.b,
        };
        let criteria = Criteria {
            relative_tolerance: settings.tolerance,
            max_iterations: before.left(settings),
        };
        let layout = equations.layout();
        let mut x = match before.x.len() {
            0 => vec![0.0; self.b.len()],
            _ => before.x.clone(),
        };
        let stresses = layout.length(U)..;
        (x[stresses.clone()].iter_mut()).for_each(|t| *t /= self.unit);
        let own = self.rhs == RightHandSide::System;
        let norms = equations.norms(own);
        let measure = settings.measure;
        let hope = may_give_way.then_some(Hope {
            tolerance: settings.tolerance,
            limit: criteria.max_iterations,
        });
        let mut standstill = Standstill::new(observer, is_single(self), hope);
        let judged = (measure, &norms);
        let method = krylov.method();
        let mut stages = Stages::begin(method, criteria, judged, &system, &mut x, &mut standstill);
        let mut gave_up = standstill.gave_up;
        let (mut setup_s, mut double) = (self.setup_s, None);
        let start = Instant::now();
        let ended = (&stages.last.result, gave_up.map(|at| at.residual));
        let again = precision::again(self, operator, ended, &mut x, observer);
        setup_s += start.elapsed().as_secs_f64();
        if let Some(again) = again {
            found(observer, Finding::Precision(again.rounding));
            double = again.double;
            // what only stood still goes on, be it with f32, unless another inner solver does
            let goes_on = gave_up.take_if(|at| double.is_some() || !at.hopeless);
            if double.is_some() || goes_on.is_some() {
                let system = System {
                    preconditioner: self.inverse(&double),
                    ..system
                };
                let hope = hope.map(|hope| Hope {
                    limit: (hope.limit)
                        .saturating_sub(precision::iterations_of(&stages.last.result)),
                    ..hope
                });
                let mut standstill = Standstill::new(observer, false, hope);
                stages.go_on(&norms, &system, &mut x, &mut standstill);
                gave_up = standstill.gave_up;
            }
        }
        let start = Instant::now();
        let entries = match stages.is_rounding() {
            true => self.in_entries(observer),
            false => None,
        };
        let entries = entries.and_then(|entries| match entries {
            Ok(blocks) => Some(blocks),
            Err(error) => {
                let failure = error.in_full();
                findings.push(Finding::NotRefined { failure });
                None
            }
        });
        setup_s += start.elapsed().as_secs_f64();
        let of_entries = entries.as_ref().filter(|_| own).map(SaddleBlocks::rhs);
        let b = of_entries.as_deref().unwrap_or(&self.b);
        let norms = match &entries {
            None => norms,
            Some(blocks) => {
                let norms = norms.with_entries(blocks);
                let system = System {
                    preconditioner: self.inverse(&double),
                    rhs: b,
                    ..system
                };
                stages.go_on(&norms, &system, &mut x, observer);
                norms
            }
        };
        let Stages {
            last:
                Accurate {
                    result,
                    error,
                    left_open,
                    ..
                },
            before: stages_before,
            refinements,
            solve_s,
            ..
        } = stages;
        if refinements > 0 {
            let finding = Finding::Refined {
                passes: refinements,
            };
            observer.say(&finding);
            findings.push(finding);
        }
        let open = left_open.and_then(|open| open.largest());
        if let Some((field, by)) = open.filter(|(_, by)| *by > settings.tolerance) {
            let finding = Finding::LeftOpen {
                part: field.name,
                by,
            };
            observer.say(&finding);
            findings.push(finding);
        }
        let explain = match settings.explain {
            true => self.explained(entries.as_ref(), solve_s, observer)?,
            false => None,
        };
        let cost = Cost::new(operator, self.inverse(&double));
        let sharp = norms.entries().filter(|_| refinements > 0);
        let residual = equations.residual(&x, b, sharp);
        let relative_residual = match self.row_unit {
            1.0 => residual.relative,
            unit => equations.relative_residual_in(unit, (&x, b), sharp),
        };
        (x[stresses].iter_mut()).for_each(|t| *t *= self.unit);
        let names = self.names.clone();
        let mut solved = Solved {
            outcome: End::Breakdown,
            iterations: 0,
            relative_residual,
            measure,
            error_u: number(error[U]),
            error_t: number(error[T]),
            error_p: error.get(P).and_then(number),
            smallest_ritz: (result.as_ref().ok()).and_then(|report| report.smallest_ritz),
            backward_error: residual.backward,
            contact_residual: residual.contact,
            method: names.method,
            augmentation: names.augmentation,
            inner: match &double {
                Some(double) => Some(double.inner.clone()),
                None => names.inner,
            },
            relaxation: self.ready.relaxation.gamma,
            relaxation_degree: self.ready.relaxation.degree,
            krylov,
            rhs: self.rhs,
            tolerance: settings.tolerance,
            traction_unit: self.unit,
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
                Some(double) => double.ready.hierarchy.clone(),
                None => self.ready.hierarchy.clone(),
            },
            engine: None,
            reason: None,
            findings,
            precision_fallbacks: self.fallbacks + usize::from(double.is_some()),
            inner_fallbacks: self.replaced,
            explain,
            breakdown: None,
            x,
        };
        solved.record(&result, stages_before, |iterations| {
            cost.c_s(iterations, &krylov)
        });
        if gave_up.is_some() && solved.outcome == End::Stopped {
            // nobody else wanted so
            solved.outcome = End::IterationLimit;
        }
        Ok((solved, double))
    }

    /// M⁻¹ in use.
    fn inverse<'s>(&'s self, double: &'s Option<Double>) -> &'s dyn Preconditioner<f64> {
        match double {
            Some(double) => &*double.ready.inverse,
            None => &*self.ready.inverse,
        }
    }

    /// From the blocks that are there, or else made for it; `None` where no process has all of them.
    fn explained(
        &self,
        entries: Option<&SaddleBlocks>,
        solve_s: f64,
        observer: &mut dyn Observer,
    ) -> Result<Option<Explanation>, SolveError> {
        let known = entries.or(self.equations.blocks().map(|blocks| &**blocks));
        let made = match known {
            Some(_) => None,
            None => self.in_entries(observer).transpose()?,
        };
        let Some(blocks) = known.or(made.as_ref()) else {
            return Ok(None);
        };
        observer.say(&"explaining");
        Ok(Some(Explanation::new(&Explained {
            blocks,
            method: &self.method,
            preconditioner: &*self.ready.inverse,
            hierarchy: self.hierarchy(),
            parts: self.ready.parts,
            rhs: &self.b,
            setup_s: self.setup_s,
            solve_s,
        })?))
    }
}
