//! A ParaView collection (`.pvd`): which grids belong to which time.

use super::write_atomically;
use std::io::{self, Write};
use std::path::Path;

/// A grid of a collection.
#[derive(Clone, Debug, PartialEq)]
pub struct PvdEntry {
    /// Time [s].
    pub time: f64,
    /// 0, 1, …: grids of one time that are shown together.
    pub part: usize,
    /// Name that ParaView shows for the part.
    pub name: &'static str,
    /// File, relative to the collection.
    pub file: String,
}

/// Writes a collection; whoever reads it meanwhile finds the old one or the new one.
///
/// # Errors
/// What the file system says.
pub fn write_pvd(path: &Path, entries: &[PvdEntry]) -> io::Result<()> {
    write_atomically(path, |out| {
        out.write_all(
            b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        )?;
        for PvdEntry {
            time,
            part,
            name,
            file,
        } in entries
        {
            writeln!(
                out,
                "<DataSet timestep=\"{time:?}\" part=\"{part}\" name=\"{name}\" file=\"{file}\"/>"
            )?;
        }
        out.write_all(b"</Collection>\n</VTKFile>\n")
    })
}

/// Times and files of a collection that [`write_pvd`] wrote, in order; lines of another form are skipped.
pub fn read_pvd(text: &str) -> Vec<(f64, String)> {
    let attribute = |line: &str, name: &str| {
        let (_, rest) = line.split_once(&format!(" {name}=\""))?;
        Some(rest.split_once('"')?.0.to_owned())
    };
    text.lines()
        .filter(|line| line.starts_with("<DataSet "))
        .filter_map(|line| {
            let time = attribute(line, "timestep")?.parse().ok()?;
            Some((time, attribute(line, "file")?))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collection_reads_back() {
        let path = std::env::temp_dir().join(format!("fracas-{}.pvd", std::process::id()));
        let entry = |time, part, file: &str| PvdEntry {
            time,
            part,
            name: ["body", "fractures"][part],
            file: file.into(),
        };
        let entries = [
            entry(0.0, 0, "domain_000000.vtu"),
            entry(0.1 + 0.2, 1, "fracture_000001.vtu"),
        ];
        write_pvd(&path, &entries).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let read = read_pvd(&text);
        let expected: Vec<_> = entries.iter().map(|e| (e.time, e.file.clone())).collect();
        assert_eq!(read, expected);
        assert!(text.contains(
            "<DataSet timestep=\"0.30000000000000004\" part=\"1\" name=\"fractures\" file=\"fracture_000001.vtu\"/>"
        ));
    }
}
