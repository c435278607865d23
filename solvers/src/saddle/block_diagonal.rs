//! The block-diagonal preconditioner, for MINRES.

use super::inner::Ready;
use super::method::SaddleSettings;
use super::scaling::ScaledInverse;
use super::schur::{S_D, diagonal_schur};
use super::{AugmentationChoice, InnerChoice, SaddleBlocks, T, U};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::{Field, Layout, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M = diag(Â, Ŝ, …)`, a block for every field, symmetric positive definite where they are.
///
/// - On A: `Â ≈ A`, `Ŝ ≈ S + H`, `S = BᵀA⁻¹B`. Exact parts and H = 0: eigenvalues 1, (1 ± √5)/2.
/// - On S_u: `Â ≈ A + BC⁻¹Bᵀ`, `Ŝ = C`, for a singular A too. Exact parts and H = 0: eigenvalues 1 (n_u times) and
///   −σ/(1 + σ), σ = eig(C⁻¹S); −1 for every rigid-body mode.
///
/// # Cost
/// One solve with every block.
///
/// # Source
/// M. F. Murphy, G. H. Golub, A. J. Wathen, SIAM J. Sci. Comput. 21 (2000) 1969–1972; C. Greif, D. Schötzau, ETNA 22
/// (2006) 114–121, for the augmented one.
pub struct BlockDiagonalInverse<'a> {
    layout: Layout,
    blocks: Vec<(Field, Box<dyn Preconditioner<f64> + 'a>)>,
}

impl<'a> BlockDiagonalInverse<'a> {
    /// From exact parts: `Â⁻¹` of u, `Ŝ⁻¹` of t, and those of further fields, in the order of the fields.
    pub fn new(blocks: Vec<(Field, Box<dyn Preconditioner<f64> + 'a>)>) -> Self {
        let lengths = blocks.iter().map(|(field, block)| (*field, block.size()));
        Self {
            layout: Layout::new(lengths),
            blocks,
        }
    }
}

impl Preconditioner<f64> for BlockDiagonalInverse<'_> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        for (field, block) in &self.blocks {
            let ([x_k], [y_k]) = (
                self.layout.split([*field], x),
                self.layout.split_mut([*field], y),
            );
            block.solve(x_k, y_k, work);
        }
    }

    fn work_len(&self) -> usize {
        let lengths = self.blocks.iter().map(|(_, block)| block.work_len());
        lengths.max().unwrap_or(0)
    }

    fn flops(&self) -> u64 {
        self.blocks.iter().map(|(_, block)| block.flops()).sum()
    }

    fn properties(&self) -> Properties {
        let of = self.blocks.iter().map(|(_, block)| block.properties());
        of.fold(Properties::BLIND, Properties::and)
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
            return Ok(p.inside(|p| BlockDiagonalInverse::new(vec![(U, p), (T, Box::new(c))])));
        }
        let coordinates = blocks.coordinates.as_deref();
        let p = self.inner.of_matrix(&blocks.a, coordinates)?;
        // B1ᵀ in place of B2: M stays symmetric
        let symmetric = SaddleBlocks {
            b2: None,
            ..blocks.clone()
        };
        let s = ScaledInverse::new(&diagonal_schur(&symmetric)?, direct.as_ref(), S_D)?;
        Ok(p.inside(|p| BlockDiagonalInverse::new(vec![(U, p), (T, Box::new(s))])))
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
