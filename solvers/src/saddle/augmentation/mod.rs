//! Augmentations: the SPD matrix C of `Â = [A B; Bᵀ −C]` and `S_u = A + B C⁻¹ Bᵀ`.
//!
//! One file per definition; a new one is its own file and one line in each `match` of [`AugmentationChoice`]. One from outside is
//! an [`AugmentationRule`], registered by its name, and may give any C ([`CustomAugmentation`]).
//!
//! B is B1 in every definition. Rows that determine their own traction (slip, open) need no C: they are eliminated first
//! ([`super::Elimination`]). Where H is not symmetric positive semi-definite all the same, the definitions with H take
//! `|H_ii|`: C stays SPD whatever H is.

mod block;
mod custom;
mod exact;
mod face_block;
mod fitted;
mod global;
mod local;
mod matrix;
mod parts;
mod rule;
mod stabilized;
mod support;

pub use block::Block;
pub use custom::{Custom, CustomAugmentation};
pub use exact::dual_schur;
pub(super) use face_block::well_conditioned_factor;
pub use matrix::AugmentationMatrix;
pub use rule::AugmentationRule;
pub(super) use support::for_restricted;

use super::SaddleBlocks;
use crate::SetupError;
use crate::direct::DirectSolver;
use crate::registry::Registered;
use crate::written::{self, Written};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::str::FromStr;

/// Which C.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum AugmentationChoice {
    /// `C_ii = ‖r(b_i)‖₂² / ‖A|_{b_i}‖₂`.
    Local,
    /// `C = γ I`, `γ = ‖B‖₂² / ‖A‖₂`.
    Global,
    /// `C = s γ I` with a factor s.
    GlobalTimes(f64),
    /// `C = Bᵀ A⁻¹ B`.
    Exact,
    /// `C = C_local + |diag H|`: C must dominate H. The default wherever H is not relaxed ([`super::Racp`] takes fitted_h).
    #[default]
    LocalH,
    /// `C = C_local + |blkdiag H|/2`, 3×3 blocks, for RACP that relaxes H ([`super::Relaxation`]).
    HalfH,
    /// `C = C_local + θ_f |H_ff|`, 3×3 blocks, θ_f = ½ in cubes and less in flat cells, for RACP that relaxes H; its default.
    FittedH,
    /// `C = Bᵀ A⁻¹ B + H`.
    ExactH,
    /// `C_f = r(B_f)ᵀ (A|_f)⁻¹ r(B_f) + |H_ff|` for the three columns of every face.
    FaceBlock,
    /// Somebody else's.
    #[serde(untagged)]
    #[schemars(skip)]
    Other(Registered<dyn AugmentationRule>),
}

impl AugmentationChoice {
    /// Every choice of the house that has a plain name.
    pub const ALL: [Self; 8] = [
        Self::Local,
        Self::Global,
        Self::Exact,
        Self::LocalH,
        Self::HalfH,
        Self::FittedH,
        Self::ExactH,
        Self::FaceBlock,
    ];

    /// Name without parameters, as the command line and the scene file spell it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::Global => "global",
            Self::GlobalTimes(_) => "global_times",
            Self::Exact => "exact",
            Self::LocalH => "local_h",
            Self::HalfH => "half_h",
            Self::FittedH => "fitted_h",
            Self::ExactH => "exact_h",
            Self::FaceBlock => "face_block",
            Self::Other(rule) => rule.0.name(),
        }
    }

    /// C for these blocks; `direct` factorizes A where the definition needs it.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] with the reason (A singular for the exact ones, n_t not a multiple of 3 for face
    /// blocks); [`SetupError::NotFinite`] for NaN; [`SetupError::NotPositiveDefinite`] naming the row of C.
    pub fn compute(
        self,
        blocks: &SaddleBlocks,
        direct: &dyn DirectSolver,
    ) -> Result<Augmentation, SetupError> {
        blocks.check()?;
        let columns = support::Columns::new(&blocks.b1);
        let mut matrix = match self {
            Self::Local => local::local(blocks, &columns)?,
            Self::Global => global::global(blocks, 1.0)?,
            Self::GlobalTimes(factor) => global::global(blocks, factor)?,
            Self::Exact => exact::exact(blocks, &columns, direct)?,
            Self::LocalH => stabilized::local_h(blocks, &columns)?,
            Self::HalfH => stabilized::half_h(blocks, &columns)?,
            Self::FittedH => {
                let local = local::local(blocks, &columns)?.diagonal_entries();
                fitted::fitted_h(local, &fitted::shares(blocks, &columns), blocks.h.as_ref())
            }
            Self::ExactH => stabilized::exact_h(blocks, &columns, direct)?,
            Self::FaceBlock => face_block::face_block(blocks, &columns)?,
            Self::Other(rule) => rule.0.compute(blocks, direct)?,
        };
        if matrix.size() != blocks.n_t() {
            return Err(SetupError::NotApplicable {
                method: self.name(),
                reason: format!(
                    "C has {} rows for {} tractions",
                    matrix.size(),
                    blocks.n_t()
                ),
            });
        }
        matrix.factor()?;
        Ok(Augmentation {
            matrix,
            empty_columns: columns.empty(),
        })
    }
}

impl fmt::Display for AugmentationChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GlobalTimes(factor) => write!(f, "global_times={factor}"),
            named => f.write_str(named.name()),
        }
    }
}

/// A name that is none of [`AugmentationChoice`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown augmentation {found:?}: expected local, global, global_times=FACTOR, exact, local_h, half_h, fitted_h, exact_h or face_block{}",
    rule::RULES.names()
)]
pub struct UnknownAugmentation {
    /// What was given.
    pub found: String,
}

impl FromStr for AugmentationChoice {
    type Err = UnknownAugmentation;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let scaled = || {
            let factor: f64 = name.strip_prefix("global_times=")?.parse().ok()?;
            (factor > 0.0 && factor.is_finite()).then_some(Self::GlobalTimes(factor))
        };
        Self::ALL
            .into_iter()
            .find(|choice| choice.name() == name)
            .or_else(scaled)
            .or_else(|| rule::RULES.find(name).map(Self::Other))
            .ok_or_else(|| UnknownAugmentation {
                found: name.to_owned(),
            })
    }
}

/// `"local_h"`, `"global_times=2"` or `{ global_times = 2.0 }`.
impl<'de> Deserialize<'de> for AugmentationChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        written::read(deserializer)
    }
}

impl Written for AugmentationChoice {
    const EXPECTED: &'static str =
        "the name of an augmentation such as \"local_h\", or { global_times = 2.0 }";

    fn from_table<'de, D: Deserializer<'de>>(table: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Times {
            global_times: f64,
        }
        let Times { global_times } = Times::deserialize(table)?;
        let name = format!("global_times={global_times}");
        name.parse().map_err(D::Error::custom)
    }
}

/// C and what was noticed while it was computed.
#[derive(Clone, Debug)]
pub struct Augmentation {
    /// C, factorized.
    pub matrix: AugmentationMatrix,
    /// Columns of B without entries (from 0): those of `C_local` and `BᵀA⁻¹B` are |H_kk| there, 1 where it is 0.
    pub empty_columns: Vec<usize>,
}

#[cfg(test)]
mod tests;
