//! Entries in file order → rows, with mirrored triangles and summed duplicates: two passes over the file, and nothing in
//! memory but the rows.

use super::blocks::{Failure, each_piece};
use super::diagnose::{MOST_ENTRIES, changed};
use super::header::{Header, Symmetry};
use super::parse::{Entry, entries, places};
use crate::sparse::SparseMatrix;
use rayon::prelude::*;
use std::io::{Read, Seek};

/// Rows of a coordinate file, and whether any entry was listed more than once (or with its mirror image).
///
/// # Cost
/// The matrix and 4 bytes per row.
pub(super) fn rows(
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
) -> Result<(SparseMatrix<f64>, bool), Failure> {
    let starts = starts(source, header, body)?;
    let mut rows = fill(source, header, body, starts)?;
    let repeated = rows.sort();
    if repeated {
        rows.add_up();
    }
    let shape = (header.rows, header.columns);
    let matrix = SparseMatrix::new(shape, rows.starts, rows.columns, rows.values);
    Ok((matrix, repeated))
}

/// The factor of the mirror image, if there is one.
fn mirror(header: &Header) -> Option<f64> {
    match header.symmetry {
        Symmetry::General => None,
        Symmetry::Symmetric => Some(1.0),
        Symmetry::Skew => Some(-1.0),
    }
}

/// First pass: where every row begins.
fn starts(
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
) -> Result<Vec<usize>, Failure> {
    let mirrored = mirror(header).is_some();
    let (mut found, mut lengths) = (0, Vec::<usize>::new());
    let mut count = |row: u32| {
        // a size is not believed before the entries are there
        if row as usize >= lengths.len() {
            lengths.resize(row as usize + 1, 0);
        }
        lengths[row as usize] += 1;
    };
    each_piece(
        source,
        body,
        |piece| places(header, piece),
        |piece| {
            found += piece.len();
            for [row, column] in piece {
                count(*row);
                if mirrored && row != column {
                    count(*column);
                }
            }
            Ok(())
        },
    )?;
    if found != header.expected() || found >= MOST_ENTRIES {
        return Err(Failure::Undiagnosed);
    }
    let mut starts = lengths;
    starts.resize(header.rows + 1, 0);
    let mut sum = 0;
    for start in &mut starts {
        sum += std::mem::replace(start, sum);
    }
    Ok(starts)
}

/// Rows with entries in the order of the file.
struct Rows {
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

/// Second pass: every entry into its row.
fn fill(
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
    starts: Vec<usize>,
) -> Result<Rows, Failure> {
    let sign = mirror(header);
    let nnz = starts[header.rows];
    let (mut columns, mut values) = (vec![0_u32; nnz], vec![0.0; nnz]);
    let mut filled = vec![0_u32; header.rows];
    let length = |row: usize| starts[row + 1] - starts[row];
    let mut put = |row: u32, column: u32, value: f64| {
        let row = row as usize;
        let place = filled[row] as usize;
        if place >= length(row) {
            return Err(changed());
        }
        columns[starts[row] + place] = column;
        values[starts[row] + place] = value;
        filled[row] += 1;
        Ok(())
    };
    each_piece(
        source,
        body,
        |piece| entries(header, piece),
        |piece| {
            for &Entry { row, column, value } in piece {
                put(row, column, value)?;
                match sign {
                    Some(sign) if row != column => put(column, row, sign * value)?,
                    Some(-1.0) if value != 0.0 => return Err(Failure::Undiagnosed),
                    _ => {}
                }
            }
            Ok(())
        },
    )?;
    if (0..header.rows).any(|row| filled[row] as usize != length(row)) {
        return Err(changed());
    }
    Ok(Rows {
        starts,
        columns,
        values,
    })
}

/// Rows that one task sorts.
const ROWS: usize = 1 << 12;

impl Rows {
    /// Sorts every row by columns, equal ones in the order of the file; true when there are equal ones.
    fn sort(&mut self) -> bool {
        let Self {
            starts,
            columns,
            values,
        } = self;
        let (mut columns, mut values) = (&mut columns[..], &mut values[..]);
        let rows = starts.len() - 1;
        let mut tasks = Vec::with_capacity(rows / ROWS + 1);
        for first in (0..rows).step_by(ROWS) {
            let starts = &starts[first..=(first + ROWS).min(rows)];
            let len = starts[starts.len() - 1] - starts[0];
            let (own_columns, other_columns) = columns.split_at_mut(len);
            let (own_values, other_values) = values.split_at_mut(len);
            (columns, values) = (other_columns, other_values);
            tasks.push((starts, own_columns, own_values));
        }
        let equal = tasks.into_par_iter().map(|(starts, columns, values)| {
            let mut pairs = Vec::new();
            let mut equal = false;
            for range in starts.windows(2) {
                let range = range[0] - starts[0]..range[1] - starts[0];
                equal |= sort_row(&mut columns[range.clone()], &mut values[range], &mut pairs);
            }
            equal
        });
        equal.reduce(|| false, |a, b| a | b)
    }

    /// Adds equal neighbours in the order of the file and closes the gaps.
    fn add_up(&mut self) {
        let mut end = 0;
        let mut from = self.starts[0];
        for i in 1..self.starts.len() {
            let to = self.starts[i];
            let first = end;
            for k in from..to {
                if end > first && self.columns[end - 1] == self.columns[k] {
                    self.values[end - 1] += self.values[k];
                } else {
                    self.columns[end] = self.columns[k];
                    self.values[end] = self.values[k];
                    end += 1;
                }
            }
            from = to;
            self.starts[i] = end;
        }
        self.columns.truncate(end);
        self.columns.shrink_to_fit();
        self.values.truncate(end);
        self.values.shrink_to_fit();
    }
}

/// Sorts one row; true when it has equal columns.
fn sort_row(columns: &mut [u32], values: &mut [f64], pairs: &mut Vec<(u32, f64)>) -> bool {
    if columns.is_sorted_by(|a, b| a < b) {
        return false;
    }
    pairs.clear();
    pairs.extend(columns.iter().copied().zip(values.iter().copied()));
    pairs.sort_by_key(|pair| pair.0);
    for (k, pair) in pairs.iter().enumerate() {
        (columns[k], values[k]) = *pair;
    }
    columns.windows(2).any(|pair| pair[0] == pair[1])
}
