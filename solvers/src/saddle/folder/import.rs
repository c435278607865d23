//! Reading a system folder.

use super::finding::{Finding, Remark};
use super::manifest::Manifest;
use super::{FolderError, announced, coordinates, entries, inspect, rigid_body, sizes};
use crate::saddle::{FlowBlocks, SaddleBlocks};
use fracas_operators::Shape;
use fracas_operators::matrix_market::{SparseFile, Symmetry, read_dense, read_sparse, read_vector};
use fracas_operators::sparse::SparseMatrix;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A system as read, with what is remarkable about it.
#[derive(Clone, Debug)]
pub struct Imported {
    /// The blocks; absent right-hand sides are zero.
    pub blocks: SaddleBlocks,
    /// What the folder says about itself; empty when it says nothing.
    pub manifest: Manifest,
    /// Remarks, in the order of the files.
    pub findings: Vec<Finding>,
    /// True when at least one `rhs_*.mtx` exists.
    pub has_rhs: bool,
}

/// Every file that a system folder may hold.
pub(super) const FILES: [&str; 13] = [
    "A.mtx",
    "B1.mtx",
    "B2.mtx",
    "H.mtx",
    "Q1.mtx",
    "Q2.mtx",
    "T.mtx",
    "rhs_u.mtx",
    "rhs_t.mtx",
    "rhs_p.mtx",
    "coords.mtx",
    "faces.mtx",
    "manifest.json",
];

/// Reads a system folder.
///
/// # Cost
/// A few seconds for 16 million entries; 12 bytes per entry of A and 16 MB at the peak.
///
/// # Errors
/// [`FolderError`]: a file is missing or defective, sizes contradict each other, entries are beyond 1e±100, A is not symmetric.
pub fn read_folder(folder: &Path) -> Result<Imported, FolderError> {
    match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => {}
        Err(source) if source.kind() == ErrorKind::PermissionDenied => {
            let file = folder.into();
            return Err(FolderError::Unreadable { file, source });
        }
        _ => {
            return Err(FolderError::NotAFolder {
                folder: folder.into(),
            });
        }
    }
    let mut reader = Reader {
        folder,
        findings: Vec::new(),
    };
    let manifest = reader.manifest()?;
    sizes::check(&|file| reader.present(file))?;
    let a = reader.required("A.mtx")?;
    let b1 = reader.required("B1.mtx")?;
    let (a_shape, b1_shape) = (shape_of(&a), shape_of(&b1));
    let (n_u, n_t) = (a_shape.rows, b1_shape.cols);
    let from_a = ("A.mtx", a_shape);
    square("A.mtx", a_shape)?;
    for (file, shape) in [from_a, ("B1.mtx", b1_shape)] {
        if shape.rows == 0 || shape.cols == 0 {
            return Err(FolderError::Empty { file, found: shape });
        }
    }
    expect("B1.mtx", b1_shape, Shape::new(n_u, n_t), from_a)?;
    inspect::stiffness(&a.matrix, a.symmetry, &b1.matrix, &mut reader.findings)?;
    inspect::coupling(&b1.matrix, &mut reader.findings);

    let from_b1 = ("B1.mtx", b1_shape);
    let b2 = reader.optional("B2.mtx", Shape::new(n_t, n_u), from_b1)?;
    let b2 = b2.and_then(|b2| inspect::consistency(b2, &b1.matrix, &mut reader.findings));
    let h = reader.optional("H.mtx", Shape::square(n_t), from_b1)?;
    let h = h.and_then(|h| inspect::stabilization(h, &mut reader.findings));
    inspect::rank(&b1.matrix, h.as_ref(), &mut reader.findings);
    let mut flow = reader.flow(n_u, from_a)?;
    let n_p = flow.as_ref().map_or(0, |f| f.t.rows());

    let rhs_u = reader.vector("rhs_u.mtx", n_u, from_a)?;
    let rhs_t = reader.vector("rhs_t.mtx", n_t, from_b1)?;
    let rhs_p = match &flow {
        Some(f) => reader.vector("rhs_p.mtx", n_p, ("T.mtx", Shape::square(f.t.rows())))?,
        None => None,
    };
    let has_rhs = rhs_u.is_some() || rhs_t.is_some() || rhs_p.is_some();
    let given = [&rhs_u, &rhs_t, &rhs_p];
    let is_zero = (given.iter().copied().flatten().flatten()).all(|b| *b == 0.0);
    let remark = match (has_rhs, rhs_u.is_some(), is_zero) {
        (false, ..) => Some(Remark::NoRightHandSide),
        (true, false, true) => Some(Remark::NoForcesAndZero),
        (true, false, false) => Some(Remark::NoForces),
        (true, true, true) => Some(Remark::ZeroRightHandSide),
        (true, true, false) => None,
    };
    reader
        .findings
        .extend(remark.map(|remark| Finding::file("rhs_u.mtx", remark)));
    if let Some(flow) = &mut flow {
        inspect::flow(flow, &mut reader.findings);
        flow.rhs_p = rhs_p.unwrap_or_else(|| vec![0.0; n_p]);
    }
    let coordinates = reader.coordinates(n_u)?;
    if let Some(coordinates) = &coordinates {
        rigid_body::coordinates(&a.matrix, coordinates, &mut reader.findings);
    }
    reader.unread()?;
    let blocks = SaddleBlocks {
        a: a.matrix,
        b1: b1.matrix,
        b2,
        h,
        rhs_u: rhs_u.unwrap_or_else(|| vec![0.0; n_u]),
        rhs_t: rhs_t.unwrap_or_else(|| vec![0.0; n_t]),
        coordinates,
        flow,
    };
    entries::right_hand_sides(&blocks)?;
    let exists = |file: &str| Ok(reader.present(file)?.is_some());
    announced::contradictions(folder, &manifest, &blocks, &exists)?;
    Ok(Imported {
        blocks,
        manifest,
        findings: reader.findings,
        has_rhs,
    })
}

