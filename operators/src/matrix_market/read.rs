//! Reading: header, then the body in blocks, then rows.

use super::blocks::{Failure, header};
use super::diagnose::{diagnose, repeated};
use super::error::{Defect, MatrixMarketError};
use super::header::{Header, Layout, Symmetry};
use super::{array, assemble};
use crate::sparse::SparseMatrix;
use crate::{Dense, Shape};
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

/// Entries that a coordinate file lists more than once; they are summed, as the format prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Duplicates {
    /// Surplus entries.
    pub count: usize,
    /// Line of the first one, counted from 1.
    pub line: usize,
    /// Its row, counted from 1.
    pub row: usize,
    /// Its column, counted from 1.
    pub column: usize,
}

/// A sparse matrix as read, with what the file said about it.
#[derive(Clone, Debug)]
pub struct SparseFile {
    /// The full matrix by rows (both triangles); explicit zeros of a coordinate file are kept.
    pub matrix: SparseMatrix<f64>,
    /// What the banner declares.
    pub symmetry: Symmetry,
    /// Entries listed more than once, if any.
    pub duplicates: Option<Duplicates>,
}

/// What the header of a file announces; the body may hold something else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Announced {
    /// Rows and columns.
    pub shape: Shape,
    /// Entries listed.
    pub entries: usize,
}

/// Reads banner and sizes only.
///
/// # Errors
/// What is wrong with them, with the line.
pub fn read_sizes(path: &Path) -> Result<Announced, MatrixMarketError> {
    read(path, |file| {
        let (header, _) = header(file)?;
        Ok(Announced {
            shape: Shape::new(header.rows, header.columns),
            entries: header.expected(),
        })
    })
}

/// Reads a sparse matrix; an `array` file gives its nonzero entries.
///
/// # Cost
/// A coordinate file is read twice, by all threads of the pool; in memory are the rows, 4 bytes for each of them, and about
/// 16 MB of text and entries on their way. An array file is held as dense values first.
///
/// # Errors
/// Every [`Defect`], with the line.
pub fn read_sparse(path: &Path) -> Result<SparseFile, MatrixMarketError> {
    read(path, sparse_from)
}

/// Reads a matrix densely, from either layout.
///
/// # Errors
/// Every [`Defect`], with the line.
pub fn read_dense(path: &Path) -> Result<Dense<f64>, MatrixMarketError> {
    read(path, dense_from)
}

/// Reads a matrix of one column as a vector, from either layout.
///
/// # Errors
/// Every [`Defect`], with the line; [`Defect::NotAVector`] for more than one column.
pub fn read_vector(path: &Path) -> Result<Vec<f64>, MatrixMarketError> {
    read(path, |file| {
        let (found, _) = header(file)?;
        let (rows, columns) = (found.rows, found.columns);
        if columns != 1 {
            let defect = Defect::NotAVector { rows, columns };
            return Err(Failure::Content(found.size_line, defect));
        }
        dense_from(file).map(Dense::into_columns)
    })
}

/// Opens a file and names it in errors.
fn read<T>(
    path: &Path,
    content: impl FnOnce(&mut File) -> Result<T, Failure>,
) -> Result<T, MatrixMarketError> {
    let io = |source| MatrixMarketError::Io {
        file: path.into(),
        source,
    };
    content(&mut File::open(path).map_err(io)?).map_err(|failure| match failure {
        Failure::Io(source) => io(source),
        Failure::Content(line, defect) => MatrixMarketError::Content {
            file: path.into(),
            line,
            defect,
        },
        Failure::Undiagnosed => io(std::io::Error::other("the file could not be read")),
    })
}

pub(super) fn sparse_from(source: &mut (impl Read + Seek)) -> Result<SparseFile, Failure> {
    let (header, body) = header(source)?;
    let symmetry = header.symmetry;
    let (matrix, duplicates) = match header.layout {
        Layout::Array => (array::nonzeros(&array_from(source, &header, body)?), None),
        Layout::Coordinate { .. } => {
            let rows = assemble::rows(source, &header, body);
            let (matrix, repeats) = rows.map_err(|f| diagnosed(f, source, &header, body))?;
            let duplicates = match repeats {
                true => repeated(source, &header, body, &matrix)?,
                false => None,
            };
            (matrix, duplicates)
        }
    };
    Ok(SparseFile {
        matrix,
        symmetry,
        duplicates,
    })
}

pub(super) fn dense_from(source: &mut (impl Read + Seek)) -> Result<Dense<f64>, Failure> {
    let (header, body) = header(source)?;
    if header.layout == Layout::Array {
        return array_from(source, &header, body);
    }
    let sparse = sparse_from(source)?.matrix;
    let mut dense = Dense::zeros(Shape::new(sparse.rows(), sparse.cols()));
    for (value, (i, j)) in &sparse {
        *dense.entry_mut(i as usize, j as usize) = *value;
    }
    Ok(dense)
}

fn array_from(
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
) -> Result<Dense<f64>, Failure> {
    array::dense(source, header, body).map_err(|f| diagnosed(f, source, header, body))
}

/// Finds the line of a defect.
fn diagnosed(
    failure: Failure,
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
) -> Failure {
    match failure {
        Failure::Undiagnosed => diagnose(source, header, body),
        other => other,
    }
}
