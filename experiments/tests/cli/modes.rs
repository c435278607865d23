//! Claim: eigenvectors land on the right nodes and faces of the mesh, and are eigenvectors there.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its files fails"
)]

use crate::run::{fracas, scratch};
use std::collections::BTreeMap;
use std::path::Path;

/// A `.vtu` of ours.
struct Grid {
    header: String,
    data: Vec<u8>,
}

impl Grid {
    fn read(path: &Path) -> Self {
        let file = std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let at = file.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
        Self {
            header: String::from_utf8(file[..at].to_vec()).unwrap(),
            data: file[at..].to_vec(),
        }
    }

    /// Eight-byte words of a named array.
    fn words(&self, name: &str) -> Vec<[u8; 8]> {
        let tag = self
            .header
            .split(&format!("Name=\"{name}\""))
            .nth(1)
            .unwrap();
        let offset = tag.split("offset=\"").nth(1).unwrap();
        let offset: usize = offset.split('"').next().unwrap().parse().unwrap();
        let word = |at: usize| -> [u8; 8] { self.data[at..at + 8].try_into().unwrap() };
        let bytes = u64::from_le_bytes(word(offset)) as usize;
        (0..bytes / 8).map(|k| word(offset + 8 + 8 * k)).collect()
    }

    fn vectors(&self, name: &str) -> Vec<[f64; 3]> {
        let values: Vec<f64> = self
            .words(name)
            .into_iter()
            .map(f64::from_le_bytes)
            .collect();
        values.chunks_exact(3).map(|v| [v[0], v[1], v[2]]).collect()
    }

    fn quads(&self) -> Vec<[usize; 4]> {
        let indices: Vec<usize> = self
            .words("connectivity")
            .into_iter()
            .map(|w| i64::from_le_bytes(w) as usize)
            .collect();
        indices
            .chunks_exact(4)
            .map(|q| [q[0], q[1], q[2], q[3]])
            .collect()
    }
}

/// Rows of `modes.csv` by column name; empty cells are left out.
fn table(folder: &Path) -> Vec<BTreeMap<String, f64>> {
    let text = std::fs::read_to_string(folder.join("modes.csv")).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let cells = head.iter().zip(line.split(','));
            cells
                .filter_map(|(name, cell)| Some(((*name).to_owned(), cell.parse().ok()?)))
                .collect()
        })
        .collect()
}

#[test]
fn spurious_tractions_and_the_largest_displacement_are_where_the_files_say() {
    let folder = scratch("modes").join("new");
    let ran = fracas(&[
        "spectrum",
        "checkerboard",
        "--set",
        "mesh.x.cells=6",
        "--set",
        "mesh.y.cells=6",
        "--set",
        "mesh.z.cells=6",
        "--stabilization",
        "0",
        "--modes",
        "smallest,largest",
        "--vtu",
        folder.to_str().unwrap(),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    let modes = table(&folder);
    assert_eq!(modes.len(), 2);

    // B t = 0: the faces around every inner node, all of one size, pull it nowhere
    let spurious = &modes[0];
    assert!(spurious["re"].abs() < 1e-10 && spurious["traction_share"] > 1.0 - 1e-10);
    let fracture = Grid::read(&folder.join("mode_000_fracture.vtu"));
    let (quads, tractions) = (fracture.quads(), fracture.vectors("traction"));
    assert_eq!((quads.len(), tractions.len()), (16, 16));
    let mut pulls: BTreeMap<usize, Vec<[f64; 3]>> = BTreeMap::new();
    for (quad, t) in quads.iter().zip(&tractions) {
        quad.iter()
            .for_each(|a| pulls.entry(*a).or_default().push(*t));
    }
    let size = tractions
        .iter()
        .flatten()
        .fold(0.0f64, |m, t| m.max(t.abs()));
    let inner: Vec<_> = pulls.values().filter(|t| t.len() == 4).collect();
    assert_eq!((pulls.len(), inner.len()), (25, 9));
    for around in inner {
        for d in 0..3 {
            let sum: f64 = around.iter().map(|t| t[d]).sum();
            assert!(size > 0.0 && sum.abs() < 1e-9 * size, "{sum} of {size}");
        }
    }
    assert!(
        fracture
            .vectors("normal")
            .iter()
            .all(|n| *n == [1.0, 0.0, 0.0])
    );

    // the largest displacement is at the place that the table gives, and the fixed side stays
    let body = Grid::read(&folder.join("mode_001_body.vtu"));
    let (points, moved) = (body.vectors("Points"), body.vectors("displacement"));
    let reach = |u: &[f64; 3]| u.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let largest = moved.iter().map(reach).fold(0.0, f64::max);
    let place = ["x", "y", "z"].map(|d| modes[1][&format!("displacement_{d}")]);
    let there = points.iter().zip(&moved).filter(|(x, _)| **x == place);
    assert!(there.map(|(_, u)| reach(u)).fold(0.0, f64::max) == largest && largest > 0.0);
    let fixed = points.iter().zip(&moved).filter(|(x, _)| x[0] == -6.0);
    assert!(fixed.clone().count() == 49 && fixed.map(|(_, u)| reach(u)).all(|u| u == 0.0));
    assert_eq!(body.header.matches("Name=\"material\"").count(), 1);
}

#[test]
fn folders_get_tables() {
    let system = crate::run::system_folder("modes-folder");
    let out = scratch("modes-tables");
    let ran = fracas(&[
        "spectrum",
        "--system",
        system.to_str().unwrap(),
        "--modes",
        "-0.5,largest",
        "--vtu",
        out.to_str().unwrap(),
    ]);
    assert_eq!(ran.status, 0, "{}", ran.stderr);
    assert_eq!(ran.stdout.matches("\nmode ").count(), 2, "{}", ran.stdout);
    for mode in table(&out) {
        assert!(mode["residual"] < 1e-12 && !mode.contains_key("traction_x"));
    }
    let lines = |name: &str| {
        let text = std::fs::read_to_string(out.join(name)).unwrap();
        text.lines().count()
    };
    assert_eq!((lines("mode_001_u.csv"), lines("mode_001_t.csv")), (5, 3));
}

#[test]
fn modes_that_cannot_be_had_are_refused() {
    let system = crate::run::system_folder("modes-refused");
    let system = system.to_str().unwrap();
    for (arguments, sentence) in [
        (
            &["--modes", "smalest"][..],
            "unknown mode \"smalest\": expected smallest, largest or a number such as 0.5",
        ),
        (&["--modes", "nan"], "unknown mode \"nan\""),
        (
            &["--modes", "largest", "--dense-limit", "1"],
            "no eigenvector was computed for n_u + n_t = 6; raise --dense-limit",
        ),
        (&["--vtu", "x"], "--modes"),
    ] {
        let ran = fracas(&[&["spectrum", "--system", system][..], arguments].concat());
        assert!(
            ran.status == 2 && ran.stderr.contains(sentence),
            "{arguments:?}: {}",
            ran.stderr
        );
    }
}
