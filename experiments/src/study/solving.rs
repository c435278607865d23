//! One row: a system, a method, and what is measured.

use super::counted::counted;
use super::figure_section::Kind;
use super::measure::Group;
use super::measured::{Contact, Measured};
use super::nested::Nested;
use super::outcome::Outcome;
use super::prepared::Prepared;
use super::product::Case;
use super::reference::Reference;
use super::{Counts, Inner, Limit, Name, Study, stepping};
use crate::sentence;
use fracas::memory;
use fracas::run::Stop;
use fracas::solve::{End, Problem, Route, Solve, Solver, SystemKind};
use fracas_solvers::saddle::{Measure, SaddleMethod};
use fracas_solvers::spectrum::{NonNormalRequest, SpectrumRequest, analyse_method};
use fracas_solvers::{Observer, Silent, Step};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// Stops an iteration on request, or when its time is over.
pub(super) struct Watch<'a> {
    stop: &'a dyn Stop,
    deadline: Option<Instant>,
    residuals: Vec<f64>,
}

impl<'a> Watch<'a> {
    /// Without a limit of time.
    pub(super) fn of(stop: &'a dyn Stop) -> Self {
        Self {
            stop,
            deadline: None,
            residuals: Vec::new(),
        }
    }

    fn within(stop: &'a dyn Stop, limit: &Limit) -> Self {
        let seconds = limit.seconds.map(|s| Duration::try_from_secs_f64(s).ok());
        let deadline = seconds
            .flatten()
            .and_then(|s| Instant::now().checked_add(s));
        Self {
            deadline,
            ..Self::of(stop)
        }
    }
}

impl Stop for Watch<'_> {
    fn asked(&self) -> Option<&'static str> {
        let is_late = self.deadline.is_some_and(|end| Instant::now() > end);
        let late = is_late.then_some("its seconds are over");
        self.stop.asked().or(late)
    }
}

impl Observer for Watch<'_> {
    fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        if let Step::Krylov {
            relative_residual, ..
        } = step
        {
            self.residuals.push(*relative_residual);
        }
        match self.asked() {
            Some(_) => ControlFlow::Break(()),
            None => ControlFlow::Continue(()),
        }
    }
}

impl Limit {
    /// Most iterations of a method whose M⁻¹ costs c_app products: C_s = n_it (1 + c_app).
    pub(super) fn most(&self, c_app: f64) -> usize {
        let affordable = (self.products / (1.0 + c_app)).min(1e9) as usize;
        self.iterations.min(affordable)
    }

    /// What a limit of `most` iterations means.
    pub(super) fn met(&self, most: usize) -> (Outcome, Option<String>) {
        if most < self.iterations {
            let above = self.products;
            let reason = format!("given up after {most} iterations: C_s above {above}");
            return (Outcome::CostLimit, Some(reason));
        }
        let reason = format!("not converged in {most} iterations");
        (Outcome::IterationLimit, Some(reason))
    }

    pub(super) fn seconds_over(&self, iterations: usize) -> (Outcome, Option<String>) {
        let seconds = self.seconds.unwrap_or_default();
        let reason = format!("stopped after {iterations} iterations: its {seconds} s are over");
        (Outcome::CostLimit, Some(reason))
    }
}

/// Gives a solver the right-hand side of a row, where it does not know it.
pub(super) fn load(solver: &mut Solver, case: &Case) {
    let load = case.setting.rhs.as_ref().and_then(|rhs| rhs.value);
    let entries = load.and_then(|load| load.entries(solver.unknowns()));
    if let Some(entries) = entries {
        solver.set_rhs(entries);
    }
}

/// What rows behind each other share.
#[derive(Default)]
pub(super) struct Shared {
    prepared: Option<Prepared>,
    nested: Nested,
    reference: Option<Reference>,
}

impl Shared {
    /// Gives back what serves this row no longer, so that its memory is its own.
    fn make_room(&mut self, case: &Case, raw: Option<bool>) {
        self.prepared
            .take_if(|own| !raw.is_some_and(|raw| own.serves(case, raw)));
        self.reference.take_if(|own| !own.serves(case));
    }
}

/// The matrices of a row, made where they are not there.
fn prepared<'a>(
    slot: &'a mut Option<Prepared>,
    case: &Case,
    raw: bool,
    measure: Measure,
) -> anyhow::Result<&'a mut Prepared> {
    match slot {
        Some(prepared) => Ok(prepared),
        none => Ok(none.insert(Prepared::new(case, raw, measure)?)),
    }
}

/// A row in the making.
pub(super) struct Row<'a> {
    pub(super) case: &'a Case,
    pub(super) study: &'a Study,
    /// Measures that are asked for.
    pub(super) names: &'a [Name],
    pub(super) stop: &'a (dyn Stop + Sync),
    /// Folder of the study, where it has one.
    pub(super) place: Option<&'a Path>,
}

