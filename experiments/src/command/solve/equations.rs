//! What iterating and judging need of a system, assembled or not.

use fracas::matrix_free::MatrixFreeSaddle;
use fracas_operators::LinearOperator;
use fracas_solvers::saddle::{SaddleBlocks, SaddleOperator};

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
}

/// Assembled blocks.
pub(super) struct Assembled<'a> {
    pub(super) blocks: &'a SaddleBlocks,
    pub(super) operator: SaddleOperator<'a>,
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
}

/// No assembled A.
pub(super) struct MatrixFree {
    pub(super) saddle: MatrixFreeSaddle<f64>,
    /// Row of A with the largest diagonal entry.
    pub(super) stiffest: usize,
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
        self.saddle.norm_inf_from_below(self.stiffest)
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        self.saddle.contact_scale(x, b)
    }
}
