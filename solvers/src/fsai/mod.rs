//! Factorized sparse approximate inverses.

use crate::{Prepare, SetupError};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `GᵀG ≈ A⁻¹`, G sparse and lower triangular.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fsai {}

impl Prepare<SparseMatrix<f64>, f64> for Fsai {
    fn prepare(&self, _a: &SparseMatrix<f64>) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        Err(SetupError::NotApplicable {
            method: "fsai",
            reason: "in work".into(),
        })
    }
}
