//! Scenes on the command line: a TOML file, or a name of the gallery, with values replaced.

use crate::scenes;
use clap::Args;
use fracas::scene::Scene;

/// Replacements of values in a scene.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct Overrides {
    /// Replaces a value of the scene, for example mesh.x.cells=8; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

impl Overrides {
    /// As they were given.
    pub(super) fn texts(&self) -> &[String] {
        &self.set
    }

    /// Of a system folder there is nothing to replace.
    ///
    /// # Errors
    /// Where something was given.
    pub(super) fn are_none(&self) -> anyhow::Result<()> {
        match self.set.first() {
            None => Ok(()),
            Some(set) => anyhow::bail!(
                "--set {set} has no effect on a system folder, which has no keys of a scene"
            ),
        }
    }
}

/// Reads a scene: whatever ends in `.toml` or exists is a file, the rest are names.
pub(super) fn load(name: &str, overrides: &Overrides) -> anyhow::Result<Scene> {
    Ok(scenes::load(name)?.with_overrides(&overrides.set)?)
}
