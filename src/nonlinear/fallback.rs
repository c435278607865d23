//! Hierarchies that were to be in f32 and are in f64.

use super::{ContactProblem, Event, RunPreconditioner};
use crate::matrix_free::{MatrixFreeError, MatrixFreeRacp};
use crate::multigrid::GeometricInverse;
use fracas_operators::Preconditioner;
use fracas_solvers::saddle::AugmentationMatrix;

/// What f32 could not hold since the simulation began.
#[derive(Debug, Default)]
pub(super) struct Fallbacks {
    /// Hierarchies that gave way to f64.
    pub(super) count: usize,
    /// What the step at hand has not told yet.
    pub(super) events: Vec<Event>,
    /// The hierarchy built last is in f64.
    double: bool,
}

impl Fallbacks {
    /// S̃_u⁻¹ for C in Pa; where f32 gave way it is told.
    pub(super) fn build(
        &mut self,
        problem: &ContactProblem<'_>,
        racp: MatrixFreeRacp,
        c: &AugmentationMatrix,
    ) -> Result<GeometricInverse, MatrixFreeError> {
        let built = racp.inner.build(&problem.stick_system(), c)?;
        self.double = !built.is_single();
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

    /// These settings with the precision of the hierarchy built last.
    pub(super) fn effective(&self, settings: RunPreconditioner) -> RunPreconditioner {
        match settings {
            RunPreconditioner::MatrixFree(racp) if self.double => {
                RunPreconditioner::MatrixFree(racp.in_double())
            }
            RunPreconditioner::Assembled(racp) if self.double => {
                RunPreconditioner::Assembled(racp.in_double())
            }
            asked => asked,
        }
    }
}
