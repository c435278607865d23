//! What pressures that differ from element to element take of memory, before any of them is read.

use super::moved::place;
use super::vtu;
use crate::scene::latest::KEPT;
use crate::scene::pore_pressure::PorePressureSection;
use crate::scene::sections::SceneSections;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// What is kept and what passes [bytes].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoreRoom {
    /// Of the materials the one that keeps most: per element.
    pub per_element: f64,
    /// What reading the largest file takes beside it.
    pub reading: f64,
}

/// What reading takes per byte of a text: its records, and what they say as numbers. An estimate.
const PER_BYTE: f64 = 4.0;

/// What it takes per point or cell of a grid of VTK beside the file. Measured on 1.0 million of each, raw and compressed: 315 and 323.
const PER_ENTITY: f64 = 330.0;

/// Bytes at the beginning of a file that say how many there are.
const BEGINNING: u64 = 4096;

/// Points or cells per byte that a compressed file can hold at most: twelve bytes each, a thousandth of them left.
const PACKED: f64 = 100.0;

/// A number.
const WORD: f64 = 8.0;

/// Numbers per element beside those of the times: the change at the ends of a step, that times Biot's coefficient, and one that is being made.
const BESIDE: usize = KEPT + 2;

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
        let size = |file: &Path| std::fs::metadata(file).map_or(0.0, |data| data.len() as f64);
        let (times, reading) = match (&section.fields, &section.grid) {
            (Some(fields), _) => {
                let files = fields.iter().map(|(_, file)| at(file));
                // a count beyond what the bytes can hold is a fault of the file, which reading tells
                let entities = |file: &Path| entities(file).min(PACKED * size(file));
                let each = files.map(|file| size(&file) + PER_ENTITY * entities(&file));
                (fields.len(), each.fold(0.0, f64::max))
            }
            (None, Some(file)) => {
                let file = at(file);
                (
                    columns(&file).saturating_sub(PLACES),
                    PER_BYTE * size(&file),
                )
            }
            (None, None) => (0, 0.0),
        };
        Self {
            per_element: self.per_element.max(WORD * (times + BESIDE) as f64),
            reading: self.reading.max(reading),
        }
    }
}

/// Points or cells of a grid of VTK, whatever there are more of, as far as its beginning says.
fn entities(file: &Path) -> f64 {
    let mut beginning = Vec::new();
    let read = File::open(file).and_then(|file| file.take(BEGINNING).read_to_end(&mut beginning));
    let announced = read.ok().and_then(|_| vtu::announced(&beginning));
    announced.map_or(0.0, |[points, cells]| points.max(cells) as f64)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_say_what_they_take() {
        let folder = std::env::temp_dir().join(format!("fracas-room-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let grid = "<VTKFile type='UnstructuredGrid'><UnstructuredGrid><Piece NumberOfPoints='7' NumberOfCells='100'>";
        std::fs::write(folder.join("a.vtu"), grid).unwrap();
        let table = "\n\"x [m]\",y [m],z [m],0 day [bar],1 day [bar]\n0,0,0,1,2\n";
        std::fs::write(folder.join("a.csv"), table).unwrap();
        let of = |section: PorePressureSection| PoreRoom::default().with(&section, &folder);
        let fields = [
            ("0 day", "a.vtu"),
            ("1 day", "a.vtu"),
            ("2 day", "gone.vtu"),
        ];
        let fields = fields.map(|(time, file)| (time.parse().unwrap(), file.into()));
        let fields = of(PorePressureSection {
            fields: Some(fields.into()),
            ..PorePressureSection::default()
        });
        assert_eq!(fields.per_element, 56.0);
        assert_eq!(fields.reading, grid.len() as f64 + 33_000.0);
        let grid = of(PorePressureSection {
            grid: Some("a.csv".into()),
            ..PorePressureSection::default()
        });
        assert_eq!(grid.per_element, 48.0);
        assert_eq!(grid.reading, 4.0 * table.len() as f64);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
