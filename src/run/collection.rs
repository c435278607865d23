//! The grids of a run and the collection that gives them their times.

use super::RunError;
use super::error::At;
use crate::io::{Fields, PvdEntry, read_pvd, write_atomically, write_pvd};
use std::fs;
use std::path::{Path, PathBuf};

/// Grids of one time: name in files, name that ParaView shows.
const PARTS: [(&str, &str); 2] = [("domain", "domain"), ("fracture", "fractures")];

/// Fields on disk, `domain_000123.vtu` and `fracture_000123.vtu`, and `scene.pvd`.
#[derive(Debug)]
pub(super) struct Collection {
    out: PathBuf,
    /// Steps with fields and their times [s], increasing.
    times: Vec<(usize, f64)>,
}

impl Collection {
    /// Begins in a folder without fields.
    pub(super) fn create(out: &Path) -> Result<Self, RunError> {
        let collection = Self::new(out);
        collection.write_list()?;
        Ok(collection)
    }

    fn new(out: &Path) -> Self {
        Self {
            out: out.into(),
            times: Vec::new(),
        }
    }

    /// Of a folder with fields: those of `step` and later ones are taken back.
    pub(super) fn cut(out: &Path, step: usize) -> Result<Self, RunError> {
        let mut collection = Self::new(out);
        let path = out.join("scene.pvd");
        let text = fs::read_to_string(&path).at("cannot read", &path)?;
        for (time, file) in read_pvd(&text) {
            match step_of(&file, PARTS[0].0) {
                Some(of) if of < step => collection.times.push((of, time)),
                _ => {}
            }
        }
        // the collection first: it must not name a file that is gone
        collection.write_list()?;
        for entry in fs::read_dir(out).at("cannot read", out)? {
            let path = entry.at("cannot read", out)?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let later =
                |(part, _): &(&str, &str)| step_of(&name, part).is_some_and(|of| of >= step);
            if PARTS.iter().any(later) {
                fs::remove_file(&path).at("cannot remove", &path)?;
            }
        }
        Ok(collection)
    }

    /// True when the fields of a step are there.
    pub(super) fn has(&self, step: usize) -> bool {
        self.times.iter().any(|(of, _)| *of == step)
    }

    /// Steps with fields and their times [s], increasing.
    pub(super) fn steps(&self) -> &[(usize, f64)] {
        &self.times
    }

    /// The files of a step: body and fractures.
    pub(super) fn files(&self, step: usize) -> [PathBuf; 2] {
        PARTS.map(|(part, _)| self.out.join(file(part, step)))
    }

    /// Writes the fields of a step, then the list.
    pub(super) fn add(
        &mut self,
        step: usize,
        time: f64,
        fields: &Fields<'_>,
    ) -> Result<(), RunError> {
        let [domain, fracture] = self.files(step);
        write_atomically(&domain, |out| fields.write_body(out)).at("cannot write", &domain)?;
        write_atomically(&fracture, |out| fields.write_fracture(out))
            .at("cannot write", &fracture)?;
        self.times.push((step, time));
        self.write_list()
    }

    fn write_list(&self) -> Result<(), RunError> {
        let entry = |(step, time): &(usize, f64)| {
            let (step, time) = (*step, *time);
            PARTS
                .into_iter()
                .enumerate()
                .map(move |(part, (name, shown))| PvdEntry {
                    time,
                    part,
                    name: shown,
                    file: file(name, step),
                })
        };
        let entries: Vec<PvdEntry> = self.times.iter().flat_map(entry).collect();
        let path = self.out.join("scene.pvd");
        write_pvd(&path, &entries).at("cannot write", &path)
    }
}

fn file(part: &str, step: usize) -> String {
    format!("{part}_{step:06}.vtu")
}

/// Step of `PART_000123.vtu`.
fn step_of(file: &str, part: &str) -> Option<usize> {
    let digits = file.strip_prefix(part)?.strip_prefix('_')?;
    digits.strip_suffix(".vtu")?.parse().ok()
}
