//! Why a run cannot begin, or its folder not be written.

use super::lines::Unreadable;
use super::lock::Busy;
use super::tree::Refused;
use crate::elasticity::ElasticityError;
use crate::io::CheckpointError;
use crate::memory::TooLarge;
use crate::nonlinear::SimulationError;
use crate::scene::SceneError;
use crate::undetermined::SingularScene;
use std::io;
use std::path::{Path, PathBuf};

/// Why a run cannot begin, or its folder not be written; a step that fails is no error.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Of the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// It does not fit into memory.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
    /// Memory for the vectors of a step is not there; the state before it is written.
    #[error("out of memory: {reason}")]
    NoRoom {
        /// Step and sizes.
        reason: String,
    },
    /// Tractions that nothing determines.
    #[error(transparent)]
    Singular(#[from] SingularScene),
    /// Of the checkpoint that was asked for, or of the folder's own.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// A checkpoint behind the end of the scene.
    #[error(
        "the checkpoint stands at {time} s, after the end of the scene at {end} s: give a later time.end, or an earlier checkpoint"
    )]
    Beyond {
        /// Of the checkpoint [s].
        time: f64,
        /// Of the scene [s].
        end: f64,
    },
    /// A folder whose run has begun.
    #[error("the run in {path} has begun: open it again with restart = {path} to go on", path = path.display())]
    Begun {
        /// The folder.
        path: PathBuf,
    },
    /// A body that cannot be stepped.
    #[error("{name} cannot be run")]
    Simulation {
        /// The scene.
        name: String,
        /// Why.
        source: SimulationError,
    },
    /// A mesh without stresses.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// A folder that is not free, or not that of the checkpoint.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// Another process at work in the folder.
    #[error(transparent)]
    Busy(#[from] Busy),
    /// A file that is not ours.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// What the file system says.
    #[error("{doing} {}", path.display())]
    File {
        /// `cannot write`, …
        doing: &'static str,
        /// File or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Values without a JSON form.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// Values without a TOML form.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
    /// A scene that does not read back.
    #[error(transparent)]
    Unread(#[from] toml::de::Error),
}

/// Adds the place to what the file system says.
pub(super) trait At<T> {
    fn at(self, doing: &'static str, path: &Path) -> Result<T, RunError>;
}

impl<T> At<T> for io::Result<T> {
    fn at(self, doing: &'static str, path: &Path) -> Result<T, RunError> {
        self.map_err(|source| RunError::File {
            doing,
            path: path.into(),
            source,
        })
    }
}
