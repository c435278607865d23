//! 𝒜 as one matrix for a sparse direct solver.

use super::SaddleBlocks;
use super::inner::Ready;
use super::method::SaddleSettings;
use crate::SetupError;
use crate::direct::{DirectChoice, Kind};
use fracas_operators::Preconditioner;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M⁻¹ = 𝒜⁻¹` by a sparse LU factorization of 𝒜, flow included.
///
/// # Errors
/// [`SetupError::Singular`] naming the row of 𝒜; [`SetupError::NotApplicable`] from CHOLMOD, which factorizes definite
/// matrices only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Direct {
    /// Who factorizes.
    pub backend: DirectChoice,
}

impl SaddleSettings for Direct {
    fn name(&self) -> &'static str {
        "direct"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        let matrix = blocks.assembled();
        let factors = self
            .backend
            .solver()?
            .analyze(&matrix, Kind::General)?
            .factor(&matrix)
            .map_err(|error| error.in_block("[A B1; B2 −H]"))?;
        Ok((factors as Box<dyn Preconditioner<f64>>).into())
    }

    fn takes_flow(&self) -> bool {
        true
    }

    fn takes_local_rows(&self) -> bool {
        true
    }
}
