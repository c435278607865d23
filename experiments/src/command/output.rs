//! Files that commands write.

use crate::report::write_whole;
use anyhow::Context;
use serde::Serialize;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Tries every file that will be written, so that a wrong path is said before the work and not after it.
pub(super) fn try_files<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> anyhow::Result<()> {
    for path in files.into_iter().filter(|path| path.as_os_str() != "-") {
        create_parent(path)?;
        let is_new = !path.exists();
        OpenOptions::new()
            .append(true)
            .create(true)
            .open(path)
            .with_context(|| cannot_write(path))?;
        if is_new {
            fs::remove_file(path).with_context(|| cannot_write(path))?;
        }
    }
    Ok(())
}

/// Creates a folder and those above it.
pub(super) fn folder(path: &Path) -> anyhow::Result<()> {
    fs::create_dir_all(path).with_context(|| cannot_create(path))
}

fn create_parent(path: &Path) -> anyhow::Result<()> {
    path.parent().map_or(Ok(()), folder)
}

/// What is said of a folder that cannot be created.
pub(super) fn cannot_create(folder: &Path) -> String {
    format!("cannot create the folder {}", folder.display())
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// True where a file is standard output.
pub(super) fn is_standard(file: &Option<PathBuf>) -> bool {
    file.as_ref().is_some_and(|path| path.as_os_str() == "-")
}

/// Writes `value` as indented JSON to a file, or to `out` for the path `-`.
pub(super) fn json(path: &Path, value: &impl Serialize, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    if path.as_os_str() == "-" {
        out.write_all(text.as_bytes())?;
        return Ok(());
    }
    file(path, &text)
}

/// Writes a file, whole or not at all, creating its folder.
pub(super) fn file(path: &Path, content: &(impl AsRef<[u8]> + ?Sized)) -> anyhow::Result<()> {
    create_parent(path)?;
    write_whole(path, content)
}

/// Two columns, aligned.
pub(super) fn pairs(out: &mut dyn Write, pairs: &[(&str, String)]) -> anyhow::Result<()> {
    let width = pairs
        .iter()
        .map(|(name, _)| name.chars().count())
        .max()
        .unwrap_or(0);
    for (name, value) in pairs {
        writeln!(out, "{name:width$}  {value}")?;
    }
    Ok(())
}
