//! Memory of the iterations of a run.

use super::LinearFailure;
use super::fallback::Fallbacks;
use fracas_operators::Preconditioner;
use fracas_solvers::krylov::{Criteria, Fitted, KrylovChoice, KrylovMethod, System};

/// Memory that can still be taken [bytes], where the system tells.
pub type FreeMemory = fn() -> Option<u64>;

/// Share of the free memory that the vectors of an iteration may take: a preconditioner of other states, as large as the one at
/// hand, and the fields have the rest. Unit: 1.
const SHARE: f64 = 0.5;

/// What the linear systems of a run share, be they of multipliers or of springs.
#[derive(Debug, Default)]
pub(super) struct Resources {
    pub(super) work: Workspace,
    pub(super) fallbacks: Fallbacks,
}

/// Scratch that serves every linear system of a run.
///
/// It is asked of the system as zeros, which most systems make up page by page as they are touched: a basis of 100 steps that ends
/// after ten takes the memory of ten.
#[derive(Debug)]
pub(super) struct Workspace {
    numbers: Vec<f64>,
    free: FreeMemory,
    /// Vectors that fit, as the first system found: the iteration is the same from step to step.
    vectors: Option<usize>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self::limited_by(|| None)
    }
}

impl Workspace {
    /// Takes no more than fits into `free`; without a limit where that is `None`.
    pub(super) fn limited_by(free: FreeMemory) -> Self {
        Self {
            numbers: Vec::new(),
            free,
            vectors: None,
        }
    }

    /// Vectors of the length of the system that fit beside the scratch of its preconditioner.
    pub(super) fn vectors(&mut self, preconditioner: &dyn Preconditioner<f64>) -> usize {
        *self.vectors.get_or_insert_with(|| {
            let n = preconditioner.size().max(1);
            let fit = |free: u64| (SHARE * free as f64 / (8.0 * n as f64)) as usize;
            let scratch = preconditioner.work_len().div_ceil(n);
            (self.free)()
                .map_or(usize::MAX, fit)
                .saturating_sub(scratch)
        })
    }

    /// Memory that can still be taken [bytes], where there is a limit.
    pub(super) fn available(&self) -> Option<u64> {
        (self.free)()
    }

    /// Scratch for `method`, of arbitrary content.
    pub(super) fn of(
        &mut self,
        method: &dyn KrylovMethod<f64>,
        system: &System<'_, f64>,
        criteria: &Criteria,
    ) -> &mut [f64] {
        let needed = method.work_len(system, criteria);
        if self.numbers.len() < needed {
            // given back before more is taken, and not filled: `resize` would touch all of it
            self.numbers = Vec::new();
            self.numbers = vec![0.0; needed];
        }
        &mut self.numbers[..needed]
    }
}

/// The iteration for which `vectors` suffice, for a matrix that is `symmetric` or not.
///
/// # Errors
/// [`LinearFailure::NoRoom`] where not even a short one does.
pub(super) fn fitted(
    vectors: usize,
    symmetric: bool,
    preconditioner: &dyn Preconditioner<f64>,
) -> Result<Fitted, LinearFailure> {
    let n = preconditioner.size();
    let fitted = KrylovChoice::fitted(vectors, symmetric, preconditioner);
    fitted.ok_or(LinearFailure::NoRoom { vectors, n })
}
