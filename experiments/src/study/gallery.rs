//! Studies of the product, by name: files that `reproduce` runs beside the experiments.

use super::engine::in_memory;
use super::{Study, page};
use crate::report::{Experiment, Findings, Level};
use fracas_solvers::{Observer, Step};
use std::path::Path;
use std::sync::LazyLock;

/// Rows that failed and have a remark of their own each; of more, how they ended is counted.
const LISTED: usize = 40;

/// A study file of the gallery.
#[derive(Debug)]
pub struct GalleryStudy {
    /// Name on the command line.
    pub name: &'static str,
    /// The file.
    pub toml: &'static str,
    /// As it is in print.
    paper: LazyLock<Study>,
}

macro_rules! gallery {
    ($($place:ident $name:literal;)*) => {
        $(/// One of [`GALLERY`].
        pub static $place: GalleryStudy = GalleryStudy {
            name: $name,
            toml: include_str!(concat!("gallery/", $name, ".toml")),
            paper: LazyLock::new(|| $place.at(Level::Paper).expect("a test reads every study of the gallery")),
        };)*

        /// Every study of the gallery; adding one touches this list and one file.
        pub static GALLERY: &[&GalleryStudy] = &[$(&$place),*];
    };
}

gallery! {
    E02 "e02";
    E02B "e02b";
    E03 "e03";
    E04 "e04";
    E04B "e04b";
    E05 "e05";
    E06 "e06";
    E06B "e06b";
    E07 "e07";
    E08 "e08";
    E09 "e09";
    E20 "e20";
    E24 "e24";
    E25 "e25";
    E26 "e26";
    E28 "e28";
}

/// The study of that name.
pub fn named(name: &str) -> Option<&'static GalleryStudy> {
    GALLERY.iter().copied().find(|study| study.name == name)
}

impl GalleryStudy {
    /// The study at a level.
    ///
    /// # Errors
    /// A file that is wrong.
    pub fn at(&self, level: Level) -> anyhow::Result<Study> {
        let level = match level {
            Level::Smoke => Some(level.word()),
            Level::Paper => None,
        };
        self.read(level)
    }

    /// The same by the name of a level, or as the file says.
    ///
    /// # Errors
    /// As [`at`](Self::at); a level that it does not have.
    pub fn read(&self, level: Option<&str>) -> anyhow::Result<Study> {
        let name = format!("{}.toml", self.name);
        Study::from_toml(self.toml, &name, Path::new(""), level)
    }
}

impl Experiment for GalleryStudy {
    fn id(&self) -> &str {
        self.name
    }

    fn title(&self) -> &str {
        &self.paper.title
    }

    fn question(&self) -> &str {
        &self.paper.question
    }

    fn setup(&self) -> &str {
        &self.paper.setup
    }

    fn expect(&self) -> &str {
        &self.paper.expect
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let study = self.at(level)?;
        let rows = in_memory(&study, |done, total| {
            let stage = self.name;
            observer.observe(&Step::Progress { stage, done, total })
        })?;
        let mut findings = page::answer(&study, &rows);
        let failed: Vec<_> = rows
            .rows
            .iter()
            .filter(|row| rows.has_failed(row))
            .collect();
        if failed.len() > LISTED {
            let ends = rows.values(&failed, "outcome").into_iter().map(|end| {
                let same = |row: &&&Vec<String>| rows.field(row, "outcome") == end;
                let count = failed.iter().filter(same).count();
                format!("{} {count}", end.replace('_', " "))
            });
            let ends: Vec<String> = ends.collect();
            let (count, all) = (failed.len(), rows.rows.len());
            findings.notes.push(format!(
                "{count} of {all} rows failed: {}.",
                ends.join(", ")
            ));
            return Ok(findings);
        }
        for row in failed {
            let fields = study.axis_names();
            let words = fields.iter().filter(|name| study.varies(name));
            let words: Vec<&str> = words.map(|name| rows.field(row, name)).collect();
            let reason = rows.field(row, "reason");
            findings
                .notes
                .push(format!("{}: {reason}.", words.join(", ")));
        }
        Ok(findings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_study_reads_at_both_levels_asks_and_claims_in_sixty_lines() {
        for study in GALLERY {
            for level in [Level::Smoke, Level::Paper] {
                let file = study.at(level).unwrap();
                let texts = [&file.question, &file.setup, &file.expect];
                assert!(texts.iter().all(|text| !text.is_empty()), "{}", study.name);
                assert!(!file.check.is_empty(), "{}", study.name);
            }
            let lines = study.toml.lines().count();
            assert!(lines <= 60, "{} has {lines} lines", study.name);
        }
    }

    #[test]
    fn the_page_about_studies_lists_the_gallery() {
        let page = include_str!("../../../docs/studies.md");
        for study in GALLERY {
            let line = format!("| `{}` | {} |", study.name, study.question());
            assert!(page.contains(&line), "docs/studies.md lacks {line}");
        }
    }
}
