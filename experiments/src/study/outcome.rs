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
    /// Nothing was to be solved, and everything else is known.
    Measured,
    /// Above the unknowns that it may have.
    NotTried,
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
            Self::Converged => "converged",
            Self::Measured => "measured",
            Self::NotTried => NOT_TRIED,
            Self::IterationLimit => "iteration_limit",
            Self::CostLimit => "cost_limit",
            Self::Memory => "memory",
            Self::NotApplicable => "not_applicable",
            Self::Breakdown => "breakdown",
            Self::BadInput => "bad_input",
        })
    }
}

/// Words of a row with what it was to bring.
pub(super) const GOOD: [&str; 2] = ["converged", "measured"];

/// The word of a row that nobody tried.
pub(super) const NOT_TRIED: &str = "not_tried";

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
            _ => match error.downcast_ref() {
                Some(error) => Self::of_set_up(error),
                None if error.is::<MatrixFreeError>() => Self::NotApplicable,
                None => Self::BadInput,
            },
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
