//! S_u where pressures act.

use crate::SetupError;
use crate::saddle::elimination::rows_of;
use crate::saddle::{AugmentationMatrix, FlowBlocks};
use fracas_operators::sparse::SparseMatrix;

/// Rows and columns of `S_u = A + B C⁻¹ Bᵀ` at displacements that pressures move and that change the volume of open faces.
///
/// # Cost
/// Entries of A between these rows; S_u is not assembled elsewhere.
#[derive(Clone, Debug)]
pub struct NearSchur {
    /// Rows of S_u, ascending.
    rows: Vec<usize>,
    /// S_u restricted to them.
    s_u: SparseMatrix<f64>,
}

impl NearSchur {
    /// The rows that [`PressureSchur`](super::PressureSchur) needs: where columns of Q1 act that T couples with a row of Q2, and where
    /// these rows act; none where Q2 = 0.
    pub fn rows(flow: &FlowBlocks) -> Vec<usize> {
        let mut is_near = vec![false; flow.q1.rows()];
        let mut is_neighbour = vec![false; flow.t.rows()];
        for i in coupled(flow) {
            entries(&flow.q2, i).for_each(|(row, _)| is_near[row] = true);
            is_neighbour[i] = true;
            entries(&flow.t, i).for_each(|(j, _)| is_neighbour[j] = true);
        }
        for (value, (row, j)) in &flow.q1 {
            is_near[row as usize] |= *value != 0.0 && is_neighbour[j as usize];
        }
        (0..is_near.len()).filter(|&row| is_near[row]).collect()
    }

    /// From A, B and C, as they are without eliminated rows.
    ///
    /// # Errors
    /// Those of a root of C⁻¹.
    pub fn new(
        rows: Vec<usize>,
        (a, b): (&SparseMatrix<f64>, &SparseMatrix<f64>),
        c: &AugmentationMatrix,
    ) -> Result<Self, SetupError> {
        let near = |m: &SparseMatrix<f64>| rows_of(m, &rows);
        let across: SparseMatrix<f64> = near(a).transpose_view().to_csr();
        let f = &near(b) * &c.inverse_root()?;
        let augmentation = &f * &f.transpose_view().to_csr();
        Ok(Self {
            s_u: &near(&across) + &augmentation,
            rows,
        })
    }

    /// Its row of S_u.
    pub(super) fn row(&self, near: usize) -> usize {
        self.rows[near]
    }

    /// How many rows.
    pub(super) fn len(&self) -> usize {
        self.rows.len()
    }

    /// A diagonal entry of S_u.
    pub(super) fn diagonal(&self, near: usize) -> f64 {
        self.s_u.get(near, near).copied().unwrap_or(0.0)
    }

    /// S_u between these rows.
    pub(super) fn matrix(&self) -> &SparseMatrix<f64> {
        &self.s_u
    }

    /// `(Q1ᵀ, Q2)` in the numbers of these rows.
    pub(super) fn couplings(&self, flow: &FlowBlocks) -> [SparseMatrix<f64>; 2] {
        let transposed = |m: &SparseMatrix<f64>| -> SparseMatrix<f64> {
            rows_of(m, &self.rows).transpose_view().to_csr()
        };
        [
            transposed(&flow.q1),
            transposed(&flow.q2.transpose_view().to_csr()),
        ]
    }
}

/// Rows of Q2 that hold anything.
pub(super) fn coupled(flow: &FlowBlocks) -> Vec<usize> {
    let holds = |i: &usize| entries(&flow.q2, *i).next().is_some();
    (0..flow.q2.rows()).filter(holds).collect()
}

/// Entries of a row that are not zero.
pub(super) fn entries(m: &SparseMatrix<f64>, row: usize) -> impl Iterator<Item = (usize, f64)> {
    let range = m.indptr().outer_inds_sz(row);
    let (columns, values) = (&m.indices()[range.clone()], &m.data()[range]);
    let entries = columns.iter().zip(values);
    (entries.filter(|(_, v)| **v != 0.0)).map(|(j, v)| (*j as usize, *v))
}
