//! The sections of a scene file, as they are written: materials, boundaries, loads.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::flow_sections::{FluidSection, SourceSection, WellSection};
use super::geology::GeologySection;
use super::group_names::GroupNames;
use super::mesh_sections::{FractureSection, MeshSection};
use super::pore_pressure::PorePressureSection;
use super::solver_section::{SolverSection, TimeSection};
use super::weight::WeightSection;
use crate::units::{
    Acceleration, BiotCoefficient, Density, Duration, Kind, Length, Measure, Poisson,
    RockViscosity, Stiffness, Stress, StressGradient,
};

/// A scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneSections {
    /// One line that names the scene.
    pub title: String,
    /// What it asks and what is known of the answer.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Box, grid lines and maps; or a mesh file.
    pub mesh: MeshSection,
    /// Layers and the offsets of faults in them, in place of the boxes of materials.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geology: Option<GeologySection>,
    /// Materials; where two overlap the later one wins.
    pub material: Vec<MaterialSection>,
    /// Fractures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fracture: Vec<FractureSection>,
    /// The fluid in the fractures, whose pressure is then unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid: Option<FluidSection>,
    /// What drives the fluid. Nothing leaves a fracture where no source says so.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub source: Vec<SourceSection>,
    /// Wells that cross fractures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub well: Vec<WellSection>,
    /// Boundary conditions in order; where two prescribe one displacement the later one wins. A side without any is free.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boundary: Vec<BoundarySection>,
    /// Acceleration that acts on densities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gravity: Option<ComponentsSection<Acceleration>>,
    /// Force per volume on every material (1 Pa/m = 1 N/m³).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body_force: Option<ComponentsSection<StressGradient>>,
    /// Stress before any displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_stress: Option<InitialStressSection>,
    /// Steps in time; without it `run` solves the equilibrium at time 0 alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<TimeSection>,
    /// How `run` solves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverSection>,
}

/// An isotropic elastic material, everywhere or in volumes, boxes and layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSection {
    /// Its name.
    pub name: String,
    /// Young's modulus E.
    pub young: Measure<Stiffness>,
    /// Poisson's ratio.
    pub poisson: Measure<Poisson>,
    /// Density, which `[gravity]` needs; `"0 kg/m3"` is rock without weight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<Measure<Density>>,
    /// Viscosity η of a Maxwell body, in which the deviatoric stress s flows: `ε̇_v = s/(2η)`; it dies out in a time η/G where strain rests.
    /// Not given, the material does not creep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viscosity: Option<Measure<RockViscosity>>,
    /// The initial stress in it is its vertical component in all directions, as in salt that has long crept.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub isotropic_stress: bool,
    /// Change of pore pressure everywhere in it: total stress falls by `biot` times as much (isotropic, tension positive).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_change: Option<Measure<Stress>>,
    /// Pore pressure in time, in place of `pressure_change` and `pressure_history`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pore_pressure: Option<PorePressureSection>,
    /// Biot's coefficient; 1 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub biot: Option<Measure<BiotCoefficient>>,
    /// Factor of the change in time as `[[time, factor], …]`; that of `[time]` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_history: Option<Vec<(Measure<Duration>, f64)>>,
    /// Physical volumes of a mesh file that it fills, by name or number; everything if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume: Option<GroupNames>,
    /// Boxes that it fills, before any map (a cell belongs to a box if its centre does).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub boxes: Vec<BoxSection>,
    /// Intervals of z that it fills, before any map.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<[Measure<Length>; 2]>,
}

/// A box; an axis that is not given is not limited.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSection {
    /// Interval in x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[Measure<Length>; 2]>,
    /// Interval in y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<[Measure<Length>; 2]>,
    /// Interval in z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<[Measure<Length>; 2]>,
}