/// The same for blocks that are in memory already: checked and remarked as if they came from a folder, a B2 that repeats B1ᵀ and an H of
/// zeros are left out.
///
/// # Errors
/// [`FolderError::Sizes`], [`FolderError::NotSquare`], [`FolderError::Empty`], [`FolderError::Extreme`], [`FolderError::Asymmetric`].
pub fn inspect_blocks(
    mut blocks: SaddleBlocks,
) -> Result<(SaddleBlocks, Vec<Finding>), FolderError> {
    for (name, block) in blocks.matrices() {
        block.map_or(Ok(()), |m| entries::matrix(&format!("{name}.mtx"), m))?;
    }
    entries::right_hand_sides(&blocks)?;
    let mut findings = Vec::new();
    let shape = |matrix: &SparseMatrix<f64>| Shape::new(matrix.rows(), matrix.cols());
    let from_a = ("A.mtx", shape(&blocks.a));
    let from_b1 = ("B1.mtx", shape(&blocks.b1));
    let (n_u, n_t) = (from_a.1.rows, from_b1.1.cols);
    square("A.mtx", from_a.1)?;
    for (file, found) in [from_a, from_b1] {
        if found.rows == 0 || found.cols == 0 {
            return Err(FolderError::Empty { file, found });
        }
    }
    expect("B1.mtx", from_b1.1, Shape::new(n_u, n_t), from_a)?;
    inspect::stiffness(&blocks.a, Symmetry::General, &blocks.b1, &mut findings)?;
    inspect::coupling(&blocks.b1, &mut findings);
    if let Some(b2) = blocks.b2.take() {
        expect("B2.mtx", shape(&b2), Shape::new(n_t, n_u), from_b1)?;
        blocks.b2 = inspect::consistency(b2, &blocks.b1, &mut findings);
    }
    if let Some(h) = blocks.h.take() {
        expect("H.mtx", shape(&h), Shape::square(n_t), from_b1)?;
        blocks.h = inspect::stabilization(h, &mut findings);
    }
    inspect::rank(&blocks.b1, blocks.h.as_ref(), &mut findings);
    if let Some(flow) = &mut blocks.flow {
        let n_p = flow.t.rows();
        let from_t = ("T.mtx", shape(&flow.t));
        square("T.mtx", from_t.1)?;
        expect("Q1.mtx", shape(&flow.q1), Shape::new(n_u, n_p), from_t)?;
        expect("Q2.mtx", shape(&flow.q2), Shape::new(n_p, n_u), from_t)?;
        inspect::flow(flow, &mut findings);
    }
    if let Some(coordinates) = &blocks.coordinates {
        rigid_body::coordinates(&blocks.a, coordinates, &mut findings);
    }
    Ok((blocks, findings))
}

