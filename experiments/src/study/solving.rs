//! One row: a system, a method, and what is measured.

use super::Inner;
use super::outcome::Outcome;
use super::product::{Case, Origin};
use super::reference::Reference;
use super::refine::refined;
use super::{Limit, Study};
use crate::scenes;
use crate::sentence;
use crate::trial::Budget;
use fracas::memory;
use fracas::run::Stop;
use fracas::solve::{End, Problem, Route, Solve, Solved, Solver, StuckBody, SystemKind};
use fracas_solvers::saddle::SaddleMethod;
use fracas_solvers::spectrum::{SpectrumReport, SpectrumRequest, analyse_method};
use fracas_solvers::{Observer, Silent, Step};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// What a row brought to light.
#[derive(Default)]
pub(super) struct Measured {
    pub(super) solved: Option<Solved>,
    /// Of u and t, against a reference.
    pub(super) errors: Option<[f64; 2]>,
    pub(super) spectrum: Option<SpectrumReport>,
    pub(super) outcome: Option<Outcome>,
    /// Why, or what to mind; several sentences behind each other.
    pub(super) reasons: Vec<String>,
}

impl Measured {
    /// The method that ran, with its parts.
    pub(super) fn ran(&self) -> String {
        let Some(solved) = &self.solved else {
            return String::new();
        };
        let mut ran = solved.method.clone();
        for part in [&solved.augmentation, &solved.inner].into_iter().flatten() {
            ran = format!("{ran} {part}");
        }
        format!("{ran} {}", solved.krylov)
    }
}

/// Stops an iteration on request, or when its time is over.
pub(super) struct Watch<'a> {
    stop: &'a dyn Stop,
    deadline: Option<Instant>,
}

impl<'a> Watch<'a> {
    /// Without a limit of time.
    pub(super) fn of(stop: &'a dyn Stop) -> Self {
        Self {
            stop,
            deadline: None,
        }
    }

    fn within(stop: &'a dyn Stop, limit: &Limit) -> Self {
        let seconds = limit.seconds.map(|s| Duration::try_from_secs_f64(s).ok());
        let deadline = seconds
            .flatten()
            .and_then(|s| Instant::now().checked_add(s));
        Self { stop, deadline }
    }
}

