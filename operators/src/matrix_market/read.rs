//! Reading: header, then the body in parallel pieces, then rows.

use super::assemble::{self, Entry};
use super::error::{Defect, MatrixMarketError};
use super::header::{Field, Header, Layout, Symmetry, parse_header};
use super::lines::{Lines, is_blank, pieces, shorten, word};
use crate::sparse::{SparseMatrix, Triplets};
use crate::{Dense, Shape};
use rayon::prelude::*;
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

/// Reads a sparse matrix; an `array` file gives its nonzero entries.
///
/// # Cost
/// The file is held in memory once; all threads of the pool parse. 16 million entries: a few seconds.
///
/// # Errors
/// Every [`Defect`], with the line.
pub fn read_sparse(path: &Path) -> Result<SparseFile, MatrixMarketError> {
    let bytes = load(path)?;
    sparse_from(&bytes).map_err(|(line, defect)| content(path, line, defect))
}

/// Reads a matrix densely, from either layout.
///
/// # Errors
/// Every [`Defect`], with the line.
pub fn read_dense(path: &Path) -> Result<Dense<f64>, MatrixMarketError> {
    let bytes = load(path)?;
    dense_from(&bytes).map_err(|(line, defect)| content(path, line, defect))
}

/// Reads a matrix of one column as a vector, from either layout.
///
/// # Errors
/// Every [`Defect`], with the line; [`Defect::NotAVector`] for more than one column.
pub fn read_vector(path: &Path) -> Result<Vec<f64>, MatrixMarketError> {
    let bytes = load(path)?;
    let result = parse_header(&mut Lines::new(&bytes)).and_then(|h| match h.columns {
        1 => dense_from(&bytes),
        columns => Err((
            h.size_line,
            Defect::NotAVector {
                rows: h.rows,
                columns,
            },
        )),
    });
    result
        .map(|dense| dense.values().to_vec())
        .map_err(|(line, defect)| content(path, line, defect))
}

fn load(path: &Path) -> Result<Vec<u8>, MatrixMarketError> {
    std::fs::read(path).map_err(|source| MatrixMarketError::Io {
        file: path.into(),
        source,
    })
}

fn content(path: &Path, line: usize, defect: Defect) -> MatrixMarketError {
    MatrixMarketError::Content {
        file: path.into(),
        line,
        defect,
    }
}

pub(super) fn sparse_from(bytes: &[u8]) -> Result<SparseFile, (usize, Defect)> {
    let (mut file, layout) = assembled(bytes)?;
    if layout == Layout::Array {
        file.matrix = without_zeros(&file.matrix);
    }
    Ok(file)
}

/// The same rows without explicit zeros.
fn without_zeros(matrix: &SparseMatrix<f64>) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new(matrix.shape());
    for (value, (i, j)) in matrix {
        if *value != 0.0 {
            triplets.add_triplet(i as usize, j as usize, *value);
        }
    }
    triplets.to_csr()
}

fn assembled(bytes: &[u8]) -> Result<(SparseFile, Layout), (usize, Defect)> {
    let mut lines = Lines::new(bytes);
    let header = parse_header(&mut lines)?;
    let entries = body(&header, &lines)?;
    let (matrix, duplicates) =
        assemble::rows(&header, &entries).map_err(|(k, defect)| (line_of(&lines, k), defect))?;
    let duplicates = duplicates.map(|d| Duplicates {
        count: d.count,
        line: line_of(&lines, d.first),
        row: entries[d.first].row as usize + 1,
        column: entries[d.first].column as usize + 1,
    });
    let symmetry = header.symmetry;
    Ok((
        SparseFile {
            matrix,
            symmetry,
            duplicates,
        },
        header.layout,
    ))
}

pub(super) fn dense_from(bytes: &[u8]) -> Result<Dense<f64>, (usize, Defect)> {
    let sparse = assembled(bytes)?.0.matrix;
    let mut dense = Dense::zeros(Shape::new(sparse.rows(), sparse.cols()));
    for (value, (i, j)) in &sparse {
        *dense.entry_mut(i as usize, j as usize) = *value;
    }
    Ok(dense)
}

/// Line of the k-th entry of the body.
fn line_of(body: &Lines<'_>, k: usize) -> usize {
    let mut lines = body.clone();
    let mut seen = 0;
    for line in lines.by_ref() {
        if !is_blank(line) {
            if seen == k {
                break;
            }
            seen += 1;
        }
    }
    lines.number()
}

