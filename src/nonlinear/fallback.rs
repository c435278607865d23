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
        self.instead = None;
        if let Some(lost) = built.lost() {
            self.note(lost.to_string());
        }
        Ok(built)
    }

    /// f32 gave way to f64 for this reason.
    pub(super) fn note(&mut self, reason: String) {
        self.count += 1;
        self.double = true;
        self.events.push(Event::Precision { reason });
    }

    /// What is set up in place of `settings`, which cannot be for this reason, where the scene leaves the choice: AMG, then a
    /// factorization. It is told.
    ///
    /// # Errors
    /// The failure, where nothing takes their place.
    pub(super) fn instead(
        &mut self,
        problem: &ContactProblem<'_>,
        settings: Racp,
        failure: LinearFailure,
    ) -> Result<Racp, LinearFailure> {
        let solver = &problem.body().solver;
        let is_free = solver.racp.is_none() && solver.inner == RunInner::Auto;
        let stopped = matches!(failure, LinearFailure::MatrixFree(MatrixFreeError::Stopped));
        let Some((next, now)) = otherwise(settings).filter(|_| is_free && !stopped) else {
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
fn otherwise(settings: Racp) -> Option<(Racp, &'static str)> {
    let inner = match settings.inner {
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
    fn what_cannot_be_set_up_gives_way_to_amg_then_to_a_factorization_and_says_so() {
        let body = body("auto");
        let problem = ContactProblem::new(&body).unwrap();
        let mut fallbacks = Fallbacks::default();
        let mut settings = Racp::geometric();
        for (k, name) in ["amg", "exact"].into_iter().enumerate() {
            settings = fallbacks.instead(&problem, settings, failure()).unwrap();
            assert_eq!(settings.inner.name(), name);
            assert_eq!((fallbacks.inner, fallbacks.events.len()), (k + 1, k + 1));
            let Some(Event::Inner { reason, now }) = fallbacks.events.last() else {
                panic!("{:?}", fallbacks.events);
            };
            assert_eq!((reason, *now), (&failure().to_string(), name));
            assert_eq!(fallbacks.effective(settings), settings);
        }
        let last = fallbacks.instead(&problem, settings, failure());
        assert_eq!(last.unwrap_err().to_string(), failure().to_string());
    }

    #[test]
    fn what_was_asked_for_by_name_and_a_stop_give_way_to_nothing() {
        let settings = Racp::geometric();
        for (inner, failure) in [
            ("geometric", failure()),
            ("auto", MatrixFreeError::Stopped.into()),
        ] {
            let body = body(inner);
            let problem = ContactProblem::new(&body).unwrap();
            let mut fallbacks = Fallbacks::default();
            assert!(fallbacks.instead(&problem, settings, failure).is_err());
            assert_eq!((fallbacks.inner, fallbacks.events.len()), (0, 0));
        }
    }
}