impl Observer for Watch<'_> {
    fn observe(&mut self, _: &Step) -> ControlFlow<()> {
        let late = self.deadline.is_some_and(|end| Instant::now() > end);
        match late || self.stop.asked().is_some() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// Gives a solver the right-hand side of a row, where it does not know it.
pub(super) fn load(solver: &mut Solver, case: &Case) {
    let entries = case
        .rhs
        .value
        .and_then(|load| load.entries(solver.unknowns()));
    if let Some(entries) = entries {
        solver.set_rhs(entries);
    }
}

impl Case {
    /// Reads what is solved; nothing is meshed.
    pub(super) fn problem(&self) -> anyhow::Result<Problem> {
        match &self.origin {
            Origin::System(folder) => Ok(Problem::Folder(folder.into())),
            Origin::Scene(name) => {
                let scene = scenes::load(name)?.with_overrides(&self.set)?;
                let scene = refined(scene, self.refine)?;
                Ok(Problem::Body(StuckBody::of_scene(name, scene)))
            }
        }
    }

    /// Solves and measures; what fails is an outcome. `None` where the wish to stop came first.
    pub(super) fn measured(
        &self,
        study: &Study,
        reference: &mut Option<Reference>,
        stop: &dyn Stop,
    ) -> Option<Measured> {
        let mut measured = Measured::default();
        if let Err(error) = self.measure(study, reference, stop, &mut measured) {
            // what is known already stays
            let outcome = Outcome::of_error(&error);
            measured.outcome.get_or_insert(outcome);
            measured.reasons.push(sentence::of(&error));
        }
        stop.asked().is_none().then_some(measured)
    }

    fn measure(
        &self,
        study: &Study,
        reference: &mut Option<Reference>,
        stop: &dyn Stop,
        measured: &mut Measured,
    ) -> anyhow::Result<()> {
        let problem = self.problem()?;
        let settings = self.settings(study)?;
        self.solve(&settings, &problem, &study.limit, stop, measured)?;
        if stop.asked().is_some() {
            return Ok(());
        }
        if study.reference {
            self.compare(&problem, reference, stop, measured);
        }
        if study.is_spectral() {
            self.analyse(&settings, &problem, measured)?;
        }
        Ok(())
    }

    fn settings(&self, study: &Study) -> anyhow::Result<Solve> {
        let (inner, rule) = Inner::choose(self.inner.value);
        let method = self.method.value.unwrap_or_default();
        Ok(Solve {
            method: method.with_parts(self.augmentation.value, inner)?,
            inner: rule,
            krylov: self.krylov.value,
            measure: study.tolerance_of,
            tolerance: self.tolerance,
            max_iterations: study.limit.iterations,
            rhs: self.rhs.value.map(|load| load.known()),
            ..Solve::default()
        })
    }

    fn solve(
        &self,
        settings: &Solve,
        problem: &Problem,
        limit: &Limit,
        stop: &dyn Stop,
        measured: &mut Measured,
    ) -> anyhow::Result<()> {
        memory::reset_peak();
        let mut watch = Watch::within(stop, limit);
        let mut solver = settings.set_up(problem, &mut watch)?;
        load(&mut solver, self);
        let budget = Budget {
            iterations: limit.iterations,
            cost: limit.products,
        };
        let most = budget.most(solver.cost().c_app());
        solver.set_max_iterations(most);
        let solved = solver.solve(&mut watch)?;
        let (outcome, reason) = match solved.outcome {
            End::Converged => (Outcome::Converged, None),
            End::IterationLimit if most < limit.iterations => (
                Outcome::CostLimit,
                Some(format!(
                    "given up after {} iterations: C_s above {}",
                    solved.iterations, limit.products
                )),
            ),
            End::IterationLimit => (
                Outcome::IterationLimit,
                Some(format!("not converged in {} iterations", solved.iterations)),
            ),
            End::Stopped => (
                Outcome::CostLimit,
                Some(format!(
                    "stopped after {} iterations: its {} s are over",
                    solved.iterations,
                    limit.seconds.unwrap_or_default()
                )),
            ),
            End::Breakdown => (Outcome::Breakdown, None),
        };
        measured.outcome = Some(outcome);
        measured.reasons.extend(reason);
        measured.reasons.extend(solved.reason.clone());
        (measured.reasons).extend(solved.findings.iter().map(ToString::to_string));
        measured.solved = Some(solved);
        Ok(())
    }

    /// Fills the true errors.
    fn compare(
        &self,
        problem: &Problem,
        reference: &mut Option<Reference>,
        stop: &dyn Stop,
        measured: &mut Measured,
    ) {
        if !reference.as_ref().is_some_and(|own| own.serves(self)) {
            *reference = None;
            match Reference::new(self, problem, stop) {
                Ok(new) => *reference = Some(new),
                Err(error) => {
                    let why = sentence::of(&error);
                    (measured.reasons).push(format!("no reference, errors are estimates: {why}"));
                }
            }
        }
        measured.errors = (reference.as_ref().zip(measured.solved.as_ref()))
            .map(|(reference, solved)| reference.errors(&solved.x));
    }

    fn analyse(
        &self,
        settings: &Solve,
        problem: &Problem,
        measured: &mut Measured,
    ) -> anyhow::Result<()> {
        let kind = SystemKind::Entries("a spectrum");
        let method: SaddleMethod = Route::new(&settings.method, settings.inner, kind)?.method;
        let blocks = problem.load(&mut Silent)?.blocks;
        let request = SpectrumRequest::default();
        let report = analyse_method(&blocks, &method, &request, &mut Silent)?;
        (measured.reasons).extend(report.notes.iter().map(|note| format!("spectrum: {note}")));
        measured.spectrum = Some(report);
        Ok(())
    }
}
