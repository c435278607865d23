//! A sheared block that `fracas run` takes through twelve steps, and the folder that this leaves.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use crate::run::{Ran, fracas, scratch, write};
use std::fs;
use std::path::{Path, PathBuf};

/// Two blocks of rock, pressed together and sheared along an embedded fracture until it slips from its middle.
pub(crate) const SCENE: &str = include_str!("../sheared_block.toml");

/// Rows of the history: time 0, ten steps and the corner of the load at 7 h between two of them.
pub(crate) const ROWS: usize = 12;

/// A fresh folder with the scene in it.
pub(crate) fn scene(name: &str) -> (PathBuf, String) {
    let folder = scratch(&format!("output-{name}"));
    let file = folder.join("scene.toml");
    write(&file, SCENE);
    (folder, file.display().to_string())
}

/// `fracas run SCENE --out OUT MORE`.
pub(crate) fn run(scene: &str, out: &Path, more: &[&str]) -> Ran {
    let out = out.display().to_string();
    fracas(&[&["run", scene, "--out", &out][..], more].concat())
}

/// It came to its end.
pub(crate) fn done(ran: &Ran) {
    assert_eq!(ran.status, 0, "{}", ran.stderr);
}

/// The text of a file.
pub(crate) fn read(path: impl AsRef<Path>) -> String {
    let path = path.as_ref();
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Names in a folder that match a beginning and an end, sorted.
pub(crate) fn names(folder: &Path, begin: &str, end: &str) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| n.starts_with(begin) && n.ends_with(end))
        .collect();
    names.sort();
    names
}
