//! What the files of scenes and systems held when rows were written.

use super::product::Case;
use crate::report::write_whole;
use crate::scenes;
use anyhow::ensure;
use fracas::io::Hash;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::Table;

const FILE: &str = "sources.toml";

/// Keys of a scene that change no row.
const WORDS: [&str; 2] = ["title", "description"];

/// Refuses a folder whose rows are of scenes or systems that are others now; notes what they hold.
///
/// # Errors
/// The name of the one that has changed; a file that cannot be written.
pub(super) fn same(cases: &[Case], out: &Path, has_rows: bool) -> anyhow::Result<()> {
    let now = digests(cases);
    let place = out.join(FILE);
    let before: BTreeMap<String, String> = match std::fs::read_to_string(&place) {
        Ok(text) if has_rows => toml::from_str(&text)?,
        _ => BTreeMap::new(),
    };
    let differs = |(name, own): &(&String, &String)| before.get(*name).is_some_and(|b| b != *own);
    let changed = now.iter().find(differs).map(|(name, _)| name);
    ensure!(
        changed.is_none(),
        "{} has changed since rows of {} were written, and they would stand beside those of what it is now; choose another --out",
        changed.map_or("", String::as_str),
        out.display()
    );
    if before != now {
        write_whole(&place, &toml::to_string(&now)?)?;
    }
    Ok(())
}

/// By name; those that cannot be read are left out, and their rows say why.
fn digests(cases: &[Case]) -> BTreeMap<String, String> {
    let settings = || cases.iter().map(|case| &case.setting);
    let scenes: BTreeSet<&String> = settings().filter_map(|s| s.scene.as_ref()).collect();
    let systems: BTreeSet<&String> = settings().filter_map(|s| s.system.as_ref()).collect();
    let scenes = scenes.into_iter().map(|name| (name, scene(name)));
    let systems = systems.into_iter().map(|name| (name, system(name)));
    let known = |(name, hash): (&String, anyhow::Result<Hash>)| {
        Some((name.clone(), hash.ok()?.to_string()))
    };
    scenes.chain(systems).filter_map(known).collect()
}

/// Of all that a scene says, tables of files among it, and of its mesh where that is a file.
fn scene(name: &str) -> anyhow::Result<Hash> {
    let mut table: Table = scenes::load(name)?.to_toml()?.parse()?;
    for key in WORDS {
        table.remove(key);
    }
    let mut hash = Hash::default();
    hash.bytes(toml::to_string(&table)?.as_bytes());
    let file = table.get("mesh").and_then(|mesh| mesh.get("file"));
    if let Some(file) = file.and_then(toml::Value::as_str) {
        hash.bytes(&std::fs::read(file)?);
    }
    Ok(hash)
}

/// Of every file of a folder.
fn system(folder: &str) -> anyhow::Result<Hash> {
    let entries = std::fs::read_dir(folder)?;
    let mut files: Vec<PathBuf> = entries
        .map(|entry| Ok(entry?.path()))
        .collect::<std::io::Result<_>>()?;
    files.retain(|file| file.is_file());
    files.sort();
    let mut hash = Hash::default();
    for file in files {
        hash.bytes(file.as_os_str().as_encoded_bytes());
        hash.bytes(&std::fs::read(file)?);
    }
    Ok(hash)
}
