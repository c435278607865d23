//! Why nothing could be solved.

use super::route::NotGeometric;
use crate::elasticity::ElasticityError;
use crate::matrix_free::{MatrixFreeError, PiecesError};
use crate::memory::{NoRoom, NoRoomInDouble, TooLarge};
use crate::scene::SceneError;
use crate::undetermined::SingularScene;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::NoSuchPart;
use fracas_solvers::saddle::folder::FolderError;
use std::error::Error;

/// Why a system could not be solved; not converging is no error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// Of the settings.
    #[error("the tolerance is a number between 0 and 1, not {value}")]
    Tolerance {
        /// As given.
        value: f64,
    },
    /// Of the settings.
    #[error("the unit of tractions is a positive number, not {value}")]
    Unit {
        /// As given.
        value: f64,
    },
    /// A part that the method does not have.
    #[error(transparent)]
    Part(#[from] NoSuchPart),
    /// Geometric multigrid where it cannot be.
    #[error(transparent)]
    NotGeometric(#[from] NotGeometric),
    /// Of the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It does not fit into memory.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Tractions that nothing determines.
    #[error(transparent)]
    Singular(#[from] SingularScene),
    /// Of the system folder.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// A body without a stiffness.
    #[error("{name} cannot be assembled")]
    Assembly {
        /// The scene.
        name: String,
        /// Why.
        source: ElasticityError,
    },
    /// The same, where nothing is assembled.
    #[error("{name} cannot be solved")]
    Body {
        /// The scene.
        name: String,
        /// Why.
        source: ElasticityError,
    },
    /// A body without a stiffness, once more.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// Of the preconditioner.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// Of the preconditioner where nothing is assembled.
    #[error(transparent)]
    MatrixFree(#[from] MatrixFreeError),
    /// No iteration fits into memory.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// No second hierarchy does.
    #[error(transparent)]
    NoRoomInDouble(#[from] NoRoomInDouble),
    /// What an engine of ranks does not do.
    #[error("engine = \"petsc\" does not take {what}; {instead}")]
    NotOverRanks {
        /// What was asked.
        what: &'static str,
        /// What to do.
        instead: &'static str,
    },
    /// What went wrong on some rank.
    #[cfg(feature = "petsc")]
    #[error(transparent)]
    OnRank(#[from] fracas_solvers::distributed::OnRank),
    /// An iteration that needs a linear preconditioner.
    #[error(
        "krylov = \"{krylov}\" needs a linear preconditioner, and inner = \"{inner}\" is none; take gmres or fgmres"
    )]
    Nonlinear {
        /// The iteration.
        krylov: &'static str,
        /// The inner solver.
        inner: String,
    },
}

impl From<PiecesError> for SolveError {
    fn from(error: PiecesError) -> Self {
        match error {
            PiecesError::Setup(error) => error.into(),
            PiecesError::Elasticity(error) => error.into(),
        }
    }
}

impl SolveError {
    /// With its causes, in one line.
    pub(super) fn in_full(&self) -> String {
        let (mut text, mut cause) = (self.to_string(), self.source());
        while let Some(error) = cause {
            text = format!("{text}: {error}");
            cause = error.source();
        }
        text
    }
}
