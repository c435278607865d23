//! The block-diagonal preconditioner, for MINRES.

use super::inner::Ready;
use super::method::SaddleSettings;
use super::scaling::ScaledInverse;
use super::schur::{S_D, diagonal_schur};
use super::{AugmentationChoice, InnerChoice, SaddleBlocks};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::{Layout, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M = diag(Â, Ŝ)`, symmetric positive definite where Â and Ŝ are.
///
/// - On A: `Â ≈ A`, `Ŝ ≈ S + H`, `S = BᵀA⁻¹B`. Exact parts and H = 0: eigenvalues 1, (1 ± √5)/2.
/// - On S_u: `Â ≈ A + BC⁻¹Bᵀ`, `Ŝ = C`, for a singular A too. Exact parts and H = 0: eigenvalues 1 (n_u times) and
///   −σ/(1 + σ), σ = eig(C⁻¹S); −1 for every rigid-body mode.
///
/// # Cost
/// One solve with Â and one with Ŝ.
///
/// # Source
/// M. F. Murphy, G. H. Golub, A. J. Wathen, SIAM J. Sci. Comput. 21 (2000) 1969–1972; C. Greif, D. Schötzau, ETNA 22
/// (2006) 114–121, for the augmented one.
pub struct BlockDiagonalInverse<P, S> {
    p: P,
    s: S,
    layout: Layout<2>,
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> BlockDiagonalInverse<P, S> {
    /// From exact parts: Â⁻¹ and Ŝ⁻¹.
    pub fn new(p: P, s: S) -> Self {
        let layout = Layout::new(["u", "t"], [p.size(), s.size()]);
        Self { p, s, layout }
    }
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> Preconditioner<f64>
    for BlockDiagonalInverse<P, S>
{
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split(x);
        let [y_u, y_t] = self.layout.split_mut(y);
        // y_u = Â⁻¹ x_u
        self.p.solve(x_u, y_u, work);
        // y_t = Ŝ⁻¹ x_t
        self.s.solve(x_t, y_t, work);
    }

    fn work_len(&self) -> usize {
        self.p.work_len().max(self.s.work_len())
    }

    fn flops(&self) -> u64 {
        self.p.flops() + self.s.flops()
    }

    fn properties(&self) -> Properties {
        self.p.properties().and(self.s.properties())
    }
}

/// Settings of the block-diagonal preconditioner.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BlockDiagonal {
    /// Absent: on A, with `Ŝ = H + Bᵀ diag(A)⁻¹B` factorized; given: on S_u with this C for Ŝ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub augmentation: Option<AugmentationChoice>,
    /// Â⁻¹.
    #[serde(deserialize_with = "crate::saddle::inner::name_or_settings")]
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
}

impl SaddleSettings for BlockDiagonal {
    fn name(&self) -> &'static str {
        "block_diagonal"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        let direct = DirectChoice::default().solver()?;
        if let Some(choice) = self.augmentation {
            let c = choice.compute(blocks, direct.as_ref())?.matrix;
            let p = self.inner.prepare(blocks, &c)?;
            return Ok(p.inside(|p| BlockDiagonalInverse::new(p, c)));
        }
        let coordinates = blocks.coordinates.as_deref();
        let p = self.inner.of_matrix(&blocks.a, coordinates)?;
        // B1ᵀ in place of B2: M stays symmetric
        let symmetric = SaddleBlocks {
            b2: None,
            ..blocks.clone()
        };
        let s = ScaledInverse::new(&diagonal_schur(&symmetric)?, direct.as_ref(), S_D)?;
        Ok(p.inside(|p| BlockDiagonalInverse::new(p, s)))
    }

    fn augmentation(&self) -> Option<AugmentationChoice> {
        self.augmentation
    }

    fn set_augmentation(&mut self, c: AugmentationChoice) -> bool {
        self.augmentation = Some(c);
        true
    }

    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        Some(&mut self.inner)
    }
}

#[cfg(test)]
mod tests;
