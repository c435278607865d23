//! What pressures that differ from element to element take of memory, before any of them is read.

use super::moved::place;
use crate::scene::pore_pressure::PorePressureSection;
use crate::scene::sections::SceneSections;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// What is kept and what passes [bytes].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoreRoom {
    /// Of the materials the one that keeps most: per element.
    pub per_element: f64,
    /// Size of the largest file.
    pub largest_file: f64,
}

/// A number.
const WORD: f64 = 8.0;

/// Numbers per element beside those of the times: the change at the last time, that times Biot's coefficient, and one that is being made.
const BESIDE: usize = 3;

/// Columns of places in a CSV file.
const PLACES: usize = 3;

impl PoreRoom {
    /// Of the materials of a scene; files that cannot be read count 0, which building explains.
    pub(in crate::scene) fn new(sections: &SceneSections, folder: &Path) -> Self {
        let all = sections.material.iter();
        let all = all.filter_map(|m| m.pore_pressure.as_ref().filter(|p| p.is_spatial()));
        all.fold(Self::default(), |room, section| room.with(section, folder))
    }

    fn with(self, section: &PorePressureSection, folder: &Path) -> Self {
        let at = |file: &Path| place(file, folder, section.digest.is_some());
        let (times, files) = match (&section.fields, &section.grid) {
            (Some(fields), _) => (
                fields.len(),
                fields.iter().map(|(_, file)| at(file)).collect(),
            ),
            (None, Some(file)) => (columns(&at(file)).saturating_sub(PLACES), vec![at(file)]),
            (None, None) => (0, Vec::new()),
        };
        let sizes = files
            .iter()
            .map(|file| std::fs::metadata(file).map_or(0, |data| data.len()));
        Self {
            per_element: self.per_element.max(WORD * (times + BESIDE) as f64),
            largest_file: self.largest_file.max(sizes.max().unwrap_or(0) as f64),
        }
    }
}

/// Columns of a CSV file, as its first line that says something tells; commas in quotes count, too.
fn columns(file: &Path) -> usize {
    let lines = File::open(file).map(BufReader::new);
    let lines = lines
        .into_iter()
        .flat_map(|text| text.split(b'\n').map_while(Result::ok));
    let mut said = lines.filter(|line| line.iter().any(u8::is_ascii_alphanumeric));
    let heading = said.next().unwrap_or_default();
    1 + heading.iter().filter(|byte| **byte == b',').count()
}
