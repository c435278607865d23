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
    fs::create_dir_all(path).with_context(|| format!("cannot create the folder {}", path.display()))
}

/// A folder that goes again where nothing was written into it, with those above it that were made for it.
#[derive(Debug)]
pub(super) struct Folder {
    /// Made by us, deepest first.
    made: Vec<PathBuf>,
}

impl Folder {
    /// Creates a folder and those above it.
    pub(super) fn create(path: &Path) -> anyhow::Result<Self> {
        let new = path.ancestors().take_while(|folder| !folder.exists());
        let made = new.map(Path::to_path_buf).collect();
        let created = Self { made };
        folder(path)?;
        Ok(created)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // the first that holds something refuses to go, and so do those above it
        for folder in &self.made {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

fn create_parent(path: &Path) -> anyhow::Result<()> {
    path.parent().map_or(Ok(()), folder)
}

fn cannot_write(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// Writes `value` as indented JSON to a file, or to `out` for the path `-`.
pub(super) fn json(path: &Path, value: &impl Serialize, out: &mut dyn Write) -> anyhow::Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    if path.as_os_str() == "-" {
        out.write_all(text.as_bytes())?;
        return Ok(());
    }
    self::text(path, &text)
}

/// Writes a file, whole or not at all, creating its folder.
pub(super) fn text(path: &Path, text: &str) -> anyhow::Result<()> {
    create_parent(path)?;
    write_whole(path, text)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_stays_empty_goes_with_those_made_for_it() {
        let base = std::env::temp_dir().join(format!("fracas-folder-{}", std::process::id()));
        fs::create_dir_all(&base).unwrap();
        let deep = base.join("a/b");
        drop(Folder::create(&deep).unwrap());
        assert!(base.is_dir() && !base.join("a").exists());
        let kept = Folder::create(&deep).unwrap();
        fs::write(base.join("a/file"), "").unwrap();
        drop(kept);
        assert!(base.join("a/file").is_file() && !deep.exists());
        // one that was there before is not ours
        drop(Folder::create(&base).unwrap());
        fs::remove_file(base.join("a/file")).unwrap();
        drop(Folder::create(&base.join("a")).unwrap());
        assert!(base.join("a").is_dir());
        fs::remove_dir_all(&base).unwrap();
    }
}
