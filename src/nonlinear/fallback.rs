//! Preconditioners that gave way: hierarchies in f32 to f64, what cannot be set up or gets nowhere to another inner solver.

use super::{ContactProblem, Event, LinearFailure};
use crate::inner::{others, without_stagnation};
use crate::matrix_free::MatrixFreeError;
use crate::multigrid::{Geometric, GeometricInverse};
use crate::scene::RunInner;
use fracas_operators::Preconditioner;
use fracas_solvers::saddle::{AugmentationMatrix, InnerChoice, Racp};

/// What gave way since the simulation began.
#[derive(Debug, Default)]
pub(super) struct Fallbacks {
    /// Hierarchies that gave way to f64.
    pub(super) count: usize,
    /// Inner solvers that could not be set up, or got nowhere, and gave way to another.
    pub(super) inner: usize,
    /// Names of those that got nowhere: none of them is tried again in this run.
    stalled: Vec<&'static str>,
    /// One got nowhere, and no other could be set up: it goes on.
    exhausted: bool,
    /// What the step at hand has not told yet.
    pub(super) events: Vec<Event>,
    /// The hierarchy built last is in f64.
    double: bool,
    /// What was taken for the preconditioner built last, where its settings gave way.
    instead: Option<Racp>,
}

impl Fallbacks {
    /// S̃_u⁻¹ for C in Pa; where f32 gave way it is told.
    pub(super) fn build(
        &mut self,
        problem: &ContactProblem<'_>,
        geometric: Geometric,
        c: &AugmentationMatrix,
    ) -> Result<GeometricInverse, MatrixFreeError> {
        let built = GeometricInverse::new(&geometric, &problem.stick_system(), c)?;
        self.double = !built.properties().single;
        self.instead =
            (self.instead).filter(|racp| matches!(racp.inner, InnerChoice::Geometric(_)));
        if let Some(lost) = built.lost() {
            self.note(lost.to_string());
        }
        Ok(built)
    }

    /// A is another one: what could not be set up for the one before may serve.
    pub(super) fn forget(&mut self) {
        self.double = false;
        self.instead = self.instead.filter(|_| self.has_stalled());
    }

    /// f32 gave way to f64 for this reason.
    pub(super) fn note(&mut self, reason: String) {
        self.count += 1;
        self.double = true;
        self.events.push(Event::Precision { reason });
    }

    /// What takes the place of the `first` settings, in turn, where the scene leaves the choice: of geometric multigrid where the mesh has a
    /// grid, AMG and a factorization what comes behind, and of a factorization the others.
    pub(super) fn others(&self, problem: &ContactProblem<'_>, first: Racp) -> Vec<Racp> {
        let body = problem.body();
        let solver = &body.solver;
        if solver.racp.is_some() || solver.inner != RunInner::Auto {
            return Vec::new();
        }
        let others = others(first.inner, body.mesh.grid.is_some()).into_iter();
        (others.filter(|inner| !self.stalled.contains(&inner.name())))
            .map(|inner| Racp { inner, ..first })
            .collect()
    }

    /// The next of those `left` to be set up in place of what cannot be, for this reason; it is told. A factorization that has `served`
    /// before gives way to nothing: other states let a body go, and no inner solver holds it.
    ///
    /// # Errors
    /// The failure, where nothing takes their place.
    pub(super) fn instead(
        &mut self,
        left: &mut std::vec::IntoIter<Racp>,
        (first, served): (Racp, bool),
        failure: LinearFailure,
    ) -> Result<Racp, LinearFailure> {
        let stopped = matches!(failure, LinearFailure::MatrixFree(MatrixFreeError::Stopped));
        let is_over = stopped || served && matches!(first.inner, InnerChoice::Exact { .. });
        match left.next().filter(|_| !is_over) {
            Some(next) => Ok(self.take(next, failure.to_string())),
            None => Err(failure),
        }
    }

    fn take(&mut self, next: Racp, reason: String) -> Racp {
        self.inner += 1;
        self.double = false;
        self.instead = Some(next);
        let now = next.inner.name();
        self.events.push(Event::Inner { reason, now });
        next
    }

    /// What takes the place of these settings where an iteration gets nowhere with them; nothing does of a factorization.
    pub(super) fn without_stagnation(
        &self,
        problem: &ContactProblem<'_>,
        settings: Racp,
        available: Option<u64>,
    ) -> Option<Racp> {
        if self.exhausted || matches!(settings.inner, InnerChoice::Exact { .. }) {
            return None;
        }
        let left = self.others(problem, settings);
        let inners: Vec<InnerChoice> = left.iter().map(|racp| racp.inner).collect();
        let displacements = problem.body().constraints.free_len();
        let next = without_stagnation(&inners, displacements, available);
        next.ok().flatten().map(|at| left[at])
    }

    /// An iteration got nowhere with the settings at hand, and `next` takes their place; it is told.
    pub(super) fn give_way(&mut self, settings: Racp, next: Racp, reason: String) {
        self.stalled.push(settings.inner.name());
        self.take(next, reason);
    }

