//! What iterating and judging need of a system, assembled or not.

use fracas::elasticity::{Restricted, matrix_free};
use fracas::matrix_free::{Magnitude, MatrixFreeSaddle};
use fracas::scene::Body;
use fracas_operators::{AdjointOperator, LinearOperator};
use fracas_solvers::saddle::{EnergyNorms, SaddleBlocks, SaddleOperator, StrainNorm};
use std::borrow::Cow;

/// A system `𝒜 x = b` without a right-hand side.
pub(super) trait Equations {
    /// 𝒜.
    fn operator(&self) -> &dyn LinearOperator<f64>;

    /// n_u, n_t, n_p.
    fn lengths(&self) -> [usize; 3];

    /// 𝒜 = 𝒜ᵀ, and its preconditioner is symmetric, too.
    fn is_symmetric(&self) -> bool;

    /// `‖𝒜‖_∞`, or a lower bound close to it.
    fn norm_inf(&self) -> f64;

    /// `|B1|ᵀ|u| + |b_t|`.
    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64>;

    /// Norms of errors in u and t; `own` where the right-hand side is that of the system, with its prescribed displacements.
    fn norms(&self, own: bool) -> EnergyNorms<'_>;
}

/// Assembled blocks.
pub(super) struct Assembled<'a> {
    blocks: &'a SaddleBlocks,
    operator: SaddleOperator<'a>,
    /// A in full numbering, where displacements are prescribed.
    displaced: Option<Restricted<Box<dyn AdjointOperator<f64>>>>,
}

impl<'a> Assembled<'a> {
    /// The blocks, and the body that they are of.
    pub(super) fn new(blocks: &'a SaddleBlocks, body: Option<&Body>) -> anyhow::Result<Self> {
        let displaced = match body.filter(|body| body.constraints.is_displaced()) {
            Some(body) => {
                let full = matrix_free::<f64>(&body.mesh, &body.materials)?;
                Some(Restricted::new(full, body.constraints.clone()))
            }
            None => None,
        };
        Ok(Self {
            blocks,
            operator: SaddleOperator::new(blocks),
            displaced,
        })
    }
}

impl Equations for Assembled<'_> {
    fn operator(&self) -> &dyn LinearOperator<f64> {
        &self.operator
    }

    fn lengths(&self) -> [usize; 3] {
        [self.blocks.n_u(), self.blocks.n_t(), self.blocks.n_p()]
    }

    fn is_symmetric(&self) -> bool {
        // not every method of the list is
        false
    }

    fn norm_inf(&self) -> f64 {
        self.blocks.norm_inf()
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        let [n_u, n_t, _] = self.lengths();
        let mut scale: Vec<f64> = b[n_u..n_u + n_t].iter().map(|b| b.abs()).collect();
        for (row, u) in self.blocks.b1.outer_iterator().zip(&x[..n_u]) {
            row.iter().for_each(|(j, b)| scale[j] += (b * u).abs());
        }
        scale
    }

    fn norms(&self, own: bool) -> EnergyNorms<'_> {
        let c = self.blocks.contact_compliance();
        let strain = |a| -> StrainNorm<'_> { Box::new(move |u| Restricted::strain_norm(a, u)) };
        let displaced = self.displaced.as_ref().filter(|_| own);
        let stiffness = Cow::Owned(self.blocks.stiffness());
        EnergyNorms::new(&self.operator, self.blocks.h.as_ref(), c, stiffness)
            .against(displaced.map(strain))
            .with_entries(self.blocks)
    }
}

/// No assembled A.
pub(super) struct MatrixFree {
    pub(super) saddle: MatrixFreeSaddle<f64>,
    /// Sizes of A and B.
    pub(super) magnitude: Magnitude,
}

impl Equations for MatrixFree {
    fn operator(&self) -> &dyn LinearOperator<f64> {
        &self.saddle
    }

    fn lengths(&self) -> [usize; 3] {
        let [n_u, n_t] = self.saddle.layout().lengths;
        [n_u, n_t, 0]
    }

    fn is_symmetric(&self) -> bool {
        true
    }

    fn norm_inf(&self) -> f64 {
        self.saddle.norm_inf_from_below(self.magnitude.stiffest)
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        self.saddle.contact_scale(x, b)
    }

    fn norms(&self, own: bool) -> EnergyNorms<'_> {
        let a = self.saddle.stiffness();
        let strain = || -> StrainNorm<'_> { Box::new(|u| a.strain_norm(u)) };
        let displaced = own && a.is_displaced();
        let strain = displaced.then(strain);
        self.saddle.energy_norms(&self.magnitude, strain)
    }
}
