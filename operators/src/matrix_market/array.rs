//! Arrays: values column after column.

use super::blocks::{Failure, each_piece};
use super::header::{Header, Symmetry};
use super::parse::values;
use crate::sparse::SparseMatrix;
use crate::{Dense, LinearOperator, Shape};
use std::io::{Read, Seek};

/// The full matrix of an array file.
pub(super) fn dense(
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
) -> Result<Dense<f64>, Failure> {
    let mut listed: Vec<f64> = Vec::new();
    each_piece(
        source,
        body,
        |piece| values(header, piece),
        |piece| {
            listed.extend_from_slice(piece);
            Ok(())
        },
    )?;
    if listed.len() != header.expected() {
        return Err(Failure::Undiagnosed);
    }
    let shape = Shape::new(header.rows, header.columns);
    let sign = match header.symmetry {
        Symmetry::General => return Ok(Dense::from_columns(shape, listed)),
        Symmetry::Symmetric => 1.0,
        Symmetry::Skew => -1.0,
    };
    let mut dense = Dense::zeros(shape);
    let mut next = listed.into_iter();
    for j in 0..header.columns {
        for (i, value) in (header.first_row(j)..header.rows).zip(&mut next) {
            *dense.entry_mut(j, i) = sign * value;
            *dense.entry_mut(i, j) = value;
        }
    }
    Ok(dense)
}

/// The nonzero entries by rows.
pub(super) fn nonzeros(dense: &Dense<f64>) -> SparseMatrix<f64> {
    let Shape { rows, cols } = dense.shape();
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in 0..rows {
        for j in 0..cols {
            let value = dense.entry(i, j);
            if value != 0.0 {
                columns.push(j as u32);
                values.push(value);
            }
        }
        starts.push(columns.len());
    }
    SparseMatrix::new((rows, cols), starts, columns, values)
}