    /// No other could be set up: these settings serve after all.
    pub(super) fn take_back(&mut self, settings: Racp) {
        self.exhausted = true;
        self.double = false;
        self.instead = Some(settings);
    }

    /// True where some could not be set up.
    pub(super) fn lacks_digits(&self) -> bool {
        self.inner > self.stalled.len()
    }

    /// True where some got nowhere.
    pub(super) fn has_stalled(&self) -> bool {
        !self.stalled.is_empty()
    }

    /// These settings, or what was taken instead, with the precision of the hierarchy built last.
    pub(super) fn effective(&self, settings: Racp) -> Racp {
        match self.instead.unwrap_or(settings) {
            racp if self.double => racp.in_double(),
            racp => racp,
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::multigrid::GeometricError;
    use crate::scene::sample::Sample;
    use crate::scene::{Body, RunInner};

    fn body(inner: RunInner) -> Body {
        let mut body = Sample::patch().body();
        body.solver.inner = inner;
        body
    }

    fn failure() -> LinearFailure {
        MatrixFreeError::from(GeometricError::DenseC).into()
    }

    #[test]
    fn what_cannot_be_set_up_gives_way_to_all_others_once_and_says_so() {
        let body = body(RunInner::Auto);
        let problem = ContactProblem::new(&body).unwrap();
        for (first, others) in [
            (Racp::geometric(), ["amg", "exact"]),
            (Racp::default(), ["geometric", "amg"]),
        ] {
            gives_way(&problem, first, others);
        }
    }

    fn gives_way(problem: &ContactProblem<'_>, first: Racp, others: [&str; 2]) {
        let mut fallbacks = Fallbacks::default();
        let left = &mut fallbacks.others(problem, first).into_iter();
        for (k, name) in others.into_iter().enumerate() {
            let tried = (first, false);
            let settings = fallbacks.instead(left, tried, failure()).unwrap();
            assert_eq!(settings.inner.name(), name);
            assert_eq!((fallbacks.inner, fallbacks.events.len()), (k + 1, k + 1));
            let Some(Event::Inner { reason, now }) = fallbacks.events.last() else {
                panic!("{:?}", fallbacks.events);
            };
            assert_eq!((reason, *now), (&failure().to_string(), name));
            assert_eq!(fallbacks.effective(settings), settings);
        }
        let last = fallbacks.instead(left, (first, false), failure());
        assert_eq!(last.unwrap_err().to_string(), failure().to_string());
    }

    #[test]
    fn what_was_asked_for_by_name_a_factorization_that_served_and_a_stop_give_way_to_nothing() {
        for (inner, settings, failure) in [
            (RunInner::Geometric, Racp::geometric(), failure()),
            (
                RunInner::Auto,
                Racp::geometric(),
                MatrixFreeError::Stopped.into(),
            ),
            (RunInner::Auto, Racp::default(), failure()),
        ] {
            let body = body(inner);
            let problem = ContactProblem::new(&body).unwrap();
            let mut fallbacks = Fallbacks::default();
            let left = &mut fallbacks.others(&problem, settings).into_iter();
            assert!(fallbacks.instead(left, (settings, true), failure).is_err());
            assert_eq!((fallbacks.inner, fallbacks.events.len()), (0, 0));
        }
    }

    #[test]
    fn what_gets_nowhere_gives_way_to_a_factorization_that_fits_and_is_not_tried_again() {
        let auto = body(RunInner::Auto);
        let problem = ContactProblem::new(&auto).unwrap();
        let (geometric, exact) = (Racp::geometric(), Racp::default());
        let mut fallbacks = Fallbacks::default();
        let next = |fallbacks: &Fallbacks, settings, free| {
            let next = fallbacks.without_stagnation(&problem, settings, free);
            next.map(|racp| racp.inner.name())
        };
        assert_eq!(next(&fallbacks, geometric, None), Some("exact"));
        assert_eq!(next(&fallbacks, geometric, Some(1)), Some("amg"));
        assert_eq!(next(&fallbacks, exact, None), None);
        fallbacks.give_way(geometric, exact, "reason".into());
        assert_eq!(fallbacks.effective(geometric), exact);
        let names: Vec<&str> = (fallbacks.others(&problem, exact).iter())
            .map(|racp| racp.inner.name())
            .collect();
        assert_eq!(names, ["amg"]);
        assert!(fallbacks.has_stalled() && !fallbacks.lacks_digits());
        fallbacks.take_back(geometric);
        assert_eq!(fallbacks.effective(exact), geometric);
        assert_eq!(next(&fallbacks, geometric, None), None);
        let named = body(RunInner::Geometric);
        let problem = ContactProblem::new(&named).unwrap();
        let asked = Fallbacks::default().without_stagnation(&problem, geometric, None);
        assert_eq!(asked, None);
    }
}
