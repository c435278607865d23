//! Which factors of the block factorization are applied.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Factors of `[M_ut Q1; Q2 T]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// `M = [M_ut Q1; Q2 S_p + Q2 M_ut⁻¹ Q1]`: two solves with M_ut.
    #[default]
    Full,
    /// `M = [M_ut Q1; 0 S_p]`: pressures first, one solve with M_ut. With the fixed-stress S_p, as a stationary iteration, it is the
    /// sequential fixed-stress split.
    ///
    /// # Source
    /// J. Kim, H. A. Tchelepi, R. Juanes, CMAME 200 (2011) 1591–1606; J. A. White, N. Castelletto, H. A. Tchelepi, CMAME 303 (2016)
    /// 55–74, for the split as a block-triangular preconditioner.
    Upper,
    /// `M = [M_ut 0; Q2 S_p]`: mechanics first, one solve with M_ut.
    Lower,
}

impl Form {
    /// Every form.
    pub const ALL: [Self; 3] = [Self::Full, Self::Upper, Self::Lower];

    /// The form that costs the least and is as good where `Q2 = 0`.
    #[must_use]
    pub fn for_coupling(self, is_coupled: bool) -> Self {
        match (self, is_coupled) {
            (Self::Full, false) => Self::Upper,
            (form, _) => form,
        }
    }

    /// Solves with M_ut.
    pub fn solves(self) -> u64 {
        u64::from(self.begins_with_mechanics()) + u64::from(self.ends_with_mechanics())
    }

    /// Plain name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Upper => "upper",
            Self::Lower => "lower",
        }
    }

    pub(super) fn begins_with_mechanics(self) -> bool {
        self != Self::Upper
    }

    pub(super) fn ends_with_mechanics(self) -> bool {
        self != Self::Lower
    }
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of [`Form`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown form {found:?}: expected {}", Form::ALL.map(Form::name).join(", "))]
pub struct UnknownForm {
    /// What was given.
    pub found: String,
}

impl FromStr for Form {
    type Err = UnknownForm;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|form| form.name() == name);
        found.ok_or_else(|| UnknownForm {
            found: name.to_owned(),
        })
    }
}
