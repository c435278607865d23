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
    write_sparse(&at("B1.mtx"), &blocks.b1, Symmetry::General)?;
    if let Some(b2) = &blocks.b2 {
        write_sparse(&at("B2.mtx"), b2, Symmetry::General)?;
    }
    if let Some(h) = &blocks.h {
        write_sparse(&at("H.mtx"), h, Symmetry::General)?;
    }
    write_vector(&at("rhs_u.mtx"), &blocks.rhs_u)?;
    write_vector(&at("rhs_t.mtx"), &blocks.rhs_t)?;
    if let Some(flow) = &blocks.flow {
        write_sparse(&at("Q1.mtx"), &flow.q1, Symmetry::General)?;
        write_sparse(&at("Q2.mtx"), &flow.q2, Symmetry::General)?;
        write_sparse(&at("T.mtx"), &flow.t, Symmetry::General)?;
        write_vector(&at("rhs_p.mtx"), &flow.rhs_p)?;
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
    let listed = [
        ("A", true),
        ("B1", true),
        ("B2", blocks.b2.is_some()),
        ("H", blocks.h.is_some()),
        ("Q1", blocks.flow.is_some()),
        ("Q2", blocks.flow.is_some()),
        ("T", blocks.flow.is_some()),
    ];
    let listed = listed.iter().filter(|(_, is)| *is).map(|(name, _)| *name);
    let listed = listed.collect::<Vec<_>>();
    manifest
        .other
        .insert(Manifest::BLOCKS.into(), listed.into());
    let sides: &[&str] = match blocks.flow {
        Some(_) => &["rhs_u", "rhs_t", "rhs_p"],
        None => &["rhs_u", "rhs_t"],
    };
    manifest
        .other
        .insert(Manifest::SIDES.into(), sides.to_vec().into());
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
