//! The approximation of S_u⁻¹ inside RACP: the one list of all of them.

use super::{AugmentationMatrix, SaddleBlocks, schur};
use crate::direct::DirectChoice;
use crate::smoothers::{Jacobi, Ssor};
use crate::{Prepare, SetupError};
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
    /// Damped Jacobi of S_u.
    Jacobi(Jacobi),
    /// SSOR of S_u.
    Ssor(Ssor),
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
            Self::Jacobi(_) => "jacobi",
            Self::Ssor(_) => "ssor",
        }
    }

    /// `S̃_u⁻¹` for these blocks and this C.
    pub fn prepare(
        self,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let assembled = |settings: &dyn Prepare<SparseMatrix<f64>, f64>| {
            let s_u = schur::primal_schur(&blocks.a, &blocks.b1, c)?;
            settings
                .prepare(&s_u)
                .map_err(|error| error.in_block("S_u"))
        };
        match self {
            Self::Exact { backend } => schur::exact_inverse(blocks, c, backend.solver()?.as_ref()),
            Self::Jacobi(settings) => assembled(&settings),
            Self::Ssor(settings) => assembled(&settings),
        }
    }
}

impl fmt::Display for InnerChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`InnerChoice`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown inner solver {found:?}: expected exact, jacobi or ssor")]
pub struct UnknownInner {
    /// What was given.
    pub found: String,
}

impl FromStr for InnerChoice {
    type Err = UnknownInner;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "exact" => Ok(Self::default()),
            "jacobi" => Ok(Self::Jacobi(Jacobi::default())),
            "ssor" => Ok(Self::Ssor(Ssor::default())),
            _ => Err(UnknownInner {
                found: name.to_owned(),
            }),
        }
    }
}

/// `"ssor"` or `{ ssor = { omega = 1.2 } }`.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum NameOrSettings {
    /// Plain name, default settings.
    Name(String),
    /// Name with settings.
    Settings(InnerChoice),
}

/// Reads both spellings of an inner solver.
pub(crate) fn name_or_settings<'de, D: serde::Deserializer<'de>>(
    deserializer: D,
) -> Result<InnerChoice, D::Error> {
    match NameOrSettings::deserialize(deserializer)? {
        NameOrSettings::Name(name) => name.parse().map_err(serde::de::Error::custom),
        NameOrSettings::Settings(settings) => Ok(settings),
    }
}
