//! The local certificate of the inf-sup constant, without an assembled A.

use super::pieces::{PiecesError, nodes_of};
use crate::contact::Coupling;
use crate::elasticity::diagonals_at;
use crate::mesh::Places;
use crate::system::StickSystem;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::saddle::SaddleBlocks;
use fracas_solvers::spectrum::{AroundFractures, Certificate, certificate};

impl StickSystem<'_> {
    /// A bound of the inf-sup constant from the elements around the fractures, `A ⪯ Σ ω_e diag(A_e)`, `ω_e ≥ λ_max(diag(A_e)⁻¹A_e)`: no element
    /// elsewhere counts, however stiff or flat; `None` without fractures.
    ///
    /// # Cost
    /// Some 10 µs per element at a fracture, and that of [`AroundFractures::certificate`]; memory of some vectors on the fractures.
    ///
    /// # Errors
    /// [`PiecesError`] of an element without stiffness, or for NaN.
    pub fn certificate(&self) -> Result<Option<Certificate>, PiecesError> {
        self.certificate_with(self.stabilization().as_ref())
    }

    fn certificate_with(
        &self,
        h: Option<&SparseMatrix<f64>>,
    ) -> Result<Option<Certificate>, PiecesError> {
        let nodes = Places::new(self.mesh.nodes.len(), nodes_of(&self.fractures.faces));
        let [diagonal, above] = diagonals_at(&nodes, self.mesh, self.materials)?;
        let b = Coupling::on(&nodes, self.fractures, self.constraints);
        let inverse: Vec<f64> = diagonal.iter().map(|d| d.recip()).collect();
        let mut c_0 = vec![0.0; 3 * self.fractures.faces.len()];
        b.add_weighted_squares(&inverse, &mut c_0);
        let around = AroundFractures {
            b: &b,
            h,
            diagonal: &diagonal,
            above: &above,
            c_0: &c_0,
        };
        Ok(around.certificate()?)
    }

    /// The same, or that of the matrix `A ⪯ ω diag(A)`, whichever is sharper: nearly incompressible rock has elements of larger ω than all of
    /// them together, and stiff or flat cells elsewhere a larger one than those at the fractures. `blocks` are those of this system.
    ///
    /// # Errors
    /// As [`certificate`](Self::certificate).
    pub fn certificate_beside(
        &self,
        blocks: &SaddleBlocks,
    ) -> Result<Option<Certificate>, PiecesError> {
        let of_matrix = certificate(blocks)?;
        let own = self.certificate_with(blocks.h.as_ref())?;
        Ok(own.map(|own| own.or(of_matrix)))
    }
}
