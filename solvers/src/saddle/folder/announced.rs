//! The manifest held against the files.

use super::{FolderError, Manifest};
use crate::saddle::SaddleBlocks;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::norm2;
use std::path::Path;

/// Difference of norms, relative to them, that sums in another order may make. Unit: 1.
const SAME: f64 = 1e-10;

/// Stops where the manifest contradicts the files: sizes, norms, states, blocks that it lists and that are lost, or that its list leaves out and
/// that are there, right-hand sides that it lists and that are lost, a stabilization that
/// it says and that is lost, or that it denies and that is there; and where a list is empty beside files of its sort. An H of zeros contradicts
/// nothing.
pub(super) fn contradictions(
    folder: &Path,
    manifest: &Manifest,
    blocks: &SaddleBlocks,
    exists: &dyn Fn(&str) -> Result<bool, FolderError>,
) -> Result<(), FolderError> {
    for (key, says, found, file) in [
        ("n_u", manifest.n_u, blocks.n_u(), "A.mtx"),
        ("n_t", manifest.n_t, blocks.n_t(), "B1.mtx"),
        (
            "n_p",
            manifest.n_p,
            blocks.n_p(),
            if blocks.flow.is_some() {
                "T.mtx"
            } else {
                "a folder without T.mtx"
            },
        ),
    ] {
        if let Some(announced) = says.filter(|n| *n != found) {
            return Err(FolderError::Announced {
                key,
                announced,
                found,
                file,
            });
        }
    }
    states(manifest, blocks.n_t())?;
    empty_lists(folder, manifest, exists)?;
    let count = |m: &SparseMatrix<f64>| m.data().iter().filter(|v| **v != 0.0).count();
    // without A and B1 there is no system
    let [_, _, optional @ ..] = blocks.matrices();
    for (name, _) in optional {
        let file = format!("{name}.mtx");
        if manifest.lists(name) == Some(true) && !exists(&file)? {
            return Err(FolderError::Lost {
                says: manifest.said(Manifest::BLOCKS),
                file,
            });
        }
    }
    for name in manifest.names(Manifest::SIDES).into_iter().flatten() {
        let file = format!("{name}.mtx");
        if !exists(&file)? {
            return Err(FolderError::Lost {
                says: manifest.said(Manifest::SIDES),
                file,
            });
        }
    }
    numbers(manifest, blocks, exists)?;
    for (name, block) in optional {
        let entries = block.map_or(0, count);
        if manifest.leaves_out(name) && entries > 0 {
            return Err(FolderError::Unannounced {
                says: manifest.said(Manifest::BLOCKS),
                file: format!("{name}.mtx"),
                entries,
            });
        }
    }
    let entries = blocks.h.as_ref().map_or(0, count);
    // rows of slip and opening have entries of H without a stabilization
    let sticks = (manifest.states.iter().flatten()).all(|state| *state == 0);
    match manifest.is_stabilized()? {
        Some(true) if manifest.lists("H").is_none() && !exists("H.mtx")? => {
            Err(FolderError::Lost {
                says: manifest.said(Manifest::STABILIZATION),
                file: "H.mtx".into(),
            })
        }
        Some(false) if entries > 0 && sticks => Err(FolderError::Unannounced {
            says: manifest.said(Manifest::STABILIZATION),
            file: "H.mtx".into(),
            entries,
        }),
        _ => Ok(()),
    }
}

/// Frobenius norms of the blocks and of the right-hand sides that are there, by name.
pub(super) fn norms(blocks: &SaddleBlocks) -> Vec<(&'static str, f64)> {
    let matrices = blocks.matrices();
    let matrices = matrices.map(|(name, block)| (name, block.map(|block| norm2(block.data()))));
    let sides = blocks.right_hand_sides();
    let sides = sides.map(|(name, side)| (name, side.map(norm2)));
    let all = matrices.into_iter().chain(sides);
    all.filter_map(|(name, norm)| Some((name, norm?))).collect()
}

/// The numbers of a file are those that were written beside the manifest, as far as their norm tells. What the import leaves out, as an H of
/// zeros or a B2 that is B1ᵀ, has the norm of what it stands for.
fn numbers(
    manifest: &Manifest,
    blocks: &SaddleBlocks,
    exists: &dyn Fn(&str) -> Result<bool, FolderError>,
) -> Result<(), FolderError> {
    let mut all = norms(blocks);
    for (name, is_left_out, norm) in [
        ("H", blocks.h.is_none(), 0.0),
        ("B2", blocks.b2.is_none(), norm2(blocks.b1.data())),
    ] {
        if is_left_out {
            all.push((name, norm));
        }
    }
    let said = manifest.norms()?;
    for (name, found) in all {
        let says = said.iter().find(|(said, _)| said == name);
        let Some(&(_, says)) = says.filter(|_| found.is_finite()) else {
            continue;
        };
        let file = format!("{name}.mtx");
        if !exists(&file)? {
            return Err(FolderError::Lost {
                says: format!("{}.{name} = {says:e}", Manifest::NORMS),
                file,
            });
        }
        if (says - found).abs() > SAME * found {
            return Err(FolderError::Norm {
                file,
                says,
                found,
                scene: manifest.scene.clone(),
            });
        }
    }
    Ok(())
}

/// A list without names tells nothing of the files that are there.
fn empty_lists(
    folder: &Path,
    manifest: &Manifest,
    exists: &dyn Fn(&str) -> Result<bool, FolderError>,
) -> Result<(), FolderError> {
    let sides = ["rhs_u.mtx", "rhs_t.mtx", "rhs_p.mtx"];
    // no folder is one without A
    for (key, files) in [
        (Manifest::BLOCKS, &["A.mtx"][..]),
        (Manifest::SIDES, &sides),
    ] {
        if manifest.names(key).is_none_or(|names| !names.is_empty()) {
            continue;
        }
        for file in files {
            if exists(file)? {
                return Err(FolderError::EmptyList {
                    folder: folder.into(),
                    key,
                    file,
                });
            }
        }
    }
    Ok(())
}

/// A state per face: n_t/3 of them in systems of ours, one for every one, two or three tractions elsewhere.
fn states(manifest: &Manifest, n_t: usize) -> Result<(), FolderError> {
    let Some(states) = &manifest.states else {
        return Ok(());
    };
    if let Some(face) = states.iter().position(|state| *state > 3) {
        return Err(FolderError::State {
            face: face + 1,
            state: states[face],
        });
    }
    let (per_face, expected): (&[usize], _) = if manifest.is_ours() {
        (&[3], "a state per face of three tractions")
    } else {
        (
            &[1, 2, 3],
            "a state per face of one, two or three tractions",
        )
    };
    if per_face.iter().any(|k| k * states.len() == n_t) {
        return Ok(());
    }
    Err(FolderError::States {
        states: states.len(),
        n_t,
        expected,
    })
}

#[cfg(test)]
mod tests;
