//! The approximation of S_u⁻¹ inside RACP: the one list of all of them.

use super::{AugmentationMatrix, SaddleBlocks, schur};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Which `S̃_u⁻¹`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InnerChoice {
    /// S_u⁻¹ by a sparse factorization.
    Exact {
        /// Who factorizes.
        #[serde(default)]
        backend: DirectChoice,
    },
    /// `S̃_u = diag(S_u)`.
    Jacobi,
    /// `S̃_u = (D + L) D⁻¹ (D + Lᵀ)`, `S_u = L + D + Lᵀ`.
    Ssor,
}

impl Default for InnerChoice {
    fn default() -> Self {
        Self::Exact {
            backend: DirectChoice::default(),
        }
    }
}

impl InnerChoice {
    /// Plain name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact { .. } => "exact",
            Self::Jacobi => "jacobi",
            Self::Ssor => "ssor",
        }
    }

    /// `S̃_u⁻¹` for these blocks and this C.
    pub fn prepare(
        self,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let s_u = || schur::primal_schur(&blocks.a, &blocks.b1, c);
        match self {
            Self::Exact { backend } => schur::exact_inverse(blocks, c, backend.solver()?.as_ref()),
            Self::Jacobi => Ok(Box::new(DiagonalScaling::new(&s_u()?)?)),
            Self::Ssor => Ok(Box::new(SymmetricSweep::new(s_u()?)?)),
        }
    }
}
