//! Writing a system folder.

use super::announced::norms;
use super::compare::asymmetry;
use super::import::FILES;
use super::{FolderError, Manifest, SYMMETRY_TOLERANCE, coordinates};
use crate::saddle::SaddleBlocks;
use fracas_operators::matrix_market::{Symmetry, write_dense, write_sparse, write_vector};
use std::path::Path;

/// What a manifest of ours says of who wrote it.
const OURS: &str = concat!("fracas ", env!("CARGO_PKG_VERSION"));

/// Writes blocks and manifest; sizes, blocks and norms of the manifest are filled in, and the version unless it names another program.
///
/// The folder is created if needed. Files of an earlier system that this one does not have (say `H.mtx`) are removed,
/// since their presence has a meaning.
///
/// # Errors
/// [`FolderError::Asymmetric`] when A is not symmetric, else what the operating system says.
pub fn write_folder(
    folder: &Path,
    blocks: &SaddleBlocks,
    manifest: &Manifest,
) -> Result<(), FolderError> {
    if let Some(worst) = asymmetry(&blocks.a).filter(|w| w.relative > SYMMETRY_TOLERANCE) {
        let (row, column) = (worst.row + 1, worst.column + 1);
        return Err(FolderError::Asymmetric {
            file: "A",
            row,
            column,
            value: worst.x,
            mirrored: worst.y,
        });
    }
    std::fs::create_dir_all(folder).map_err(|source| FolderError::Io {
        file: folder.into(),
        source,
    })?;
    for name in FILES {
        let file = folder.join(name);
        match std::fs::remove_file(&file) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                return Err(FolderError::Io { file, source });
            }
            _ => {}
        }
    }
    let at = |name: &str| folder.join(name);
    let matrices = blocks.matrices().into_iter();
    let matrices: Vec<_> = matrices.filter_map(|(name, m)| Some((name, m?))).collect();
    let sides = blocks.right_hand_sides().into_iter();
    let sides: Vec<_> = sides.filter_map(|(name, b)| Some((name, b?))).collect();
    // A is the last, below
    for (name, block) in &matrices[1..] {
        write_sparse(&at(&format!("{name}.mtx")), block, Symmetry::General)?;
    }
    for (name, side) in &sides {
        write_vector(&at(&format!("{name}.mtx")), side)?;
    }
    if let Some(c) = &blocks.coordinates {
        write_dense(&at("coords.mtx"), &coordinates::to_table(c))?;
    }
    let mut manifest = Manifest {
        version: Some(manifest.version.clone().unwrap_or_else(|| OURS.into())),
        n_u: Some(blocks.n_u()),
        n_t: Some(blocks.n_t()),
        n_p: Some(blocks.n_p()),
        ..manifest.clone()
    };
    let names: Vec<&str> = matrices.iter().map(|(name, _)| *name).collect();
    manifest.other.insert(Manifest::BLOCKS.into(), names.into());
    let names: Vec<&str> = sides.iter().map(|(name, _)| *name).collect();
    manifest.other.insert(Manifest::SIDES.into(), names.into());
    // beyond 1e154 squares are no numbers
    let norms = norms(blocks)
        .into_iter()
        .filter(|(_, norm)| norm.is_finite());
    let norms = norms.map(|(name, norm)| (name.to_owned(), norm.into()));
    let norms = serde_json::Value::Object(norms.collect());
    manifest.other.insert(Manifest::NORMS.into(), norms);
    let file = at("manifest.json");
    let text = match one_key_a_line(&manifest) {
        Ok(text) => text,
        Err(source) => return Err(FolderError::Manifest { file, source }),
    };
    std::fs::write(&file, text).map_err(|source| FolderError::Io { file, source })?;
    // last: without it the folder is no system, so that a process that dies leaves none without its H
    Ok(write_sparse(&at("A.mtx"), &blocks.a, Symmetry::Symmetric)?)
}

/// JSON with a line per key: lists of states stay on one line.
fn one_key_a_line(manifest: &Manifest) -> Result<String, serde_json::Error> {
    let value = serde_json::to_value(manifest)?;
    let keys = value.as_object().into_iter().flatten();
    let lines: Vec<String> = keys
        .map(|(key, value)| format!("  {key:?}: {value}"))
        .collect();
    Ok(format!("{{\n{}\n}}\n", lines.join(",\n")))
}
