//! Plain settings of geometric multigrid.

use super::{Cycle, GridLines, Precision};
use crate::steering;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Geometric multigrid of S_u, on grids that somebody else keeps: a model builds it from these.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Geometric {
    /// Degree of the Chebyshev polynomial before and after the coarse correction in rock of ν ≤ 0.3; it grows towards ν = ½, and by
    /// one where blocks smaller than a coarse cell end the hierarchy.
    pub degree: usize,
    /// How often a level visits the next one.
    pub cycle: Cycle,
    /// Scalars that the hierarchy is applied in; it is computed in f64.
    pub precision: Precision,
    /// Unknowns at which coarsening ends.
    pub coarsest: usize,
    /// Unknowns up to which a grid that coarsens no further is factorized; algebraic multigrid, which takes more iterations the more
    /// blocks hang on each other, solves larger ones. A body of so many, five times as many where it has at most four cells across, is factorized
    /// itself where a cycle hardly sees something.
    pub direct: usize,
    /// Factor on the result: RACP gains from eigenvalues of `S̃_u⁻¹S_u` *around* 1, a V-cycle leaves them in (0, 1].
    pub over_correction: f64,
    /// Which lines of a grid the next one keeps.
    #[serde(deserialize_with = "crate::steering::in_range")]
    pub lines: GridLines,
}

impl Default for Geometric {
    fn default() -> Self {
        Self {
            degree: 3,
            cycle: Cycle::default(),
            precision: Precision::default(),
            coarsest: 1000,
            direct: 20_000,
            over_correction: 1.0,
            lines: GridLines::default(),
        }
    }
}

// at degree 0 nothing is smoothed, and a factor of 0 leaves nothing
steering! {
    Geometric:
    degree [1.0, 1e3],
    coarsest [0.0, 1e15],
    direct [0.0, 1e15],
    over_correction [1e-3, 1e3],
}

impl Geometric {
    /// The settings that a name can ask for: every cycle in f32 and in f64.
    pub fn all() -> impl Iterator<Item = Self> {
        let cycles = [Cycle::VThenW, Cycle::V, Cycle::W, Cycle::K];
        cycles.into_iter().flat_map(|cycle| {
            [Precision::F32, Precision::F64].map(|precision| Self {
                cycle,
                precision,
                ..Self::default()
            })
        })
    }

    /// The same in f64, where it is in f32.
    pub fn in_double(self) -> Option<Self> {
        (self.precision == Precision::F32).then_some(Self {
            precision: Precision::F64,
            ..self
        })
    }

    /// The settings of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::all().find(|settings| settings.to_string() == name)
    }
}

/// `geometric`, with the cycle and the precision behind it where they are not the default: `geometric:k:f64`.
impl fmt::Display for Geometric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cycle = match self.cycle {
            Cycle::VThenW => "",
            Cycle::V => ":v",
            Cycle::W => ":w",
            Cycle::K => ":k",
        };
        let precision = match self.precision {
            Precision::F32 => "",
            Precision::F64 => ":f64",
        };
        write!(f, "geometric{cycle}{precision}")
    }
}
