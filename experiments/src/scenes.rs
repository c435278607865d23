//! Scenes by file or by name.

use fracas::scene::{GalleryScene, Scene, gallery, named};
use std::path::Path;

/// Behind the name of a scene of the gallery: its version of a few hundred to a few thousand unknowns.
pub(crate) const SMALL: &str = ":small";

/// Neither a file nor a name.
#[derive(Debug, thiserror::Error)]
#[error("no scene file and no scene of the gallery is called `{name}`{}; `fracas list` shows the gallery", nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)")))]
struct UnknownScene {
    name: String,
    nearest: Option<&'static str>,
}

/// Whatever ends in `.toml` or exists is a file, the rest are names.
pub(crate) fn is_file(name: &str) -> bool {
    let path = Path::new(name);
    let is_toml = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    is_toml || path.is_file()
}

/// Reads a scene file, or a scene of the gallery.
///
/// # Errors
/// A name that is neither; what is wrong with the file.
pub fn load(name: &str) -> anyhow::Result<Scene> {
    if is_file(name) {
        return Ok(Scene::load(name)?);
    }
    let (plain, is_small) = match name.strip_suffix(SMALL) {
        Some(plain) => (plain, true),
        None => (name, false),
    };
    let found = of_gallery(plain)?;
    Ok(match is_small {
        true => found.small_scene()?,
        false => found.scene()?,
    })
}

/// A scene on a grid of so many cells along x, y and z.
///
/// # Errors
/// A grid that does not fit its fractures.
pub(crate) fn with_cells(scene: &Scene, cells: [usize; 3]) -> anyhow::Result<Scene> {
    let axes = ["x", "y", "z"].iter().zip(cells);
    let sets = axes.map(|(axis, cells)| format!("mesh.{axis}.cells={cells}"));
    Ok(scene.with_overrides(&sets.collect::<Vec<_>>())?)
}

/// A scene of the gallery.
pub(crate) fn of_gallery(name: &str) -> anyhow::Result<&'static GalleryScene> {
    let unknown = || UnknownScene {
        name: name.into(),
        nearest: nearest(name),
    };
    Ok(named(name).ok_or_else(unknown)?)
}

fn nearest(name: &str) -> Option<&'static str> {
    let distance = |known: &&str| strsim::damerau_levenshtein(known, name);
    gallery()
        .iter()
        .map(|s| s.name)
        .min_by_key(distance)
        .filter(|known| distance(known) <= known.len() / 3)
}
