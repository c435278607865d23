//! States on disk, to the last bit: what a run goes on from.

use super::fingerprint::{Fingerprint, Hash};
use super::write_atomically;
use crate::contact::ContactState;
use crate::nonlinear::{Prepared, State};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// First bytes of every checkpoint.
const MAGIC: [u8; 8] = *b"fracasCK";

/// Layout of what follows: another number, another layout.
const VERSION: u64 = 3;

/// Words of eight bytes before the arrays: magic, version, length of the file, mesh, scene, step, time, loaded, next, force,
/// traction, norms of u and t, krylov, n_u, faces.
const HEADER: usize = 16;

/// Code of a face where no preconditioner is kept.
const NOT_PREPARED: u8 = u8::MAX;

/// Checkpoints that stay in a folder.
const KEPT: usize = 2;

/// A checkpoint that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file system says no.
    #[error("cannot read the checkpoint {}: {source}", path.display())]
    Read {
        /// File or folder.
        path: PathBuf,
        /// Reason.
        source: io::Error,
    },
    /// A folder without any.
    #[error("{} holds no checkpoint", path.display())]
    None {
        /// Folder.
        path: PathBuf,
    },
    /// Another kind of file.
    #[error("{} is no checkpoint of fracas", path.display())]
    Foreign {
        /// File.
        path: PathBuf,
    },
    /// Written by another version.
    #[error("the checkpoint {} has layout {found}, this program reads layout {VERSION}", path.display())]
    Version {
        /// File.
        path: PathBuf,
        /// Its layout.
        found: u64,
    },
    /// Shorter or longer than it says.
    #[error("the checkpoint {} is damaged: it has {found} of {expected} bytes; take the one before it", path.display())]
    Length {
        /// File.
        path: PathBuf,
        /// Bytes in the file.
        found: u64,
        /// Bytes that its header announces.
        expected: u64,
    },
    /// Changed since it was written.
    #[error("the checkpoint {} is damaged: its checksum does not fit; take the one before it", path.display())]
    Checksum {
        /// File.
        path: PathBuf,
    },
    /// Of another mesh or numbering.
    #[error("the checkpoint {} belongs to another mesh (or other fractures or held sides) than this scene", path.display())]
    OtherMesh {
        /// File.
        path: PathBuf,
    },
    /// Of the same mesh under other physics.
    #[error("the checkpoint {} belongs to a scene with the same mesh but other materials, friction or loads", path.display())]
    OtherScene {
        /// File.
        path: PathBuf,
    },
}

/// A folder of checkpoints of one run, of which the last two stay.
#[derive(Clone, Debug)]
pub struct Checkpoints {
    folder: PathBuf,
    fingerprint: Fingerprint,
}

impl Checkpoints {
    /// The folder must exist.
    pub fn new(folder: PathBuf, fingerprint: Fingerprint) -> Self {
        Self {
            folder,
            fingerprint,
        }
    }

    /// Writes `step_000012.checkpoint`, the state that step 12 starts from, then removes all but the last two.
    ///
    /// # Errors
    /// What the file system says; earlier checkpoints are then still there.
    pub fn save(&self, state: &State) -> io::Result<PathBuf> {
        let path = self
            .folder
            .join(format!("step_{:06}.checkpoint", state.step));
        let bytes = encode(state, self.fingerprint);
        write_atomically(&path, |out| out.write_all(&bytes))?;
        let mut steps = all(&self.folder)?;
        steps.retain(|(step, _)| *step <= state.step);
        for (_, old) in steps.iter().rev().skip(KEPT) {
            fs::remove_file(old)?;
        }
        Ok(path)
    }

    /// Removes the checkpoints of later steps: they belong to a run that is taken back.
    ///
    /// # Errors
    /// What the file system says.
    pub fn forget_after(&self, step: usize) -> io::Result<()> {
        for (_, later) in all(&self.folder)?.iter().filter(|(s, _)| *s > step) {
            fs::remove_file(later)?;
        }
        Ok(())
    }
}

/// The checkpoint with the highest step in a folder.
///
/// # Errors
/// [`CheckpointError::None`] or [`CheckpointError::Read`].
pub fn newest_checkpoint(folder: &Path) -> Result<PathBuf, CheckpointError> {
    let found = all(folder).map_err(|source| CheckpointError::Read {
        path: folder.into(),
        source,
    })?;
    found
        .into_iter()
        .next_back()
        .map(|(_, path)| path)
        .ok_or_else(|| CheckpointError::None {
            path: folder.into(),
        })
}

/// Reads a checkpoint that belongs to `fingerprint`.
///
/// # Errors
/// [`CheckpointError`]: what is wrong with the file, or what it belongs to.
pub fn read_checkpoint(path: &Path, fingerprint: Fingerprint) -> Result<State, CheckpointError> {
    let bytes = fs::read(path).map_err(|source| CheckpointError::Read {
        path: path.into(),
        source,
    })?;
    decode(&bytes, path, fingerprint)
}

/// Steps and files in a folder, increasing.
fn all(folder: &Path) -> io::Result<Vec<(usize, PathBuf)>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let step = name
            .strip_prefix("step_")
            .and_then(|rest| rest.strip_suffix(".checkpoint"))
            .and_then(|digits| digits.parse().ok());
        found.extend(step.map(|step| (step, path.clone())));
    }
    found.sort();
    Ok(found)
}

