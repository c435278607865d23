//! The blocks of a generalized saddle point, with what is known about them.

use fracas_operators::sparse::SparseMatrix;

/// Where a displacement unknown lives: position in metres and component 0–2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DofCoordinate {
    /// Position of the node [m].
    pub position: [f64; 3],
    /// Direction x, y, z = 0, 1, 2.
    pub component: u8,
}

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
}
