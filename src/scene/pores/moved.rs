//! Where a file of pressures lies now.

use std::path::{Component, Path, PathBuf};

/// A file where its path says, from the folder of the scene on. Where nothing is there and a digest tells whether another one is it: what the
/// longest end of its path leads to, from that folder or the one above.
pub(in crate::scene) fn place(file: &Path, folder: &Path, has_digest: bool) -> PathBuf {
    let path = folder.join(file);
    if !has_digest || path.exists() {
        return path;
    }
    let parts = file.components();
    let parts: Vec<Component<'_>> = parts
        .filter(|c| matches!(c, Component::Normal(_)))
        .collect();
    let ends = (0..parts.len()).map(|n| parts[n..].iter().collect::<PathBuf>());
    let above = folder.join("..");
    let mut near = ends.flat_map(|end| [folder.join(&end), above.join(&end)]);
    near.find(|near| near.is_file()).unwrap_or(path)
}
