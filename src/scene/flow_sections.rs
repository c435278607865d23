//! The sections of a scene file, as they are written: the fluid in fractures and what drives it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::sections::SideName;
use crate::units::{
    Compressibility, Conductivity, Density, Duration, Length, Measure, Rate, Stress, Viscosity,
};

/// A fluid that flows in every fracture; each needs a `conductivity`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FluidSection {
    /// Dynamic viscosity.
    pub viscosity: Measure<Viscosity>,
    /// Compressibility; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compressibility: Option<Measure<Compressibility>>,
    /// Density, by which gravity acts on it; its weight is left out if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<Measure<Density>>,
    /// Level z at which the `initial_pressure` of fractures holds; 0 if not given. Needs `density`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Measure<Length>>,
}

/// What drives the fluid, from time 0 on: a rate or a pressure, on the face at a point, along an edge, or on a whole fracture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceSection {
    /// Name of the fracture, with its number where several planes share one name.
    pub fracture: String,
    /// A point on the face, after any map; on the border of faces these share it by area; the whole fracture if neither this nor `edge`
    /// is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[Measure<Length>; 3]>,
    /// The outer edges that lie farthest to this side; takes a pressure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge: Option<SideName>,
    /// Volume per time, shared by area; negative takes fluid out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<Measure<Rate>>,
    /// Prescribed pressure; fluid comes and goes as it asks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Measure<Stress>>,
    /// Level z at which `pressure` holds: elsewhere it is in equilibrium with the weight of the fluid. If not given, it is the same at every
    /// depth. Needs `density`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<Measure<Length>>,
    /// Factor in time as `[[time, factor], …]`; that of `[time]` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<(Measure<Duration>, f64)>>,
}

/// A well: a line that brings fluid to the fractures it cuts, or takes it from them, at one pressure for all of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WellSection {
    /// Its name, of letters, digits, `_` and `-`: that of its columns in `flow.csv`.
    pub name: String,
    /// Upper end, where its pressure is told.
    pub from: [Measure<Length>; 3],
    /// Lower end. Where the line cuts the border of faces, these share the well; a line within a fracture is refused.
    pub to: [Measure<Length>; 3],
    /// Radius, above 0; 0.1 m if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<Measure<Length>>,
    /// Volume per time into all fractures together; negative takes fluid out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<Measure<Rate>>,
    /// Pressure that throttles `rate`, down to nothing: the well does not inject beyond it, and does not withdraw below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<Measure<Stress>>,
    /// Prescribed pressure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Measure<Stress>>,
    /// Factor of `rate` or `pressure` in time as `[[time, factor], …]`; that of `[time]` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<(Measure<Duration>, f64)>>,
}

impl SourceSection {
    /// For messages.
    pub(super) fn name(&self) -> String {
        format!("[[source]] of fracture \"{}\"", self.fracture)
    }
}

/// A conductivity along a direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlongSection {
    /// As `[x, y, z]`, of any length; its part in the plane of a face counts.
    pub direction: [f64; 3],
    /// Conductivity there.
    pub conductivity: Measure<Conductivity>,
}
