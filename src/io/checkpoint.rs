//! States on disk, to the last bit: what a run goes on from.

mod error;

use super::write_atomically;
use super::{Fingerprint, Hash};
use crate::contact::ContactState;
use crate::nonlinear::{CreepState, Onsets, Prepared, State};
use fracas_operators::{Field, Fields};
use fracas_solvers::saddle::{P, T, U};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use error::CheckpointError;

/// First bytes of every checkpoint.
const MAGIC: [u8; 8] = *b"fracasCK";

/// Layout of what follows: another number, another layout.
const VERSION: u64 = 4;

/// Words of eight bytes before the table of fields: magic, version, length of the file, mesh, scene, step, time, loaded, next, force,
/// traction, krylov, faces, fields.
const HEADER: usize = 14;

/// Code of a face where no preconditioner is kept.
const NOT_PREPARED: u8 = u8::MAX;

/// Checkpoints that stay in a folder.
const KEPT: usize = 2;

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

/// Viscous strain, where rock creeps; its norm in the table is the length of the step that A was last made for.
const CREEP: Field = Field {
    letter: "e_v",
    name: "viscous strains",
};

/// Path of the slip, where friction follows it.
const PATH: Field = Field {
    letter: "s",
    name: "paths of slip",
};

/// What is known of the onset of slip, where it is looked for.
const ONSETS: Field = Field {
    letter: "on",
    name: "onsets of slip",
};

/// Fields behind u and t, in this order, where a state has them.
const MORE: [Field; 4] = [P, CREEP, PATH, ONSETS];

/// Added to the code of a state where [`State::released`] holds.
const RELEASED: u8 = 4;

/// The same where [`State::torn`] does.
const TORN: u8 = 8;

/// The header, a table of the fields (letter, length, norm), their values as bits, then γ, C of the preconditioner, flips, states,
/// those of the preconditioner and a checksum; all numbers little-endian.
fn encode(state: &State, fingerprint: Fingerprint) -> Vec<u8> {
    // by name: a state with more in it must not compile here
    let State {
        step,
        time,
        loaded,
        next,
        force,
        traction,
        size,
        krylov,
        prepared,
        u,
        t,
        p,
        states,
        slip,
        path,
        creep,
        released,
        torn,
        flips,
        onsets,
    } = state;
    let pressures = (!p.is_empty()).then_some((P, &p[..]));
    let crept = creep.as_ref().map(|own| (CREEP, own.strain.as_flattened()));
    let begun = onsets.as_ref().map(|own| own.numbers());
    let begun = begun.as_ref().map(|numbers| (ONSETS, &numbers[..]));
    let paths = (!path.is_empty()).then_some((PATH, &path[..]));
    let more = (pressures.into_iter()).chain(crept).chain(paths);
    let more = more.chain(begun);
    let fields: Vec<(Field, &[f64])> = [(U, &u[..]), (T, t)].into_iter().chain(more).collect();
    let mut bytes = MAGIC.to_vec();
    let Fingerprint { mesh, scene } = fingerprint;
    // the length comes last
    let whole = [VERSION, 0, mesh, scene, *step as u64];
    let scalars = [time, loaded, next, force, traction, krylov].map(|v| v.to_bits());
    let sizes = [states.len() as u64, fields.len() as u64];
    let words = [&whole[..], &scalars, &sizes].concat();
    let norm = |field| match (field, creep) {
        (CREEP, Some(own)) => own.step.to_bits(),
        _ => size.get(field).unwrap_or(0.0).to_bits(),
    };
    let table = fields
        .iter()
        .flat_map(|(field, values)| [letter(*field), values.len() as u64, norm(*field)]);
    let words = words.into_iter().chain(table);
    bytes.extend(words.flat_map(|word| word.to_le_bytes()));
    let values = fields.iter().flat_map(|(_, values)| *values);
    let values = values.chain(slip);
    bytes.extend(values.flat_map(|v| v.to_le_bytes()));
    match prepared {
        Some(prepared) => {
            let c = prepared.c.as_flattened().as_flattened();
            bytes.extend(c.iter().flat_map(|v| v.to_le_bytes()));
        }
        None => bytes.resize(bytes.len() + 72 * states.len(), 0),
    }
    bytes.extend(flips.iter().flat_map(|n| n.to_le_bytes()));
    let code =
        |f: usize| states[f].code() + RELEASED * u8::from(released[f]) + TORN * u8::from(torn[f]);
    bytes.extend((0..states.len()).map(code));
    match prepared {
        Some(prepared) => bytes.extend(prepared.states.iter().map(|s| s.code())),
        None => bytes.resize(bytes.len() + states.len(), NOT_PREPARED),
    }
    let length = bytes.len() as u64 + 8;
    bytes[16..24].copy_from_slice(&length.to_le_bytes());
    let sum = checksum(&bytes);
    bytes.extend(sum.to_le_bytes());
    bytes
}

/// A field's letter as a word.
fn letter(field: Field) -> u64 {
    let mut word = [0; 8];
    let bytes = field.letter.bytes();
    word.iter_mut().zip(bytes).for_each(|(w, b)| *w = b);
    u64::from_le_bytes(word)
}

fn checksum(bytes: &[u8]) -> u64 {
    let mut hash = Hash::default();
    hash.bytes(bytes);
    hash.value()
}

/// What is left of a file; nothing where it is too short.
struct Rest<'b>(&'b [u8]);

impl<'b> Rest<'b> {
    fn take(&mut self, n: usize) -> Option<&'b [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }

    fn word(&mut self) -> Option<u64> {
        let word = self.take(8)?.try_into().ok()?;
        Some(u64::from_le_bytes(word))
    }

    fn real(&mut self) -> Option<f64> {
        self.word().map(f64::from_bits)
    }

