//! The sections of a scene file, as they are written.

use std::fmt;
use std::marker::PhantomData;
use std::num::NonZeroU32;

use schemars::JsonSchema;
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::units::{
    Acceleration, Angle, Density, FrictionAngle, Kind, Length, Measure, Poisson, Ratio, Stiffness,
    Strength, Stress, StressGradient,
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
    /// Box, grid lines and maps.
    pub mesh: MeshSection,
    /// Materials; where two overlap the later one wins.
    pub material: Vec<MaterialSection>,
    /// Fractures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fracture: Vec<FractureSection>,
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
}

/// Box, grid lines and maps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSection {
    /// Lines across x.
    pub x: AxisSection,
    /// Lines across y.
    pub y: AxisSection,
    /// Lines across z (up).
    pub z: AxisSection,
    /// Maps of the finished grid, applied in the order distort, incline, rotate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapSection>,
}

/// Grid lines along one axis: `from`, `to`, `cells`, perhaps graded; or `lines` alone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisSection {
    /// Start of the box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<Measure<Length>>,
    /// End of the box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<Measure<Length>>,
    /// Number of cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cells: Option<NonZeroU32>,
    /// Geometric grading: last cell size / first; with `toward`, coarsest / finest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<Measure<Ratio>>,
    /// Where cells are finest; becomes a grid line. Needs `ratio`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub toward: Option<Measure<Length>>,
    /// Every grid line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lines: Option<Vec<Measure<Length>>>,
}

/// Maps of the finished grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSection {
    /// Perturbation of the nodes; sides stay flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distort: Option<DistortSection>,
    /// Shear that tilts planes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub incline: Option<InclineSection>,
    /// Rigid rotation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotate: Option<RotateSection>,
}

/// Perturbation of the nodes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DistortSection {
    /// Share of the adjacent cell size, less than 0.5.
    pub amplitude: f64,
    /// Seed of the pattern.
    #[serde(default)]
    pub seed: u32,
    /// Waves across the box instead of independent numbers.
    #[serde(default)]
    pub smooth: bool,
    /// Let fractures leave their planes.
    #[serde(default)]
    pub bend_fractures: bool,
}

/// Shear that tilts the planes normal to `plane`; give `dip` or `tilt`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InclineSection {
    /// Normal of the planes before.
    pub plane: AxisName,
    /// Axis along which they climb; z for planes x and y, x for planes z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<AxisName>,
    /// Angle of the planes to the horizontal, 0 to 180 deg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dip: Option<Measure<Angle>>,
    /// Angle between the planes before and after.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<Measure<Angle>>,
    /// A point that stays; the centre of the box if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pivot: Option<[Measure<Length>; 3]>,
    /// Fade to nothing at the sides; only the plane through `pivot` gets the full angle.
    #[serde(default)]
    pub fade: bool,
}

/// Rigid rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotateSection {
    /// Axis of rotation.
    pub axis: AxisName,
    /// Angle, right-handed.
    pub angle: Measure<Angle>,
    /// A point on the axis; the centre of the box if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<[Measure<Length>; 3]>,
}

/// An isotropic elastic material, everywhere or in boxes and layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialSection {
    /// Its name.
    pub name: String,
    /// Young's modulus E.
    pub young: Measure<Stiffness>,
    /// Poisson's ratio.
    pub poisson: Measure<Poisson>,
    /// Density; only gravity asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<Measure<Density>>,
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

/// Rectangles of grid faces, before any map; give `at` or `every`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FractureSection {
    /// Its name; several planes are numbered from 1.
    pub name: String,
    /// Normal axis.
    pub plane: AxisName,
    /// Position, or list of positions, along it: grid lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<OneOrMany<Length>>,
    /// Every n-th interior grid line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<NonZeroU32>,
    /// Span in x; the full width if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[Measure<Length>; 2]>,
    /// Span in y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<[Measure<Length>; 2]>,
    /// Span in z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<[Measure<Length>; 2]>,
    /// The normal points against the axis.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub flip: bool,
    /// Friction angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_angle: Option<Measure<FrictionAngle>>,
    /// Cohesion; 0 if only the angle is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<Measure<Strength>>,
}

/// A condition on one side; give exactly one of `hold`, `displacement`, `traction`, `pressure`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoundarySection {
    /// Side of the box.
    pub side: SideName,
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
    /// Level of `constant`; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<Measure<Length>>,
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AxisName {
    /// x.
    X,
    /// y.
    Y,
    /// z, up.
    Z,
}

impl AxisName {
    /// 0, 1, 2.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Its letter.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self.index()]
    }
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

/// One quantity or a list of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged, bound = "")]
pub enum OneOrMany<K> {
    /// `"1 m"`.
    One(Measure<K>),
    /// `["1 m", "2 m"]`.
    Many(Vec<Measure<K>>),
}

impl<K: Kind> OneOrMany<K> {
    /// Values in SI units.
    pub fn si(&self) -> Vec<f64> {
        match self {
            Self::One(one) => vec![one.si()],
            Self::Many(many) => many.iter().map(Measure::si).collect(),
        }
    }
}

impl<'de, K: Kind> Deserialize<'de> for OneOrMany<K> {
    /// Not `untagged`, which would hide what is wrong with a value.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either<K>(PhantomData<K>);
        impl<'de, K: Kind> Visitor<'de> for Either<K> {
            type Value = OneOrMany<K>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{} or a list of them", K::NAME)
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
                text.parse().map(OneOrMany::One).map_err(E::custom)
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Self::Value, E> {
                self.visit_str(&number.to_string())
            }
            fn visit_f64<E: de::Error>(self, number: f64) -> Result<Self::Value, E> {
                self.visit_str(&number.to_string())
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
                let mut many = Vec::new();
                while let Some(one) = list.next_element()? {
                    many.push(one);
                }
                Ok(OneOrMany::Many(many))
            }
        }
        deserializer.deserialize_any(Either(PhantomData))
    }
}

impl<K: Kind> JsonSchema for OneOrMany<K> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("{} or a list of them", K::NAME).into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": ["string", "number", "array"],
            "items": { "type": ["string", "number"] },
            "description": format!("{} or a list of them, in {}", K::NAME, K::EXAMPLES),
        })
    }
}
