//! What iterating and judging need of a system, assembled or not.

use fracas::elasticity::{Restricted, matrix_free};
use fracas::matrix_free::{Magnitude, MatrixFreeSaddle};
use fracas::scene::Body;
use fracas_operators::sparse::CsrView;
use fracas_operators::{AdjointOperator, LinearOperator};
use fracas_solvers::saddle::{EnergyNorms, SaddleBlocks, SaddleOperator};

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
    fn norms<'s>(&'s self, strain: &'s dyn Fn(&[f64]) -> f64, own: bool) -> EnergyNorms<'s>;

    /// `‖u‖_A`, u with the prescribed displacements in their places.
    fn strain_norm(&self, u: &[f64]) -> f64;
}

/// Assembled blocks.
pub(super) struct Assembled<'a> {
    blocks: &'a SaddleBlocks,
    operator: SaddleOperator<'a>,
    h: Option<CsrView<'a, f64>>,
    /// A in full numbering, where displacements are prescribed.
    displaced: Option<Restricted<Box<dyn AdjointOperator<f64>>>>,
}

impl<'a> Assembled<'a> {
    /// The blocks, and the body that they are of.
    pub(super) fn new(blocks: &'a SaddleBlocks, body: Option<&Body>) -> anyhow::Result<Self> {
        let displaced = |body: &&Body| {
            let mut values = body.constraints.prescribed().iter();
            values.any(|(_, u)| *u != 0.0)
        };
        let displaced = match body.filter(displaced) {
            Some(body) => {
                let full = matrix_free::<f64>(&body.mesh, &body.materials)?;
                Some(Restricted::new(full, body.constraints.clone()))
            }
            None => None,
        };
        Ok(Self {
            blocks,
            operator: SaddleOperator::new(blocks),
            h: blocks.h.as_ref().map(CsrView::new),
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

    fn norms<'s>(&'s self, strain: &'s dyn Fn(&[f64]) -> f64, own: bool) -> EnergyNorms<'s> {
        let h = self.h.as_ref().map(|h| h as &dyn LinearOperator<f64>);
        let diagonal = match &self.blocks.h {
            Some(h) => (0..h.rows())
                .map(|i| h.get(i, i).copied().unwrap_or(0.0))
                .collect(),
            None => Vec::new(),
        };
        let c = self.blocks.contact_compliance();
        EnergyNorms::new(&self.operator, h, c, &diagonal)
            .against((own && self.displaced.is_some()).then_some(strain))
    }

    fn strain_norm(&self, u: &[f64]) -> f64 {
        (self.displaced.as_ref()).map_or(0.0, |a| a.strain_norm(u))
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

    fn norms<'s>(&'s self, strain: &'s dyn Fn(&[f64]) -> f64, own: bool) -> EnergyNorms<'s> {
        let displaced = self.saddle.stiffness().is_displaced();
        let strain = (own && displaced).then_some(strain);
        self.saddle.energy_norms(&self.magnitude, strain)
    }

    fn strain_norm(&self, u: &[f64]) -> f64 {
        self.saddle.stiffness().strain_norm(u)
    }
}
