//! The blocks of a generalized saddle point, with what is known about them.

use crate::smoothers::entries::finite_entries;
use crate::{DofCoordinate, SetupError};
use fracas_operators::Shape;
use fracas_operators::sparse::SparseMatrix;

/// The blocks that fracture flow adds: `[A B1 Q1; B2 −H 0; Q2 0 T]`.
#[derive(Clone, Debug)]
pub struct FlowBlocks {
    /// n_u × n_p, pressure opens the fracture.
    pub q1: SparseMatrix<f64>,
    /// n_p × n_u, change of volume.
    pub q2: SparseMatrix<f64>,
    /// n_p × n_p, transmissibility and stabilization.
    pub t: SparseMatrix<f64>,
    /// Right-hand side of the mass balance.
    pub rhs_p: Vec<f64>,
}

impl FlowBlocks {
    /// True where displacements change volumes: without an open face Q2 = 0 and S_p = T.
    pub fn is_coupled(&self) -> bool {
        self.q2.data().iter().any(|v| *v != 0.0)
    }
}

/// `𝒜 = [A B1; B2 −H]` by assembled blocks, all in CSR.
#[derive(Clone, Debug)]
pub struct SaddleBlocks {
    /// n_u × n_u stiffness, symmetric positive semi-definite.
    pub a: SparseMatrix<f64>,
    /// n_u × n_t force coupling.
    pub b1: SparseMatrix<f64>,
    /// n_t × n_u consistency coupling; `None` means B1ᵀ.
    pub b2: Option<SparseMatrix<f64>>,
    /// n_t × n_t stabilization; `None` means 0. The (2,2) block of 𝒜 is −H.
    pub h: Option<SparseMatrix<f64>>,
    /// Right-hand side of equilibrium.
    pub rhs_u: Vec<f64>,
    /// Right-hand side of the contact rows.
    pub rhs_t: Vec<f64>,
    /// Where the displacement unknowns live, if known.
    pub coordinates: Option<Vec<DofCoordinate>>,
    /// Flow, if any.
    pub flow: Option<FlowBlocks>,
}

impl SaddleBlocks {
    /// Displacement unknowns.
    pub fn n_u(&self) -> usize {
        self.a.rows()
    }

    /// Traction unknowns.
    pub fn n_t(&self) -> usize {
        self.b1.cols()
    }

    /// Pressure unknowns.
    pub fn n_p(&self) -> usize {
        self.flow.as_ref().map_or(0, |f| f.t.rows())
    }

    /// A, B1, B2, H, Q1, Q2 and T by name; `None` for one that there is not.
    pub(super) fn matrices(&self) -> [(&'static str, Option<&SparseMatrix<f64>>); 7] {
        let flow = self.flow.as_ref();
        [
            ("A", Some(&self.a)),
            ("B1", Some(&self.b1)),
            ("B2", self.b2.as_ref()),
            ("H", self.h.as_ref()),
            ("Q1", flow.map(|flow| &flow.q1)),
            ("Q2", flow.map(|flow| &flow.q2)),
            ("T", flow.map(|flow| &flow.t)),
        ]
    }

    /// The right-hand sides by name; `None` for that of pressures where there are none.
    pub(super) fn right_hand_sides(&self) -> [(&'static str, Option<&[f64]>); 3] {
        let flow = self.flow.as_ref();
        [
            ("rhs_u", Some(&self.rhs_u)),
            ("rhs_t", Some(&self.rhs_t)),
            ("rhs_p", flow.map(|flow| flow.rhs_p.as_slice())),
        ]
    }

    /// Diagonal entry i of H.
    pub(crate) fn h_ii(&self, i: usize) -> f64 {
        let entry = self.h.as_ref().and_then(|h| h.get(i, i).copied());
        entry.unwrap_or(0.0)
    }

    /// B2 by rows, also where it is B1ᵀ.
    pub fn b2_rows(&self) -> SparseMatrix<f64> {
        match &self.b2 {
            Some(b2) => b2.clone(),
            None => self.b1.transpose_view().to_csr(),
        }
    }

    /// Checks that the shapes of A, B1, B2, H and of Q1, Q2, T fit, that the blocks are stored by rows and hold no NaN.
    ///
    /// # Errors
    /// [`SetupError::Shape`] or [`SetupError::NotFinite`] naming the block, row and column.
    pub fn check(&self) -> Result<(), SetupError> {
        let (n_u, n_t, n_p) = (self.n_u(), self.n_t(), self.n_p());
        let mut matrices = self.matrices();
        // T says how many pressures there are
        matrices[4..].rotate_right(1);
        for (block, matrix) in matrices {
            let Some(matrix) = matrix else { continue };
            let (expected, reason) = match block {
                "A" => (Shape::square(n_u), "A is square"),
                "B1" => (Shape::new(n_u, n_t), "B1 has a row for every row of A"),
                "B2" => (Shape::new(n_t, n_u), "B2 has the shape of B1ᵀ"),
                "H" => (Shape::square(n_t), "H has a row for every column of B1"),
                "Q1" => (
                    Shape::new(n_u, n_p),
                    "Q1 has a row for every row of A and a column for every row of T",
                ),
                "Q2" => (Shape::new(n_p, n_u), "Q2 has the shape of Q1ᵀ"),
                "T" => (Shape::square(n_p), "T is square"),
                other => unreachable!("block {other} has no shape"),
            };
            let found = Shape::new(matrix.rows(), matrix.cols());
            if found != expected {
                return Err(SetupError::Shape {
                    block,
                    found,
                    expected,
                    reason,
                });
            }
            if !matrix.is_csr() {
                return Err(SetupError::NotApplicable {
                    method: "a saddle point stored by columns",
                    reason: format!("block {block} must be in compressed rows"),
                });
            }
            finite_entries(block, matrix)?;
        }
        Ok(())
    }
}