/// Header, u, t and γ as bits, C of the preconditioner, flips, states, those of the preconditioner, checksum; all numbers
/// little-endian.
fn encode(state: &State, fingerprint: Fingerprint) -> Vec<u8> {
    // by name: a state with more in it must not compile here
    let State {
        step,
        time,
        loaded,
        next,
        force,
        traction,
        size: [size_u, size_t],
        krylov,
        prepared,
        u,
        t,
        states,
        slip,
        flips,
    } = state;
    let length = length(u.len() as u64, states.len() as u64);
    let mut bytes = Vec::with_capacity(length as usize);
    bytes.extend_from_slice(&MAGIC);
    let Fingerprint { mesh, scene } = fingerprint;
    let whole = [VERSION, length, mesh, scene, *step as u64];
    let scalars =
        [time, loaded, next, force, traction, size_u, size_t, krylov].map(|v| v.to_bits());
    let sizes = [u.len() as u64, states.len() as u64];
    for words in [&whole[..], &scalars, &sizes] {
        bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    }
    for values in [u, t, slip] {
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
    match prepared {
        Some(prepared) => {
            let c = prepared.c.as_flattened().as_flattened();
            bytes.extend(c.iter().flat_map(|v| v.to_le_bytes()));
        }
        None => bytes.resize(bytes.len() + 72 * states.len(), 0),
    }
    bytes.extend(flips.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(states.iter().map(|s| s.code()));
    match prepared {
        Some(prepared) => bytes.extend(prepared.states.iter().map(|s| s.code())),
        None => bytes.resize(bytes.len() + states.len(), NOT_PREPARED),
    }
    let sum = checksum(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// Bytes of a file with these sizes: u; three tractions, two components of slip, a block, a counter and two states per face.
fn length(n_u: u64, faces: u64) -> u64 {
    let words = (HEADER as u64 + 1).saturating_add(n_u);
    let per_face = faces.saturating_mul(3 * 8 + 2 * 8 + 9 * 8 + 4 + 1 + 1);
    words.saturating_mul(8).saturating_add(per_face)
}

fn checksum(bytes: &[u8]) -> u64 {
    let mut hash = Hash::default();
    hash.bytes(bytes);
    hash.value()
}

fn decode(bytes: &[u8], path: &Path, fingerprint: Fingerprint) -> Result<State, CheckpointError> {
    let path = || path.to_path_buf();
    if !bytes.starts_with(&MAGIC) {
        return Err(CheckpointError::Foreign { path: path() });
    }
    let found = bytes.len() as u64;
    let word = |k: usize| {
        let word = bytes.get(8 * k..8 * k + 8).and_then(|w| w.try_into().ok());
        word.map(u64::from_le_bytes)
            .ok_or_else(|| CheckpointError::Length {
                path: path(),
                found,
                expected: 8 * (HEADER as u64 + 1),
            })
    };
    let version = word(1)?;
    if version != VERSION {
        return Err(CheckpointError::Version {
            path: path(),
            found: version,
        });
    }
    let expected = word(2)?;
    if expected != found {
        return Err(CheckpointError::Length {
            path: path(),
            found,
            expected,
        });
    }
    let (n_u, faces) = (word(14)?, word(15)?);
    let (content, sum) = bytes.split_at(bytes.len() - 8);
    if checksum(content).to_le_bytes() != sum || length(n_u, faces) != found {
        return Err(CheckpointError::Checksum { path: path() });
    }
    if word(3)? != fingerprint.mesh {
        return Err(CheckpointError::OtherMesh { path: path() });
    }
    if word(4)? != fingerprint.scene {
        return Err(CheckpointError::OtherScene { path: path() });
    }
    // the file was read whole, so both fit into memory
    let (n_u, faces) = (n_u as usize, faces as usize);
    let (u, rest) = content[8 * HEADER..].split_at(8 * n_u);
    let (t, rest) = rest.split_at(24 * faces);
    let (slip, rest) = rest.split_at(16 * faces);
    let (c, rest) = rest.split_at(72 * faces);
    let (flips, rest) = rest.split_at(4 * faces);
    let (states, prepared) = rest.split_at(faces);
    let no_state = || CheckpointError::Checksum { path: path() };
    let decoded = |codes: &[u8]| -> Option<Vec<ContactState>> {
        codes.iter().map(|s| ContactState::from_code(*s)).collect()
    };
    let unprepared = prepared.iter().all(|code| *code == NOT_PREPARED);
    Ok(State {
        step: word(5)? as usize,
        time: f64::from_bits(word(6)?),
        loaded: f64::from_bits(word(7)?),
        next: f64::from_bits(word(8)?),
        force: f64::from_bits(word(9)?),
        traction: f64::from_bits(word(10)?),
        size: [f64::from_bits(word(11)?), f64::from_bits(word(12)?)],
        krylov: f64::from_bits(word(13)?),
        prepared: match unprepared {
            true => None,
            false => Some(Prepared {
                states: decoded(prepared).ok_or_else(no_state)?,
                c: reals(c).as_chunks().0.as_chunks().0.to_vec(),
            }),
        },
        u: reals(u),
        t: reals(t),
        states: decoded(states).ok_or_else(no_state)?,
        slip: reals(slip),
        flips: flips
            .as_chunks()
            .0
            .iter()
            .map(|n| u32::from_le_bytes(*n))
            .collect(),
    })
}

fn reals(bytes: &[u8]) -> Vec<f64> {
    let (words, _) = bytes.as_chunks();
    words.iter().map(|w| f64::from_le_bytes(*w)).collect()
}

#[cfg(test)]
mod tests;