fn shape_of(file: &SparseFile) -> Shape {
    Shape::new(file.matrix.rows(), file.matrix.cols())
}

/// Stops when `file` does not have the shape that another file asks for.
pub(super) fn expect(
    file: &'static str,
    found: Shape,
    expected: Shape,
    by: (&'static str, Shape),
) -> Result<(), FolderError> {
    if found == expected {
        return Ok(());
    }
    let (other, other_shape) = by;
    Err(FolderError::Sizes {
        file,
        found,
        expected,
        other,
        other_shape,
    })
}

/// Stops when a diagonal block is not square.
pub(super) fn square(file: &'static str, found: Shape) -> Result<(), FolderError> {
    if found.is_square() {
        Ok(())
    } else {
        Err(FolderError::NotSquare { file, found })
    }
}

/// Reads files one after the other and collects remarks.
struct Reader<'a> {
    folder: &'a Path,
    findings: Vec<Finding>,
}

impl Reader<'_> {
    /// The file of this name; absent is only what the folder has no entry for.
    fn present(&self, file: &str) -> Result<Option<PathBuf>, FolderError> {
        let file = self.folder.join(file);
        let entry = match std::fs::symlink_metadata(&file) {
            Ok(entry) => entry,
            Err(source) if source.kind() == ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(FolderError::Unreadable { file, source }),
        };
        let found = match std::fs::metadata(&file) {
            Ok(found) => found,
            Err(source) => {
                return Err(match std::fs::read_link(&file) {
                    Ok(target) if entry.is_symlink() => FolderError::BrokenLink { file, target },
                    _ => FolderError::Unreadable { file, source },
                });
            }
        };
        if found.is_file() {
            return Ok(Some(file));
        }
        let what = if found.is_dir() {
            "a folder"
        } else {
            "a pipe, socket or device"
        };
        Err(FolderError::NotAFile { file, what })
    }

    fn names(&self) -> Result<Vec<String>, FolderError> {
        let unreadable = |source| FolderError::Unreadable {
            file: self.folder.into(),
            source,
        };
        let mut names = Vec::new();
        for entry in std::fs::read_dir(self.folder).map_err(unreadable)? {
            names.extend(entry.map_err(unreadable)?.file_name().into_string());
        }
        names.sort();
        Ok(names)
    }

    fn manifest(&mut self) -> Result<Manifest, FolderError> {
        let Some(file) = self.present("manifest.json")? else {
            self.findings
                .push(Finding::file("manifest.json", Remark::NoManifest));
            return Ok(Manifest::default());
        };
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(source) => return Err(FolderError::Unreadable { file, source }),
        };
        serde_json::from_str(&text).map_err(|source| FolderError::Manifest { file, source })
    }

    fn sparse(&mut self, file: &'static str) -> Result<Option<SparseFile>, FolderError> {
        let Some(path) = self.present(file)? else {
            return Ok(None);
        };
        let read = read_sparse(&path)?;
        entries::matrix(file, &read.matrix)?;
        if let Some(d) = read.duplicates {
            let remark = Remark::DuplicatesSummed {
                count: d.count,
                line: d.line,
            };
            self.findings
                .push(Finding::at_entry(file, d.row - 1, d.column - 1, remark));
        }
        Ok(Some(read))
    }

    fn required(&mut self, file: &'static str) -> Result<SparseFile, FolderError> {
        if let Some(read) = self.sparse(file)? {
            return Ok(read);
        }
        let names = self.names()?;
        Err(FolderError::Missing {
            folder: self.folder.into(),
            file,
            near: (names.into_iter()).find(|name| name.eq_ignore_ascii_case(file)),
        })
    }

    fn optional(
        &mut self,
        file: &'static str,
        expected: Shape,
        by: (&'static str, Shape),
    ) -> Result<Option<fracas_operators::sparse::SparseMatrix<f64>>, FolderError> {
        let Some(read) = self.sparse(file)? else {
            return Ok(None);
        };
        expect(file, shape_of(&read), expected, by)?;
        Ok(Some(read.matrix))
    }

    fn vector(
        &mut self,
        file: &'static str,
        n: usize,
        by: (&'static str, Shape),
    ) -> Result<Option<Vec<f64>>, FolderError> {
        let Some(path) = self.present(file)? else {
            return Ok(None);
        };
        let vector = read_vector(&path)?;
        expect(file, Shape::new(vector.len(), 1), Shape::new(n, 1), by)?;
        Ok(Some(vector))
    }

    /// Q1, Q2 and T: all or none; right-hand side still empty.
    fn flow(
        &mut self,
        n_u: usize,
        from_a: (&'static str, Shape),
    ) -> Result<Option<FlowBlocks>, FolderError> {
        const FLOW: [&str; 3] = ["Q1.mtx", "Q2.mtx", "T.mtx"];
        let (mut present, mut missing) = (None, None);
        for file in FLOW {
            match self.present(file)? {
                Some(_) => present.get_or_insert(file),
                None => missing.get_or_insert(file),
            };
        }
        let Some(present) = present else {
            return Ok(None);
        };
        if let Some(missing) = missing {
            return Err(FolderError::IncompleteFlow {
                folder: self.folder.into(),
                present,
                missing,
            });
        }
        let t = self.required("T.mtx")?;
        let n_p = t.matrix.rows();
        let from_t = ("T.mtx", shape_of(&t));
        square("T.mtx", from_t.1)?;
        let q1 = self.required("Q1.mtx")?;
        let by = if q1.matrix.rows() == n_u {
            from_t
        } else {
            from_a
        };
        expect("Q1.mtx", shape_of(&q1), Shape::new(n_u, n_p), by)?;
        let q2 = self.required("Q2.mtx")?;
        let by = if q2.matrix.cols() == n_u {
            from_t
        } else {
            from_a
        };
        expect("Q2.mtx", shape_of(&q2), Shape::new(n_p, n_u), by)?;
        Ok(Some(FlowBlocks {
            q1: q1.matrix,
            q2: q2.matrix,
            t: t.matrix,
            rhs_p: Vec::new(),
        }))
    }

    fn coordinates(
        &mut self,
        n_u: usize,
    ) -> Result<Option<Vec<crate::saddle::DofCoordinate>>, FolderError> {
        let Some(path) = self.present("coords.mtx")? else {
            self.findings
                .push(Finding::file("coords.mtx", Remark::NoCoordinates));
            return Ok(None);
        };
        coordinates::from_table(&read_dense(&path)?, n_u).map(Some)
    }

    /// Matrix files that play no role, and a manifest in other letters: a misspelled name must not go unnoticed.
    fn unread(&mut self) -> Result<(), FolderError> {
        for name in self.names()? {
            let flow_only = name == "rhs_p.mtx" && self.present("T.mtx")?.is_none();
            let lower = name.to_ascii_lowercase();
            let is_alike = lower.ends_with(".mtx") || lower == "manifest.json";
            if is_alike && (flow_only || !FILES.contains(&name.as_str())) {
                self.findings.push(Finding::file(&name, Remark::NotRead));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
