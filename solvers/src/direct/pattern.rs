//! The pattern that was analysed, and the checks at the door of a numeric factorization.

use crate::SetupError;
use fracas_operators::Shape;
use fracas_operators::sparse::SparseMatrix;

/// The block that errors name; callers rename it with [`SetupError::in_block`].
pub(super) const BLOCK: &str = "A";

/// Offsets and indices of a compressed matrix, in the word size that the backends use.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pattern {
    /// Where an outer vector begins; one more entry than there are outer vectors.
    pub(super) offsets: Vec<usize>,
    /// Inner indices.
    pub(super) indices: Vec<usize>,
}

impl Pattern {
    /// The stored pattern, by rows or columns as `a` is.
    ///
    /// # Errors
    /// [`SetupError::Shape`] unless `a` is square.
    pub(super) fn of(a: &SparseMatrix<f64>) -> Result<Self, SetupError> {
        if a.rows() != a.cols() {
            return Err(SetupError::Shape {
                block: BLOCK,
                found: Shape::new(a.rows(), a.cols()),
                expected: Shape::square(a.rows()),
                reason: "a factorization needs a square matrix",
            });
        }
        Ok(Self {
            offsets: a.proper_indptr().into_owned(),
            indices: a.indices().iter().map(|j| *j as usize).collect(),
        })
    }

    /// Unknowns.
    pub(super) fn size(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Values of a matrix that has this pattern and finite entries.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] for another pattern, [`SetupError::NotFinite`] for NaN or infinity.
    pub(super) fn values<'a>(
        &self,
        a: &'a SparseMatrix<f64>,
        method: &'static str,
    ) -> Result<&'a [f64], SetupError> {
        let same = a.rows() == self.size()
            && a.cols() == self.size()
            && *a.proper_indptr() == *self.offsets
            && a.indices()
                .iter()
                .map(|j| *j as usize)
                .eq(self.indices.iter().copied());
        if !same {
            return Err(SetupError::NotApplicable {
                method,
                reason: "the matrix has another pattern than the analysed one; analyze it again"
                    .to_owned(),
            });
        }
        match a.data().iter().position(|v| !v.is_finite()) {
            None => Ok(a.data()),
            Some(k) => {
                let outer = self.offsets.partition_point(|&o| o <= k) - 1;
                let inner = self.indices[k];
                let (row, column) = if a.is_csr() {
                    (outer, inner)
                } else {
                    (inner, outer)
                };
                Err(SetupError::NotFinite {
                    block: BLOCK,
                    row: row + 1,
                    column: column + 1,
                    value: a.data()[k],
                })
            }
        }
    }
}
