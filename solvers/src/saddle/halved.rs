//! A saddle point whose symmetric A is kept by half, for RACP around algebraic multigrid.

use super::Stiffness;
use super::{
    EnergyNorms, InnerChoice, Racp, Ready, SaddleBlocks, SaddleMethod, SaddleOperator, SaddleSystem,
};
use crate::SetupError;
use crate::amg::HalvedMatrix;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Layout, LinearOperator};
use std::borrow::Cow;

/// `𝒜 = [A B; Bᵀ −H]` with half of A in 3×3 blocks of nodes, and the rows of A that C is made from: those that B reaches.
///
/// # Cost
/// A takes a third of the memory of its rows.
pub struct HalvedBlocks {
    a: HalvedMatrix,
    /// A has no other rows than those of B.
    near: SaddleBlocks,
    stiffness: Stiffness,
}

impl HalvedBlocks {
    /// True where half of A is enough: C is local, S̃_u is algebraic multigrid, 𝒜 is symmetric and of two fields, with coordinates, and
    /// A does not spread over the digits of f32.
    pub fn serves(blocks: &SaddleBlocks, method: &SaddleMethod) -> bool {
        let serves =
            |racp: &Racp| matches!(racp.inner, InnerChoice::Amg(_)) && racp.augmentation.is_local();
        matches!(method, SaddleMethod::Racp(racp) if serves(racp))
            && blocks.b2.is_none()
            && blocks.flow.is_none()
            && blocks.coordinates.is_some()
            && !blocks.stiffness().exceeds_single()
    }

    /// The same system; the rows of A are given back before its half is made.
    ///
    /// # Errors
    /// [`SetupError`] as [`SaddleBlocks::check`].
    pub fn new(blocks: SaddleBlocks) -> Result<Self, SetupError> {
        assert!(
            blocks.b2.is_none() && blocks.flow.is_none(),
            "two fields, B2 = Bᵀ"
        );
        blocks.check()?;
        let stiffness = blocks.stiffness();
        let near = rows_of(&blocks.a, &blocks.b1);
        let SaddleBlocks { a, .. } = blocks;
        let a = HalvedMatrix::new(a, blocks.coordinates.as_deref())?;
        let near = SaddleBlocks { a: near, ..blocks };
        Ok(Self { a, near, stiffness })
    }

    /// M⁻¹ of a method that it [`serves`](Self::serves).
    ///
    /// # Errors
    /// [`SetupError`] of C or of S̃_u; [`SetupError::NotApplicable`] for another method.
    pub fn ready(&self, method: &SaddleMethod) -> Result<Ready, SetupError> {
        match method {
            SaddleMethod::Racp(
                racp @ Racp {
                    inner: InnerChoice::Amg(amg),
                    ..
                },
            ) => racp.around(&self.near, |f| amg.build_halved(&self.a, f)),
            other => Err(SetupError::NotApplicable {
                method: other.name(),
                reason: "it needs all of A, of which half is in memory".to_owned(),
            }),
        }
    }

    /// 𝒜, ready for products.
    pub fn system(&self) -> HalvedSystem<'_> {
        HalvedSystem {
            blocks: self,
            operator: SaddleOperator::with_a(&self.near, &self.a),
        }
    }
}

/// The rows of A that are no zeros of B.
fn rows_of(a: &SparseMatrix<f64>, b: &SparseMatrix<f64>) -> SparseMatrix<f64> {
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for (a, b) in a.outer_iterator().zip(b.outer_iterator()) {
        if b.nnz() > 0 {
            columns.extend(a.indices());
            values.extend(a.data());
        }
        offsets.push(columns.len());
    }
    SparseMatrix::new(a.shape(), offsets, columns, values)
}

/// [`HalvedBlocks`] with what products with Bᵀ need.
pub struct HalvedSystem<'a> {
    blocks: &'a HalvedBlocks,
    operator: SaddleOperator<'a>,
}

impl SaddleSystem for HalvedSystem<'_> {
    fn operator(&self) -> &dyn LinearOperator<f64> {
        &self.operator
    }

    fn layout(&self) -> Layout {
        self.blocks.near.layout()
    }

    fn has_short_recurrences(&self) -> bool {
        // as of assembled blocks: the iteration does not depend on how A is kept
        false
    }

    fn norm_inf(&self) -> f64 {
        let HalvedBlocks { a, near, .. } = self.blocks;
        near.norm_inf_with(|sums| a.add_row_sums(sums))
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        self.blocks.near.contact_scale(x, b)
    }

    fn norms(&self, _own: bool) -> EnergyNorms<'_> {
        let HalvedBlocks {
            near, stiffness, ..
        } = self.blocks;
        let c = near.contact_compliance();
        EnergyNorms::new(&self.operator, near.h.as_ref(), c, Cow::Borrowed(stiffness))
            .with_b1(&near.b1)
    }
}