/// A condition on one side or surface; give exactly one of `hold`, `displacement`, `traction`, `pressure`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundarySection {
    /// Side of the box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<SideName>,
    /// Physical surfaces of a mesh file, by name or number, in place of `side`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<GroupNames>,
    /// Part of the side: its faces between two x, which no face reaches across.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[Measure<Length>; 2]>,
    /// The same between two y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<[Measure<Length>; 2]>,
    /// The same between two z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<[Measure<Length>; 2]>,
    /// Zero displacement, normal or all.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<HoldSection>,
    /// Prescribed components; those not given are free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement: Option<ComponentsSection<Length>>,
    /// Force per area; components not given are zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traction: Option<ComponentsSection<Stress>>,
    /// Pressure against the side (positive = compression).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Measure<Stress>>,
    /// Factor in time as `[[time, factor], …]`, linear between and constant outside; that of `[time]` if not given. One that
    /// varies needs `[time]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<(Measure<Duration>, f64)>>,
}

impl BoundarySection {
    /// Where it holds, for messages.
    pub(super) fn place(&self) -> String {
        match (self.side, &self.surface) {
            (Some(side), _) => side.name().into(),
            (None, Some(surface)) => format!("surface {surface}"),
            (None, None) => "no side".into(),
        }
    }
}

/// Which displacements are zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum HoldSection {
    /// The normal one.
    Roller,
    /// All three.
    Fixed,
}

/// Components of a vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, bound = "K: Kind")]
#[schemars(bound = "K: Kind")]
pub struct ComponentsSection<K> {
    /// Along x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<Measure<K>>,
    /// Along y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<Measure<K>>,
    /// Along z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<Measure<K>>,
}

impl<K: Kind> ComponentsSection<K> {
    /// Values in SI units, `None` where not given.
    pub fn given(&self) -> [Option<f64>; 3] {
        [&self.x, &self.y, &self.z].map(|c| c.as_ref().map(Measure::si))
    }

    /// Values in SI units, zero where not given.
    pub fn si(&self) -> [f64; 3] {
        self.given().map(|c| c.unwrap_or(0.0))
    }
}

/// Components of a symmetric tensor; those not given are zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, bound = "K: Kind")]
#[schemars(bound = "K: Kind")]
pub struct TensorSection<K> {
    /// xx.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xx: Option<Measure<K>>,
    /// yy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yy: Option<Measure<K>>,
    /// zz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zz: Option<Measure<K>>,
    /// xy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xy: Option<Measure<K>>,
    /// yz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yz: Option<Measure<K>>,
    /// xz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub xz: Option<Measure<K>>,
}

impl<K: Kind> TensorSection<K> {
    /// Voigt order xx, yy, zz, xy, yz, xz, SI units.
    pub fn si(&self) -> [f64; 6] {
        [&self.xx, &self.yy, &self.zz, &self.xy, &self.yz, &self.xz]
            .map(|c| c.as_ref().map_or(0.0, Measure::si))
    }
}

/// σ0 = constant + (z − reference) · gradient, tension positive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialStressSection {
    /// Stress at z = reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constant: Option<TensorSection<Stress>>,
    /// Change per metre of z, upwards.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gradient: Option<TensorSection<StressGradient>>,
    /// Stress of the weight above, besides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight: Option<WeightSection>,
    /// Level of `constant`; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Measure<Length>>,
}

/// A side of the box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum SideName {
    /// Lowest x.
    #[serde(rename = "x-")]
    XMinus,
    /// Highest x.
    #[serde(rename = "x+")]
    XPlus,
    /// Lowest y.
    #[serde(rename = "y-")]
    YMinus,
    /// Highest y.
    #[serde(rename = "y+")]
    YPlus,
    /// Bottom.
    #[serde(rename = "z-")]
    ZMinus,
    /// Top.
    #[serde(rename = "z+")]
    ZPlus,
}

impl SideName {
    /// 0–5: x−, x+, y−, y+, z−, z+.
    pub fn index(self) -> usize {
        self as usize
    }

    /// As it is written.
    pub fn name(self) -> &'static str {
        ["x-", "x+", "y-", "y+", "z-", "z+"][self.index()]
    }
}
