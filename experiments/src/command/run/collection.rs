//! The grids of a run and the collection that gives them their times.

use anyhow::Context;
use fracas::io::{Fields, PvdEntry, read_pvd, write_atomically, write_pvd};
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
    pub(super) fn create(out: &Path) -> anyhow::Result<Self> {
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
    pub(super) fn cut(out: &Path, step: usize) -> anyhow::Result<Self> {
        let mut collection = Self::new(out);
        let path = out.join("scene.pvd");
        let text =
            fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        for (time, file) in read_pvd(&text) {
            match step_of(&file, PARTS[0].0) {
                Some(of) if of < step => collection.times.push((of, time)),
                _ => {}
            }
        }
        // the collection first: it must not name a file that is gone
        collection.write_list()?;
        let entries =
            fs::read_dir(out).with_context(|| format!("cannot read {}", out.display()))?;
        for entry in entries {
            let path = entry?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let later =
                |(part, _): &(&str, &str)| step_of(&name, part).is_some_and(|of| of >= step);
            if PARTS.iter().any(later) {
                fs::remove_file(&path)
                    .with_context(|| format!("cannot remove {}", path.display()))?;
            }
        }
        Ok(collection)
    }

    /// True when the fields of a step are there.
    pub(super) fn has(&self, step: usize) -> bool {
        self.times.iter().any(|(of, _)| *of == step)
    }

    /// Writes the fields of a step, then the list.
    pub(super) fn add(
        &mut self,
        step: usize,
        time: f64,
        fields: &Fields<'_>,
    ) -> anyhow::Result<()> {
        let [domain, fracture] = PARTS.map(|(part, _)| self.out.join(file(part, step)));
        let said = |path: &Path| format!("cannot write {}", path.display());
        write_atomically(&domain, |out| fields.write_body(out)).with_context(|| said(&domain))?;
        write_atomically(&fracture, |out| fields.write_fracture(out))
            .with_context(|| said(&fracture))?;
        self.times.push((step, time));
        self.write_list()
    }

    fn write_list(&self) -> anyhow::Result<()> {
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
        write_pvd(&path, &entries).with_context(|| format!("cannot write {}", path.display()))
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
