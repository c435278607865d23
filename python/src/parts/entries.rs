//! C as Python gives it.

use crate::arrays::Rows;
use faer::Mat;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::AugmentationMatrix;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

/// C as Python gives it.
pub(super) enum Entries {
    Diagonal(Vec<f64>),
    Faces(Vec<f64>),
    Dense(Mat<f64>),
    Sparse(SparseMatrix<f64>),
}

impl Entries {
    pub(super) fn of(answer: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (kind, entries): (String, Bound<'_, PyAny>) = answer.extract()?;
        let one = || -> PyResult<Vec<f64>> {
            let entries: PyReadonlyArray1<'_, f64> = entries.extract()?;
            Ok(entries.as_slice()?.to_vec())
        };
        Ok(match kind.as_str() {
            "diagonal" => Self::Diagonal(one()?),
            "faces" => Self::Faces(one()?),
            "dense" => {
                let table: PyReadonlyArray2<'_, f64> = entries.extract()?;
                let table = table.as_array();
                Self::Dense(Mat::from_fn(table.nrows(), table.ncols(), |i, j| {
                    table[[i, j]]
                }))
            }
            _ => Self::Sparse(entries.extract::<Rows<'_>>()?.matrix("C")?),
        })
    }

    /// C times a factor.
    pub(super) fn matrix(mut self, factor: f64) -> Result<AugmentationMatrix, SetupError> {
        let scale = |v: &mut f64| *v *= factor;
        match &mut self {
            Self::Diagonal(c) | Self::Faces(c) => c.iter_mut().for_each(scale),
            Self::Dense(c) => *c *= faer::Scale(factor),
            Self::Sparse(c) => c.data_mut().iter_mut().for_each(scale),
        }
        match self {
            Self::Diagonal(c) => AugmentationMatrix::from_diagonal(c),
            Self::Faces(c) => {
                let block =
                    |c: &[f64; 9]| [[c[0], c[1], c[2]], [c[3], c[4], c[5]], [c[6], c[7], c[8]]];
                AugmentationMatrix::from_face_blocks(c.as_chunks().0.iter().map(block).collect())
            }
            Self::Dense(c) => AugmentationMatrix::from_dense(c),
            Self::Sparse(c) => AugmentationMatrix::from_sparse(c),
        }
    }
}
