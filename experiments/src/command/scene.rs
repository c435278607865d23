//! Scenes on the command line: a TOML file, or a name of the gallery, with values replaced.

use clap::Args;
use fracas::scene::{Scene, gallery, named};
use std::path::Path;

/// Replacements of values in a scene.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct Overrides {
    /// Replaces a value of the scene, for example mesh.x.cells=8; may be repeated.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Neither a file nor a name.
#[derive(Debug, thiserror::Error)]
#[error("no scene file and no scene of the gallery is called `{name}`{}; `fracas list` shows the gallery", nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)")))]
struct UnknownScene {
    name: String,
    nearest: Option<&'static str>,
}

/// Reads a scene: whatever ends in `.toml` or exists is a file, the rest are names.
pub(super) fn load(name: &str, overrides: &Overrides) -> anyhow::Result<Scene> {
    let is_toml = Path::new(name)
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let scene = if is_toml || Path::new(name).is_file() {
        Scene::load(name)?
    } else {
        named(name)
            .ok_or_else(|| UnknownScene {
                name: name.into(),
                nearest: nearest(name),
            })?
            .scene()?
    };
    Ok(scene.with_overrides(&overrides.set)?)
}

fn nearest(name: &str) -> Option<&'static str> {
    let distance = |known: &&str| strsim::damerau_levenshtein(known, name);
    gallery()
        .iter()
        .map(|s| s.name)
        .min_by_key(distance)
        .filter(|known| distance(known) <= known.len() / 3)
}