impl Row<'_> {
    /// Solves and measures; what fails is an outcome. `None` where the wish to stop came first.
    pub(super) fn measured(&self, shared: &mut Shared) -> Option<Measured> {
        let mut measured = Measured::default();
        if let Err(error) = self.measure(shared, &mut measured) {
            // what is known already stays
            let outcome = Outcome::of_error(&error);
            measured.outcome.get_or_insert(outcome);
            measured.reasons.push(sentence::of(&error));
        }
        self.stop.asked().is_none().then_some(measured)
    }

    fn asks(&self, groups: &[Group]) -> bool {
        (self.names.iter()).any(|name| groups.contains(&name.group()))
    }

    fn measure(&self, shared: &mut Shared, measured: &mut Measured) -> anyhow::Result<()> {
        let settings = self.settings()?;
        measured.c = settings.method.augmentation();
        measured.asked = settings.krylov.unwrap_or_default().to_string();
        let (setting, study) = (&self.case.setting, self.study);
        let solves = self.asks(&[Group::Solve, Group::Clock, Group::Count, Group::Nested]);
        let counts = setting.counts.unwrap_or(study.counts);
        let (published, spectral) = (
            solves && counts == Counts::Published,
            self.asks(&[Group::Spectrum, Group::NonNormal]),
        );
        let conditions = self.asks(&[Group::Condition]);
        let runs = self.asks(&[Group::Run]);
        let is_bare = !solves && !runs;
        let prepares = published || conditions || spectral || is_bare || setting.state.is_some();
        shared.make_room(self.case, prepares.then_some(spectral || conditions));
        memory::reset_peak();
        if prepares {
            let prepared = prepared(
                &mut shared.prepared,
                self.case,
                spectral || conditions,
                self.study.tolerance_of,
            )?;
            facts(prepared, measured);
            let n: usize = measured.sizes.iter().flatten().sum();
            if self.is_too_large(n, measured) {
                return Ok(());
            }
            if published {
                let mut watch = Watch::within(self.stop, &study.limit);
                let (run, outcome, reason) =
                    counted(self.case, &settings, prepared, study, &mut watch)?;
                measured.residuals = watch.residuals;
                if self.asks(&[Group::Nested]) {
                    let asks = self.names.contains(&Name::MeshError);
                    let finest = study.finest.as_ref().filter(|_| asks);
                    let errors = shared.nested.errors(self.case, prepared, finest, &run.x);
                    measured.nested = Some(errors?);
                }
                if setting.matrix_free == Some(true) || setting.single == Some(true) {
                    measured.assembly_s = Some(0.0);
                }
                measured.run = Some(run);
                measured.outcome = Some(outcome);
                measured.reasons.extend(reason);
            }
        }
        if solves && !published {
            let problem = match (setting.state, &shared.prepared) {
                (Some(_), Some(prepared)) => Problem::Blocks(prepared.blocks.clone()),
                _ => self.case.problem()?,
            };
            self.solve(&settings, &problem, measured)?;
            if study.reference && measured.run.is_some() {
                self.compare(&problem, &mut shared.reference, measured);
            }
        }
        if self.stop.asked().is_some() {
            return Ok(());
        }
        if runs {
            let watch = Watch::within(self.stop, &study.limit);
            stepping::run(self.case, self.place, &watch, measured)?;
        }
        if conditions {
            self.conditions(
                &settings,
                prepared(
                    &mut shared.prepared,
                    self.case,
                    true,
                    self.study.tolerance_of,
                )?,
                measured,
            )?;
        }
        if spectral {
            let blocks = &prepared(
                &mut shared.prepared,
                self.case,
                true,
                self.study.tolerance_of,
            )?
            .blocks;
            let kind = SystemKind::Entries("a spectrum");
            let method: SaddleMethod =
                Route::new(&settings.method, settings.inner, kind, None)?.method;
            let request = SpectrumRequest {
                conditions: false,
                non_normal: self.non_normal(),
                dense_limit: (setting.dense).unwrap_or(SpectrumRequest::default().dense_limit),
                ..SpectrumRequest::default()
            };
            let report = analyse_method(blocks, &method, &request, &mut Silent)?;
            (measured.reasons).extend(report.notes.iter().map(|note| format!("spectrum: {note}")));
            measured.spectrum = Some(report);
        }
        measured.outcome.get_or_insert(Outcome::Measured);
        Ok(())
    }

    /// Where a measure or a figure asks for it; the grid is for figures.
    fn non_normal(&self) -> Option<NonNormalRequest> {
        let draws = |kind| self.study.figure.iter().any(|figure| figure.kind == kind);
        let mut request = NonNormalRequest::default();
        if !draws(Kind::Pseudospectra) {
            request.points = 0;
        }
        self.asks(&[Group::NonNormal]).then_some(request)
    }

    fn is_too_large(&self, n: usize, measured: &mut Measured) -> bool {
        let Some(largest) = self.case.setting.largest.filter(|largest| n > *largest) else {
            return false;
        };
        measured.outcome = Some(Outcome::NotTried);
        let reason = format!("not tried above {largest} unknowns");
        measured.reasons.push(reason);
        true
    }

    fn settings(&self) -> anyhow::Result<Solve> {
        fn value<V: Clone>(choice: &Option<super::Choice<V>>) -> Option<V> {
            choice.as_ref().and_then(|choice| choice.value.clone())
        }
        let s = &self.case.setting;
        let (inner, rule) = Inner::choose(value(&s.inner));
        let method = value(&s.method).unwrap_or_default();
        let c = value(&s.augmentation);
        Ok(Solve {
            method: method.with_parts(c, inner)?,
            inner: rule,
            krylov: value(&s.krylov),
            measure: self.study.tolerance_of,
            tolerance: s.tolerance.map_or(Solve::default().tolerance, |t| t.0),
            max_iterations: self.study.limit.iterations,
            rhs: value(&s.rhs).map(|load| load.known()),
            ..Solve::default()
        })
    }

    fn solve(
        &self,
        settings: &Solve,
        problem: &Problem,
        measured: &mut Measured,
    ) -> anyhow::Result<()> {
        let limit = &self.study.limit;
        let mut watch = Watch::within(self.stop, limit);
        let start = Instant::now();
        let mut solver = settings.set_up(problem, &mut watch)?;
        if self.is_too_large(solver.unknowns(), measured) {
            return Ok(());
        }
        // all that is before the set-up
        measured.assembly_s = Some(0.0);
        measured.mesh_s = Some((start.elapsed().as_secs_f64() - solver.setup_s()).max(0.0));
        load(&mut solver, self.case);
        let most = limit.most(solver.cost().c_app());
        solver.set_max_iterations(most);
        let solved = solver.solve(&mut watch)?;
        let (outcome, reason) = match solved.outcome {
            End::Converged => (Outcome::Converged, None),
            End::IterationLimit => limit.met(most),
            End::Stopped => limit.seconds_over(solved.iterations),
            End::Breakdown => (Outcome::Breakdown, None),
        };
        measured.residuals = watch.residuals;
        measured.sizes = Some([solved.n_u, solved.n_t, solved.n_p]);
        measured.outcome = Some(outcome);
        measured.reasons.extend(reason);
        measured.reasons.extend(solved.reason.clone());
        (measured.reasons).extend(solved.findings.iter().map(ToString::to_string));
        measured.run = Some(solved.into());
        Ok(())
    }

    /// Fills the true errors.
    fn compare(
        &self,
        problem: &Problem,
        reference: &mut Option<Reference>,
        measured: &mut Measured,
    ) {
        if reference.is_none() {
            match Reference::new(self.case, problem, self.stop) {
                Ok(new) => *reference = Some(new),
                Err(error) => {
                    let why = sentence::of(&error);
                    (measured.reasons).push(format!("no reference, errors are estimates: {why}"));
                }
            }
        }
        measured.errors = (reference.as_ref().zip(measured.run.as_ref()))
            .map(|(reference, run)| reference.errors(&run.x));
    }

    fn conditions(
        &self,
        settings: &Solve,
        prepared: &mut Prepared,
        measured: &mut Measured,
    ) -> anyhow::Result<()> {
        let asks = |names: &[Name]| names.iter().any(|name| self.names.contains(name));
        if asks(&[Name::Kernel, Name::ConditionA, Name::ConditionError]) {
            measured.stiffness = Some(prepared.stiffness()?);
        }
        let plain = asks(&[Name::ConditionSu, Name::ConditionError]);
        let wanted = [plain, asks(&[Name::ConditionScaled])];
        if let Some(c) = settings.method.augmentation() {
            measured.schur = prepared.schur(c, wanted)?;
        }
        Ok(())
    }
}

/// What the matrices say before anything is solved.
fn facts(prepared: &Prepared, measured: &mut Measured) {
    let blocks = &prepared.blocks;
    let n_p = blocks.size() - blocks.n_u() - blocks.n_t();
    measured.sizes = Some([blocks.n_u(), blocks.n_t(), n_p]);
    measured.mesh_s = Some(prepared.mesh_s);
    measured.assembly_s = Some(prepared.assembly_s);
    measured.contact = prepared.state.as_ref().map(|state| {
        let (own_rows, is_symmetric) = state.own_rows();
        Contact {
            slip: state.percent(1),
            open: state.percent(2),
            own_rows,
            is_symmetric,
            newton: state.newton,
            has_converged: state.converged,
            tension: state.tension,
            overlap: state.overlap,
        }
    });
}
