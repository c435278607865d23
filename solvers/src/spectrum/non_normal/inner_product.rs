//! Inner products in which the departure from normality is measured.

use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::{Elimination, SaddleBlocks};
use crate::spectrum::product::energy_scales;
use faer::Mat;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is a length: `‖x‖² = xᵀ G x`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InnerProduct {
    /// `G = diag(A + B D⁻¹Bᵀ, C_0 + H)`, `C_0 = diag(B1ᵀ diag(A)⁻¹B1)`, `D = C_0 + diag H`: the energies in which errors are judged. It
    /// depends neither on units nor on the method. Rows with a law of their own (slip, opening) have no H there, and where C_0 + H is not SPD
    /// all the same D takes its place; pressures have the weights `diag(Q1ᵀ diag(A)⁻¹Q1) + |diag T|`.
    #[default]
    Energy,
    /// `G = I`, for unknowns in the units of the system: metres beside pascals for one of ours.
    Euclidean,
}

impl InnerProduct {
    /// G in a formula.
    pub const fn formula(self) -> &'static str {
        match self {
            Self::Energy => "energy: diag(A + B D^-1 B^T, C_0 + H)",
            Self::Euclidean => "Euclidean, in the units of the system",
        }
    }

    /// L of `G = L Lᵀ`; `None` for G = I.
    ///
    /// # Cost
    /// n_u³/3 + n_t³/3 flops, a matrix of n².
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] where `A + B D⁻¹Bᵀ` is not positive definite.
    pub(super) fn factor(self, blocks: &SaddleBlocks) -> Result<Option<Mat<f64>>, SetupError> {
        if self == Self::Euclidean {
            return Ok(None);
        }
        let (n_u, n_t, n) = (blocks.n_u(), blocks.n_t(), blocks.size());
        let weights = Weights::new(blocks);
        let mut g_u = dense::to_dense(&blocks.a);
        dense::symmetrize(&mut g_u);
        let b = dense::to_dense(&blocks.b1);
        let scaled = Mat::from_fn(n_u, n_t, |i, k| b[(i, k)] / weights.total[k]);
        g_u += dense::multiply(scaled.as_ref(), b.transpose());
        let l_u = dense::cholesky(g_u).map_err(|row| SetupError::NotApplicable {
            method: "the energy inner product",
            reason: format!(
                "A + B D⁻¹Bᵀ is not positive definite (row {}); take the Euclidean one",
                row + 1
            ),
        })?;
        let is_own = |i: usize| weights.own[i];
        let mut g_t = match &blocks.h {
            Some(h) => {
                let h = dense::to_dense(h);
                Mat::from_fn(n_t, n_t, |i, j| match is_own(i) || is_own(j) {
                    true => 0.0,
                    false => h[(i, j)],
                })
            }
            None => Mat::zeros(n_t, n_t),
        };
        dense::symmetrize(&mut g_t);
        for (k, c_0) in weights.c_0.iter().enumerate() {
            g_t[(k, k)] += c_0;
        }
        let l_t = dense::cholesky(g_t).unwrap_or_else(|_| {
            Mat::from_fn(n_t, n_t, |i, j| match i == j {
                true => weights.total[i].sqrt(),
                false => 0.0,
            })
        });
        let pressures = energy_scales(blocks, &weights.total);
        let size = |i: usize| match pressures[i] {
            0.0 => 1.0,
            scale => scale,
        };
        Ok(Some(Mat::from_fn(n, n, |i, j| match (i, j) {
            _ if i < n_u && j < n_u => l_u[(i, j)],
            _ if i >= n_u && j >= n_u && i < n_u + n_t && j < n_u + n_t => l_t[(i - n_u, j - n_u)],
            _ if i == j => size(i),
            _ => 0.0,
        })))
    }
}

/// Diagonals of the compliance of tractions; 1 where nothing is coupled.
struct Weights {
    /// `C_0`.
    c_0: Vec<f64>,
    /// `D = C_0 + diag H`, without the H of rows with a law of their own.
    total: Vec<f64>,
    /// Which rows those are.
    own: Vec<bool>,
}

impl Weights {
    fn new(blocks: &SaddleBlocks) -> Self {
        let n_t = blocks.n_t();
        let c_0 = blocks.contact_compliance();
        let mut own = vec![false; n_t];
        if let Some(eliminated) = Elimination::new(blocks) {
            eliminated.rows().iter().for_each(|k| own[*k] = true);
        }
        let of_h = |k: usize| {
            let h = blocks.h.as_ref().and_then(|h| h.get(k, k)).copied();
            if own[k] {
                0.0
            } else {
                h.unwrap_or(0.0).max(0.0)
            }
        };
        let of_h: Vec<f64> = (0..n_t).map(of_h).collect();
        let total = c_0.iter().zip(&of_h).map(|(c, h)| c + h).collect();
        Self { c_0, total, own }
    }
}
