//! Sparse matrices and tables from numpy arrays, which are copied: the library owns what it works on.

use crate::error::{Kind, raise};
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::DofCoordinate;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// Compressed rows as Python hands them over: `(rows, columns, starts i64, columns i32, values f64)`.
#[derive(FromPyObject)]
pub(crate) struct Rows<'py>(
    usize,
    usize,
    PyReadonlyArray1<'py, i64>,
    PyReadonlyArray1<'py, i32>,
    PyReadonlyArray1<'py, f64>,
);

impl Rows<'_> {
    /// A copy of our own; `name` is what messages call it.
    ///
    /// # Cost
    /// 12 bytes per entry.
    pub(crate) fn matrix(&self, name: &str) -> PyResult<SparseMatrix<f64>> {
        let Self(rows, columns, starts, indices, values) = self;
        let wrong = |what: String| raise(Kind::System, format!("{name}: {what}"));
        let contiguous = |_| wrong("its arrays are not contiguous".into());
        let starts = starts.as_slice().map_err(contiguous)?;
        let indices = indices.as_slice().map_err(contiguous)?;
        let values = values.as_slice().map_err(contiguous)?;
        if let Some(k) = values.iter().position(|v| !v.is_finite()) {
            let row = starts.partition_point(|start| *start as usize <= k);
            let column = indices.get(k).map_or(0, |j| i64::from(*j) + 1);
            return Err(wrong(format!(
                "it holds {} at row {row}, column {column} (counted from 1)",
                values[k]
            )));
        }
        let starts: Result<Vec<usize>, _> = starts.iter().map(|s| usize::try_from(*s)).collect();
        let starts = starts.map_err(|_| wrong("indptr has a negative entry".into()))?;
        let indices: Result<Vec<u32>, _> = indices.iter().map(|j| u32::try_from(*j)).collect();
        let indices = indices.map_err(|_| wrong("indices have a negative entry".into()))?;
        let shape = (*rows, *columns);
        SparseMatrix::try_new(shape, starts, indices, values.to_vec())
            .map_err(|(_, _, _, error)| wrong(error.to_string()))
    }
}

/// A vector of n entries, all of them numbers.
pub(crate) fn vector(name: &str, v: &PyReadonlyArray1<'_, f64>, n: usize) -> PyResult<Vec<f64>> {
    let v = v
        .to_vec()
        .map_err(|error| raise(Kind::Input, error.to_string()))?;
    if v.len() != n {
        return Err(raise(
            Kind::Input,
            format!("{name} has {} entries, expected {n}", v.len()),
        ));
    }
    match v.iter().position(|v| !v.is_finite()) {
        Some(i) => Err(raise(
            Kind::Input,
            format!("{name} holds {} at entry {i} (counted from 0)", v[i]),
        )),
        None => Ok(v),
    }
}

/// Rows `x y z component`.
pub(crate) fn coordinates(table: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<DofCoordinate>> {
    let table = table.as_array();
    let rows = table.rows().into_iter().enumerate();
    rows.map(|(i, row)| {
        let component = [0.0, 1.0, 2.0].iter().position(|c| *c == row[3]);
        let wrong = || {
            raise(
                Kind::System,
                format!(
                    "coordinates: component {} in row {i} (counted from 0): it is 0, 1 or 2",
                    row[3]
                ),
            )
        };
        Ok(DofCoordinate {
            position: [row[0], row[1], row[2]],
            component: component.ok_or_else(wrong)? as u8,
        })
    })
    .collect()
}

/// A vector as a numpy array, which takes over its memory.
pub(crate) fn given<'py, T: numpy::Element>(py: Python<'py>, v: Vec<T>) -> Bound<'py, PyArray1<T>> {
    PyArray1::from_vec(py, v)
}

/// The same as a table with so many columns.
pub(crate) fn table<'py, T: numpy::Element>(
    py: Python<'py>,
    v: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'py, PyAny>> {
    let rows = v.len() / columns;
    Ok(given(py, v).reshape([rows, columns])?.into_any())
}
