//! Arrays that show memory of ours without a copy: the only file of this crate that asks for `unsafe`.
#![allow(unsafe_code)]

use fracas_operators::sparse::SparseMatrix;
use numpy::ndarray::ArrayView1;
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// Memory that lives, in one place and unchanged, as long as a Python object.
pub(crate) trait Keeps {
    /// The matrix of this name, if there is one.
    fn matrix(&self, name: &str) -> Option<&SparseMatrix<f64>>;
}

/// A read-only array over `slice`, which keeps `owner` alive.
///
/// # Safety
/// `slice` lives in one place and unchanged as long as `owner`.
unsafe fn view<'py, T: Element>(owner: &Bound<'py, PyAny>, slice: &[T]) -> Bound<'py, PyArray1<T>> {
    let shown = ArrayView1::from(slice);
    // SAFETY: that of this function; the array is made read-only before anybody sees it
    let array = unsafe { PyArray1::borrow_from_array(&shown, owner.clone()) };
    array.readwrite().make_nonwriteable();
    array
}

/// `(rows, columns, starts u64, columns u32, values f64)` of a matrix that a frozen object keeps, without a copy.
pub(crate) fn rows<'py, K>(
    owner: &Bound<'py, K>,
    name: &str,
) -> PyResult<Option<Bound<'py, PyTuple>>>
where
    K: pyo3::PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Keeps + Sync,
{
    let Some(matrix) = owner.get().matrix(name) else {
        return Ok(None);
    };
    let any = owner.as_any();
    let starts: Vec<i64> = (matrix.indptr().raw_storage().iter())
        .map(|start| *start as i64)
        .collect();
    // SAFETY: a frozen object hands out no `&mut`, so that what it keeps stays where and what it is until it goes, and the array
    // holds a reference to it
    let (columns, values) = unsafe { (view(any, matrix.indices()), view(any, matrix.data())) };
    let starts = PyArray1::from_vec(owner.py(), starts);
    let parts = (matrix.rows(), matrix.cols(), starts, columns, values);
    Ok(Some(parts.into_pyobject(owner.py())?))
}