    fn reals(&mut self, n: usize) -> Option<Vec<f64>> {
        let (words, _) = self.take(n.checked_mul(8)?)?.as_chunks();
        Some(words.iter().map(|w| f64::from_le_bytes(*w)).collect())
    }

    fn states(&mut self, n: usize) -> Option<Vec<ContactState>> {
        let codes = self.take(n)?.iter();
        codes.map(|code| ContactState::from_code(*code)).collect()
    }
}

fn decode(bytes: &[u8], path: &Path, fingerprint: Fingerprint) -> Result<State, CheckpointError> {
    let path = || path.to_path_buf();
    if !bytes.starts_with(&MAGIC) {
        return Err(CheckpointError::Foreign { path: path() });
    }
    let found = bytes.len() as u64;
    let of_length = |expected: u64| CheckpointError::Length {
        path: path(),
        found,
        expected,
    };
    let mut rest = Rest(&bytes[MAGIC.len()..]);
    let mut word = || {
        let word = rest.word();
        word.ok_or_else(|| of_length(8 * (HEADER as u64 + 1)))
    };
    let version = word()?;
    if version != VERSION {
        return Err(CheckpointError::Version {
            path: path(),
            found: version,
        });
    }
    let expected = word()?;
    if expected != found {
        return Err(of_length(expected));
    }
    let (mesh, scene) = (word()?, word()?);
    let damaged = || CheckpointError::Checksum { path: path() };
    let (content, sum) = bytes.split_at(bytes.len() - 8);
    if checksum(content).to_le_bytes() != sum {
        return Err(damaged());
    }
    if mesh != fingerprint.mesh {
        return Err(CheckpointError::OtherMesh { path: path() });
    }
    if scene != fingerprint.scene {
        return Err(CheckpointError::OtherScene { path: path() });
    }
    // behind magic, version, length and fingerprint
    let rest = Rest(content.get(8 * 5..).unwrap_or_default());
    match content_of(rest).ok_or_else(damaged)? {
        Ok(state) => Ok(state),
        Err(found) => Err(CheckpointError::OtherFields {
            path: path(),
            found,
        }),
    }
}

/// The state behind step and scalars, or the letters of fields that are not u, t and some of [`MORE`]; nothing where the file is too short.
fn content_of(mut rest: Rest<'_>) -> Option<Result<State, String>> {
    let step = rest.word()? as usize;
    let [time, loaded, next, force, traction, krylov] = [(); 6].map(|()| rest.real());
    let (faces, count) = (rest.word()? as usize, rest.word()?);
    let table: Option<Vec<[u64; 3]>> = (0..count)
        .map(|_| Some([rest.word()?, rest.word()?, rest.word()?]))
        .collect();
    let table = table?;
    let letters: Vec<u64> = table.iter().map(|[letter, ..]| *letter).collect();
    let has = |field: &Field| letters.contains(&letter(*field));
    let more = MORE.into_iter().filter(has);
    let known = [U, T].into_iter().chain(more).map(letter);
    if !known.eq(letters.iter().copied()) {
        let letter = |word: &u64| String::from_utf8_lossy(&word.to_le_bytes()).into_owned();
        let letters: Vec<String> = letters.iter().map(letter).collect();
        return Some(Err(letters.join(", ").replace('\0', "")));
    }
    let judged = [U, T, P];
    let norms = judged.into_iter().zip(&table);
    let norms = norms.filter(|(field, [own, ..])| letter(*field) == *own);
    let size = Fields::new(norms.map(|(field, [.., norm])| (field, f64::from_bits(*norm))));
    let mut values = table
        .iter()
        .map(|[_, length, _]| rest.reals(*length as usize));
    let (u, t) = (values.next()??, values.next()??);
    let mut more = |field| match letters.contains(&letter(field)) {
        true => values.next()?,
        false => Some(Vec::new()),
    };
    let (p, strain) = (more(P)?, more(CREEP)?);
    let (path, begun) = (more(PATH)?, more(ONSETS)?);
    let onsets = match has(&ONSETS) {
        true => Some(Box::new(Onsets::from_numbers(&begun)?)),
        false => None,
    };
    let crept = table.iter().find(|[own, ..]| *own == letter(CREEP));
    let creep = crept.map(|[.., step]| CreepState {
        step: f64::from_bits(*step),
        strain: strain.as_chunks().0.to_vec(),
    });
    let slip = rest.reals(faces.checked_mul(2)?)?;
    let c = rest
        .reals(faces.checked_mul(9)?)?
        .as_chunks()
        .0
        .as_chunks()
        .0
        .to_vec();
    let flips = rest.take(faces.checked_mul(4)?)?.as_chunks().0.iter();
    let flips = flips.map(|n| u32::from_le_bytes(*n)).collect();
    let codes = rest.take(faces)?;
    let marked = |bit: u8| codes.iter().map(|code| code & bit != 0).collect();
    let state = |code: &u8| ContactState::from_code(code & !(RELEASED | TORN));
    let states = codes.iter().map(state).collect::<Option<_>>()?;
    let unprepared = rest.0.iter().all(|code| *code == NOT_PREPARED);
    Some(Ok(State {
        step,
        time: time?,
        loaded: loaded?,
        next: next?,
        force: force?,
        traction: traction?,
        size,
        krylov: krylov?,
        prepared: match unprepared {
            true => None,
            false => Some(Prepared {
                states: rest.states(faces)?,
                c,
            }),
        },
        u,
        t,
        p,
        states,
        slip,
        path,
        creep: creep.map(Box::new),
        released: marked(RELEASED),
        torn: marked(TORN),
        flips,
        onsets,
    }))
}

#[cfg(test)]
mod tests;
