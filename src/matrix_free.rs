//! The saddle point of a body without a single assembled matrix but H.

use crate::contact::Coupling;
use crate::elasticity::{ElasticityError, Restricted, matrix_free};
use crate::system::StickSystem;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Adjoint, AdjointOperator, BlockOperator, Layout, Real};

/// `[A B; Bᵀ −H]` over the free displacements and the tractions: A cell by cell, B face by face, H by its few entries.
///
/// Equal to the assembled blocks up to rounding (`tests/matrix_free.rs`).
///
/// # Cost
/// Memory: O(cells) numbers instead of the 243 entries per node of an assembled A.
pub struct MatrixFreeSaddle<R> {
    a: Restricted<Box<dyn AdjointOperator<R>>>,
    b: Coupling<R>,
    transpose: Adjoint<Coupling<R>>,
    h: Option<Csr<R>>,
}

impl<R: Real> MatrixFreeSaddle<R> {
    /// The operator of `system`.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn new(system: &StickSystem<'_>) -> Result<Self, ElasticityError> {
        let full = matrix_free::<R>(system.mesh, system.materials)?;
        let b = Coupling::new(system.fractures, system.constraints);
        let h = system.stabilization().map(|h| Csr::new(rounded(&h)));
        Ok(Self {
            a: Restricted::new(full, system.constraints.clone()),
            transpose: Adjoint(b.clone()),
            b,
            h,
        })
    }

    /// n_u and n_t.
    pub fn layout(&self) -> Layout<2> {
        use fracas_operators::LinearOperator;
        let shape = self.b.shape();
        Layout::new(["u", "t"], [shape.rows, shape.cols])
    }

    /// `[A B; Bᵀ −H]`; H = 0 costs nothing.
    pub fn operator(&self) -> BlockOperator<'_, R, 2> {
        let one = R::one();
        let h = self.h.as_ref().map(|h| (-one, h as _));
        BlockOperator::new(
            self.layout(),
            [
                [Some((one, &self.a)), Some((one, &self.b))],
                [Some((one, &self.transpose)), h],
            ],
        )
    }
}

/// The matrix in precision `R`.
fn rounded<R: Real>(h: &SparseMatrix<f64>) -> SparseMatrix<R> {
    h.map(|value| R::of(*value))
}
