//! Preconditioners that gave way: hierarchies in f32 to f64, what cannot be set up to another inner solver.

use super::{ContactProblem, Event, LinearFailure};
use crate::matrix_free::MatrixFreeError;
use crate::multigrid::{Geometric, GeometricInverse};
use crate::scene::RunInner;
use fracas_operators::Preconditioner;
use fracas_solvers::amg::Amg;
use fracas_solvers::saddle::{AugmentationMatrix, InnerChoice, Racp};

/// What gave way since the simulation began.
#[derive(Debug, Default)]
pub(super) struct Fallbacks {
    /// Hierarchies that gave way to f64.
    pub(super) count: usize,
    /// Inner solvers that could not be set up and gave way to another.
    pub(super) inner: usize,
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

    /// A is another one: what gave way for the one before may serve.
    pub(super) fn forget(&mut self) {
        (self.double, self.instead) = (false, None);
    }

    /// f32 gave way to f64 for this reason.
    pub(super) fn note(&mut self, reason: String) {
        self.count += 1;
        self.double = true;
        self.events.push(Event::Precision { reason });
    }

    /// What is set up in place of `settings`, which cannot be for this reason, where the scene leaves the choice: in turn geometric
    /// multigrid where the mesh has a grid, AMG and a factorization, until what was tried `first` would be next. It is told.
    ///
    /// A factorization that has `served` before gives way to nothing: other states let a body go, and no inner solver holds it.
    ///
    /// # Errors
    /// The failure, where nothing takes their place.
    pub(super) fn instead(
        &mut self,
        problem: &ContactProblem<'_>,
        (first, settings, served): (Racp, Racp, bool),
        failure: LinearFailure,
    ) -> Result<Racp, LinearFailure> {
        let body = problem.body();
        let solver = &body.solver;
        let is_free = solver.racp.is_none() && solver.inner == RunInner::Auto;
        let stopped = matches!(failure, LinearFailure::MatrixFree(MatrixFreeError::Stopped));
        let is_over = stopped || served && matches!(first.inner, InnerChoice::Exact { .. });
        let next = otherwise(settings, body.mesh.grid.is_some())
            .filter(|(next, _)| is_free && !is_over && next.inner.name() != first.inner.name());
        let Some((next, now)) = next else {
            return Err(failure);
        };
        self.inner += 1;
        self.double = false;
        self.instead = Some(next);
        let reason = failure.to_string();
        self.events.push(Event::Inner { reason, now });
        Ok(next)
    }

    /// These settings, or what was taken instead, with the precision of the hierarchy built last.
    pub(super) fn effective(&self, settings: Racp) -> Racp {
        match self.instead.unwrap_or(settings) {
            racp if self.double => racp.in_double(),
            racp => racp,
        }
    }
}

/// What takes the place of these settings, and its name.
fn otherwise(settings: Racp, is_grid: bool) -> Option<(Racp, &'static str)> {
    let inner = match settings.inner {
        InnerChoice::Exact { .. } if is_grid => InnerChoice::Geometric(Geometric::default()),
        InnerChoice::Exact { .. } => InnerChoice::Amg(Amg::default()),
        InnerChoice::Geometric(_) => InnerChoice::Amg(Amg::default()),
        InnerChoice::Amg(_) => InnerChoice::default(),
        _ => return None,
    };
    Some((Racp { inner, ..settings }, inner.name()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::multigrid::GeometricError;
    use crate::scene::{Body, named};

    fn body(inner: &str) -> Body {
        let scene = named("patch").unwrap().small_scene().unwrap();
        let own = format!("solver.inner={inner}");
        scene.with_overrides(&[&own]).unwrap().build().unwrap()
    }

    fn failure() -> LinearFailure {
        MatrixFreeError::from(GeometricError::DenseC).into()
    }

    #[test]
    fn what_cannot_be_set_up_gives_way_to_all_others_once_and_says_so() {
        let body = body("auto");
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
        let mut settings = first;
        for (k, name) in others.into_iter().enumerate() {
            let tried = (first, settings, false);
            settings = fallbacks.instead(problem, tried, failure()).unwrap();
            assert_eq!(settings.inner.name(), name);
            assert_eq!((fallbacks.inner, fallbacks.events.len()), (k + 1, k + 1));
            let Some(Event::Inner { reason, now }) = fallbacks.events.last() else {
                panic!("{:?}", fallbacks.events);
            };
            assert_eq!((reason, *now), (&failure().to_string(), name));
            assert_eq!(fallbacks.effective(settings), settings);
        }
        let last = fallbacks.instead(problem, (first, settings, false), failure());
        assert_eq!(last.unwrap_err().to_string(), failure().to_string());
    }

    #[test]
    fn what_was_asked_for_by_name_a_factorization_that_served_and_a_stop_give_way_to_nothing() {
        for (inner, settings, failure) in [
            ("geometric", Racp::geometric(), failure()),
            ("auto", Racp::geometric(), MatrixFreeError::Stopped.into()),
            ("auto", Racp::default(), failure()),
        ] {
            let body = body(inner);
            let problem = ContactProblem::new(&body).unwrap();
            let mut fallbacks = Fallbacks::default();
            let tried = (settings, settings, true);
            assert!(fallbacks.instead(&problem, tried, failure).is_err());
            assert_eq!((fallbacks.inner, fallbacks.events.len()), (0, 0));
        }
    }
}
