//! Where the arithmetic cannot continue.

use std::fmt;

/// Which of the two matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Factor {
    /// A.
    Operator,
    /// M.
    Preconditioner,
}

impl fmt::Display for Factor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Operator => "operator",
            Self::Preconditioner => "preconditioner",
        })
    }
}

/// Why a Krylov method gave up; iterations count from 1, and 0 is the initial residual.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Breakdown {
    /// NaN or infinity in b, x, a product or a preconditioner solve.
    #[error("{method}: NaN or infinity in iteration {iteration}")]
    NotFinite {
        /// The method.
        method: &'static str,
        /// Where.
        iteration: usize,
    },
    /// ‖b‖² overflows or underflows although every entry of b is a number.
    #[error(
        "{method}: the largest entry of b is {largest:e}, whose square leaves the range of {scalar}: scale the system"
    )]
    OutOfRange {
        /// The method.
        method: &'static str,
        /// max |b_i|.
        largest: f64,
        /// `f64` or `f32`.
        scalar: &'static str,
    },
    /// `vᵀA v ≤ 0` or `rᵀM⁻¹r ≤ 0` for a vector at hand, in a method that needs positive.
    #[error(
        "{method}: the {factor} is not positive definite (found in iteration {iteration}); gmres does not need it to be, sqmr needs symmetry only"
    )]
    NotPositiveDefinite {
        /// The method.
        method: &'static str,
        /// A or M.
        factor: Factor,
        /// Where.
        iteration: usize,
    },
    /// A scalar product that the short recurrence divides by vanished.
    #[error(
        "{method}: the short recurrence ended in iteration {iteration} because {product} = 0; gmres has no such case"
    )]
    Lanczos {
        /// The method.
        method: &'static str,
        /// Where.
        iteration: usize,
        /// The product as a formula.
        product: &'static str,
    },
    /// The recurrence ended, but the true residual no longer falls: rounding, or b outside the range of a singular A.
    #[error(
        "{method}: the true residual stays at {relative_residual:.2e}·‖b‖ after {iteration} iterations: the tolerance is below rounding, or A is singular"
    )]
    Stagnation {
        /// The method.
        method: &'static str,
        /// Where.
        iteration: usize,
        /// ‖b − A x‖₂ / ‖b‖₂ of the returned x.
        relative_residual: f64,
        /// As [`Report::smallest_ritz`](super::Report::smallest_ritz).
        smallest_ritz: Option<f64>,
    },
    /// The residual met what was asked of it or no longer falls, and no error as small as the tolerance can be shown.
    #[error(
        "{method}: after {iteration} iterations the {part} may be wrong by {error:.1e} of their norm, and rounding keeps the residual at {relative_residual:.1e}·‖b‖: with this preconditioner f64 shows no smaller error"
    )]
    Inaccurate {
        /// The method.
        method: &'static str,
        /// Where.
        iteration: usize,
        /// `displacements` or `tractions`.
        part: &'static str,
        /// What M⁻¹r and the smallest Ritz value leave possible, relative to the norm of that part.
        error: f64,
        /// ‖b − A x‖₂ / ‖b‖₂ of the returned x.
        relative_residual: f64,
    },
    /// M changes from call to call, and the method relies on a fixed one.
    #[error("{method} needs a linear preconditioner; take fgmres")]
    NonlinearPreconditioner {
        /// The method.
        method: &'static str,
    },
}

impl Breakdown {
    /// The same after so many iterations of passes before.
    #[must_use]
    pub fn after(mut self, before: usize) -> Self {
        match &mut self {
            Self::NotFinite { iteration, .. }
            | Self::NotPositiveDefinite { iteration, .. }
            | Self::Lanczos { iteration, .. }
            | Self::Stagnation { iteration, .. }
            | Self::Inaccurate { iteration, .. } => *iteration += before,
            Self::OutOfRange { .. } | Self::NonlinearPreconditioner { .. } => {}
        }
        self
    }

    /// The same where b itself was a residual, of `size` relative to the b that is reported on.
    #[must_use]
    pub fn relative_to(mut self, size: f64) -> Self {
        match &mut self {
            Self::Stagnation {
                relative_residual, ..
            }
            | Self::Inaccurate {
                relative_residual, ..
            } => *relative_residual *= size,
            Self::NotFinite { .. }
            | Self::NotPositiveDefinite { .. }
            | Self::Lanczos { .. }
            | Self::OutOfRange { .. }
            | Self::NonlinearPreconditioner { .. } => {}
        }
        self
    }

    /// Iterations done when it happened.
    pub fn iteration(&self) -> usize {
        match self {
            Self::NotFinite { iteration, .. }
            | Self::NotPositiveDefinite { iteration, .. }
            | Self::Lanczos { iteration, .. }
            | Self::Stagnation { iteration, .. }
            | Self::Inaccurate { iteration, .. } => *iteration,
            Self::OutOfRange { .. } | Self::NonlinearPreconditioner { .. } => 0,
        }
    }
}
