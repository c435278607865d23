//! What is asked of a run: plain data.

use super::{RunError, RunFolder};
use crate::scene::Scene;
use fracas_solvers::Observer;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// How a scene is run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Run {
    /// Folder of the results, which must be empty; by default that of the checkpoint, or `out`.
    pub out: Option<PathBuf>,
    /// Goes on from a checkpoint: a file, or the folder of a run for its last one.
    pub restart: Option<PathBuf>,
    /// Stops after so many steps; step 0, the equilibrium at time 0, counts as one.
    pub steps: Option<usize>,
    /// Writes fields for ParaView every so many steps and at the end.
    pub fields_every: usize,
    /// Fills the column `wall_s` of `history.csv`, which then differs from run to run.
    pub clock: bool,
}

impl Default for Run {
    fn default() -> Self {
        Self {
            out: None,
            restart: None,
            steps: None,
            fields_every: 1,
            clock: false,
        }
    }
}

impl Run {
    /// Takes the folder, meshes the scene and reads the checkpoint; `name` is what messages call the scene.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn open(
        self,
        name: &str,
        scene: Scene,
        observer: &mut dyn Observer,
    ) -> Result<RunFolder, RunError> {
        RunFolder::open(self, name, scene, observer)
    }
}
