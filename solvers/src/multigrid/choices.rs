//! What both hierarchies let their settings choose.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What smooths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Smoother {
    /// Gauss–Seidel, or FSAI where the matrix is made of chains of nodes along which no aggregates are made (nearly incompressible
    /// rock; flat cells without coordinates, or coarsened classically): there Gauss–Seidel by nodes smooths along the chains only.
    #[default]
    Auto,
    /// Symmetric Gauss–Seidel by nodes: forward before, backward after the coarse correction.
    GaussSeidel,
    /// Chebyshev polynomial in block Jacobi.
    Chebyshev,
    /// Damped factorized sparse approximate inverse.
    Fsai,
}

impl Smoother {
    /// Plain name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::GaussSeidel => "gauss_seidel",
            Self::Chebyshev => "chebyshev",
            Self::Fsai => "fsai",
        }
    }
}

/// Scalars of the hierarchy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 32 bits: half the memory traffic; the iteration around it is in f64.
    #[default]
    F32,
    /// 64 bits.
    F64,
}
