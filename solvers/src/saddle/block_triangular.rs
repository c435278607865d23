//! The block-triangular preconditioner.

use super::inner::Ready;
use super::method::SaddleSettings;
use super::schur::diagonal_schur_inverse;
use super::{InnerChoice, SaddleBlocks, T, U};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Layout, LinearOperator, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M = [Â B1; 0 −Ŝ]`, `Â ≈ A`, `Ŝ ≈ H + B2A⁻¹B1`. Exact parts: (M⁻¹𝒜 − I)² = 0, so GMRES ends after two steps.
///
/// # Cost
/// One solve with Â, one with Ŝ, one product with B1.
///
/// # Source
/// M. F. Murphy, G. H. Golub, A. J. Wathen, SIAM J. Sci. Comput. 21 (2000) 1969–1972; I. C. F. Ipsen, SIAM J. Sci.
/// Comput. 23 (2001) 1050–1051, for H ≠ 0.
pub struct BlockTriangularInverse<P, S> {
    b1: Csr<f64>,
    p: P,
    s: S,
    layout: Layout,
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> BlockTriangularInverse<P, S> {
    /// From exact parts: B1, Â⁻¹ and Ŝ⁻¹.
    pub fn new(b1: SparseMatrix<f64>, p: P, s: S) -> Self {
        assert_eq!(b1.rows(), p.size(), "rows of B1 and size of A");
        assert_eq!(b1.cols(), s.size(), "columns of B1 and size of S");
        let layout = Layout::new([(U, b1.rows()), (T, b1.cols())]);
        Self {
            b1: Csr::new(b1),
            p,
            s,
            layout,
        }
    }
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> Preconditioner<f64>
    for BlockTriangularInverse<P, S>
{
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        let (v_u, work) = work.split_at_mut(x_u.len());
        // y_t = −Ŝ⁻¹ x_t
        self.s.solve(x_t, y_t, work);
        y_t.iter_mut().for_each(|y| *y = -*y);
        // y_u = Â⁻¹ (x_u − B1 y_t)
        v_u.copy_from_slice(x_u);
        self.b1.apply_add(-1.0, y_t, v_u, &mut []);
        self.p.solve(v_u, y_u, work);
    }

    fn work_len(&self) -> usize {
        self.layout.length(U) + self.p.work_len().max(self.s.work_len())
    }

    fn flops(&self) -> u64 {
        self.p.flops() + self.s.flops() + self.b1.flops()
    }

    fn properties(&self) -> Properties {
        let parts = self.p.properties().and(self.s.properties());
        parts.and(Properties::BLIND)
    }
}

/// Settings of the block-triangular preconditioner: `Ŝ = H + B2 diag(A)⁻¹B1`, factorized.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BlockTriangular {
    /// Â⁻¹.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
}

impl SaddleSettings for BlockTriangular {
    fn name(&self) -> &'static str {
        "block_triangular"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        let coordinates = blocks.coordinates.as_deref();
        let p = self.inner.of_matrix(&blocks.a, coordinates)?;
        let s = diagonal_schur_inverse(blocks, DirectChoice::default())?;
        Ok(p.inside(|p| BlockTriangularInverse::new(blocks.b1.clone(), p, s)))
    }

    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        Some(&mut self.inner)
    }
}
