//! From settings and a problem to a solver that is ready.

use super::{Finding, InnerRule, Problem, RightHandSide, Route, Solve, SolveError, Solver};
use fracas_solvers::Observer;
use fracas_solvers::saddle::SaddleMethod;

/// A set-up on its way.
pub(super) struct SetUp<'a> {
    pub(super) settings: &'a Solve,
    pub(super) problem: &'a Problem,
    /// What takes the place of an inner solver that cannot be set up, in turn.
    pub(super) otherwise: std::vec::IntoIter<SaddleMethod>,
    pub(super) findings: Vec<Finding>,
    /// Inner solvers that could not be set up, or got nowhere.
    pub(super) replaced: usize,
    pub(super) observer: &'a mut dyn Observer,
}

/// Everything before the iteration.
pub(super) fn set_up(
    settings: &Solve,
    problem: &Problem,
    observer: &mut dyn Observer,
) -> Result<Solver, SolveError> {
    let Route {
        method,
        reason,
        otherwise,
    } = settings.route(problem)?;
    let mut set_up = SetUp {
        settings,
        problem,
        otherwise: otherwise.into_iter(),
        findings: Vec::new(),
        replaced: 0,
        observer,
    };
    if problem.has_own_solver() {
        set_up.found(Finding::OfRuns);
    }
    if let Some(reason) = reason {
        set_up.found(Finding::Inner { reason });
    }
    set_up.by(method)
}

impl SetUp<'_> {
    /// Whether an inner solver with which the iteration gets nowhere gives way: one that nobody asked for.
    pub(super) fn gives_way(&self) -> bool {
        self.settings.inner == InnerRule::Auto || self.replaced > 0
    }

    /// By this method: without an assembled A, or with one.
    pub(super) fn by(self, method: SaddleMethod) -> Result<Solver, SolveError> {
        match (method.matrix_free(), self.problem) {
            (Some(racp), Problem::Body(body)) => self.matrix_free(body, racp),
            _ => self.assembled(method),
        }
    }

    /// Keeps a finding and tells it.
    pub(super) fn found(&mut self, finding: Finding) {
        self.observer.say(&finding);
        self.findings.push(finding);
    }

    /// What takes the place of an inner solver whose set-up failed; it is told and counted.
    ///
    /// # Errors
    /// The failure, where nothing takes its place.
    pub(super) fn instead(&mut self, failure: SolveError) -> Result<SaddleMethod, SolveError> {
        let Some(next) = self.otherwise.next() else {
            return Err(failure);
        };
        let name = next.inner().map(|inner| inner.to_string());
        self.found(Finding::Instead {
            inner: name.unwrap_or_default(),
            failure: failure.in_full(),
        });
        self.replaced += 1;
        Ok(next)
    }

    /// The right-hand side that was asked for, `own` being that of the system.
    pub(super) fn right_hand_side(
        &mut self,
        has_rhs: bool,
        own: Vec<f64>,
    ) -> (RightHandSide, Vec<f64>) {
        let chosen = self.settings.rhs.unwrap_or(match has_rhs {
            true => RightHandSide::System,
            false => RightHandSide::Sin,
        });
        if self.settings.rhs.is_none() && !has_rhs {
            self.observer
                .say(&"the system has no right-hand side: taking b_i = sin(i), i = 1…n");
        }
        (chosen, chosen.entries(own))
    }
}
