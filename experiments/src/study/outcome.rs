//! How a row ended, in a word.

use fracas::matrix_free::MatrixFreeError;
use fracas::solve::SolveError;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::NoSuchPart;
use std::fmt;

/// How a row ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Converged,
    /// Not within the iterations allowed.
    IterationLimit,
    /// Not within the products or seconds allowed.
    CostLimit,
    /// It does not fit.
    Memory,
    /// The method does not exist for this system.
    NotApplicable,
    /// Arithmetic gave up.
    Breakdown,
    /// The scene or the folder is wrong.
    BadInput,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => CONVERGED,
            Self::IterationLimit => "iteration_limit",
            Self::CostLimit => "cost_limit",
            Self::Memory => "memory",
            Self::NotApplicable => "not_applicable",
            Self::Breakdown => "breakdown",
            Self::BadInput => "bad_input",
        })
    }
}

/// The word of a row with a solution.
pub(super) const CONVERGED: &str = "converged";

impl Outcome {
    /// Of a row that came to no iteration.
    pub(super) fn of_error(error: &anyhow::Error) -> Self {
        if error.is::<NoSuchPart>() {
            return Self::NotApplicable;
        }
        match error.downcast_ref() {
            Some(
                SolveError::TooLarge(_) | SolveError::NoRoom(_) | SolveError::NoRoomInDouble(_),
            ) => Self::Memory,
            Some(
                SolveError::Part(_)
                | SolveError::NotGeometric(_)
                | SolveError::Nonlinear { .. }
                | SolveError::MatrixFree(
                    MatrixFreeError::Augmentation(_)
                    | MatrixFreeError::Geometric(_)
                    | MatrixFreeError::NotGeometric { .. },
                ),
            ) => Self::NotApplicable,
            // only a limit of time stops a set-up: the wish to stop leaves no row
            Some(SolveError::MatrixFree(MatrixFreeError::Stopped)) => Self::CostLimit,
            Some(SolveError::Setup(error)) => Self::of_set_up(error),
            _ => Self::BadInput,
        }
    }

    fn of_set_up(error: &SetupError) -> Self {
        match error {
            SetupError::OutOfMemory { .. } => Self::Memory,
            SetupError::NotFinite { .. } | SetupError::Shape { .. } => Self::BadInput,
            _ => Self::NotApplicable,
        }
    }
}