/// Entries of the body in the order of the file.
fn body(header: &Header, lines: &Lines<'_>) -> Result<Vec<Entry>, (usize, Defect)> {
    let expected = header.expected();
    let parts: Vec<Part> = match header.layout {
        Layout::Coordinate { .. } => pieces(lines.rest())
            .par_iter()
            .map(|p| coordinate_piece(header, p))
            .collect(),
        Layout::Array => vec![array_body(header, lines.rest())],
    };
    let mut first_line = lines.number();
    let mut entries = Vec::with_capacity(parts.iter().map(|p| p.entries.len()).sum());
    for part in parts {
        entries.extend_from_slice(&part.entries);
        if let Some(defect) = part.defect {
            return Err((first_line + part.lines, defect));
        }
        first_line += part.lines;
    }
    match entries.len() {
        found if found < expected => Err((first_line, Defect::Truncated { expected, found })),
        found if found > expected => Err((
            line_of(lines, expected),
            Defect::TooMany { expected, found },
        )),
        _ => Ok(entries),
    }
}

/// What one thread read: up to the first defect, which lies in the last of `lines`.
struct Part {
    entries: Vec<Entry>,
    lines: usize,
    defect: Option<Defect>,
}

fn coordinate_piece(header: &Header, piece: &[u8]) -> Part {
    let mut entries = Vec::with_capacity(piece.len() / 24);
    let mut lines = Lines::new(piece);
    let mut defect = None;
    for line in lines.by_ref() {
        if is_blank(line) {
            continue;
        }
        match coordinate_entry(header, line) {
            Ok(entry) => entries.push(entry),
            Err(d) => {
                defect = Some(d);
                break;
            }
        }
    }
    Part {
        entries,
        lines: lines.number(),
        defect,
    }
}

fn coordinate_entry(header: &Header, line: &[u8]) -> Result<Entry, Defect> {
    let mut rest = line;
    let (row, column, value) = (word(&mut rest), word(&mut rest), word(&mut rest));
    let bad = || Defect::Entry {
        expected: "row column value",
        found: shorten(line),
    };
    if value.is_empty() || !word(&mut rest).is_empty() {
        return Err(bad());
    }
    let row = index(row).ok_or_else(bad)?;
    let column = index(column).ok_or_else(bad)?;
    let (rows, columns) = (header.rows, header.columns);
    if row == 0 || column == 0 || row > rows as u64 || column > columns as u64 {
        return Err(Defect::OutOfRange {
            row,
            column,
            rows,
            columns,
        });
    }
    // Both fit: sizes are limited to 32 bits.
    let value = number(header.field, value, row as usize, column as usize)?;
    Ok(Entry {
        row: (row - 1) as u32,
        column: (column - 1) as u32,
        value,
    })
}

/// Values column after column: all rows, or from the diagonal (symmetric) or below it (skew) downwards.
fn array_body(header: &Header, body: &[u8]) -> Part {
    let first = |j: usize| match header.symmetry {
        Symmetry::General => 0,
        Symmetry::Symmetric => j,
        Symmetry::Skew => j + 1,
    };
    let (mut entries, mut lines, mut defect) = (Vec::new(), Lines::new(body), None);
    let (mut i, mut j) = (first(0), 0);
    'lines: for line in lines.by_ref() {
        if is_blank(line) {
            continue;
        }
        let mut rest = line;
        let value = word(&mut rest);
        if !word(&mut rest).is_empty() {
            defect = Some(Defect::Entry {
                expected: "value",
                found: shorten(line),
            });
            break 'lines;
        }
        while i >= header.rows && j < header.columns {
            j += 1;
            i = first(j);
        }
        match number(header.field, value, i + 1, j + 1) {
            // Surplus values are kept as entries of the last place so that the caller counts them.
            Ok(value) => entries.push(Entry {
                row: i as u32,
                column: j as u32,
                value,
            }),
            Err(d) => {
                defect = Some(d);
                break 'lines;
            }
        }
        i += 1;
    }
    Part {
        entries,
        lines: lines.number(),
        defect,
    }
}

/// A row or column as written; digits only.
fn index(word: &[u8]) -> Option<u64> {
    let digits = word.strip_prefix(b"+").unwrap_or(word);
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0_u64, |n, b| {
        b.is_ascii_digit()
            .then(|| n.saturating_mul(10).saturating_add(u64::from(b - b'0')))
    })
}

fn number(field: Field, word: &[u8], row: usize, column: usize) -> Result<f64, Defect> {
    let text = std::str::from_utf8(word).unwrap_or("");
    let parsed = match field {
        Field::Integer => text.parse::<i64>().ok().map(|n| n as f64),
        // Fortran writes 1.5D+03.
        Field::Real => text
            .parse()
            .ok()
            .or_else(|| text.replace(['d', 'D'], "e").parse().ok()),
    };
    match parsed {
        Some(value) if f64::is_finite(value) => Ok(value),
        Some(_) => Err(Defect::NotFinite {
            value: shorten(word),
            row,
            column,
        }),
        None => Err(Defect::Value {
            value: shorten(word),
            field: field.word(),
            row,
            column,
        }),
    }
}
