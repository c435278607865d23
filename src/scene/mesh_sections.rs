//! The sections of a scene file, as they are written: grid, maps, fractures.

use std::num::NonZeroU32;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::flow_sections::AlongSection;
use super::group_names::GroupNames;
use super::one_or_many::OneOrMany;
use super::profile::LevelSection;
use super::sides::PressureFrom;
use super::surface_section::LiftSection;
use crate::contact::WeakeningBy;
use crate::mesh::SizeField;
use crate::units::{
    Angle, Conductivity, Distance, Duration, FrictionAngle, Length, Measure, MeshUnit, Ratio,
    Storage, Strength, Stress,
};

/// Box, grid lines and maps; or a mesh file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSection {
    /// Gmsh file (.msh, format 2.2 or 4.1) instead of x, y, z; the path starts at the folder of the scene file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Length of one unit of the mesh file; 1 m if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<Measure<MeshUnit>>,
    /// Lines across x.
    #[serde(default, skip_serializing_if = "AxisSection::is_absent")]
    pub x: AxisSection,
    /// Lines across y.
    #[serde(default, skip_serializing_if = "AxisSection::is_absent")]
    pub y: AxisSection,
    /// Lines across z (up).
    #[serde(default, skip_serializing_if = "AxisSection::is_absent")]
    pub z: AxisSection,
    /// Maps of the finished grid, applied in the order distort, disc, lift, shear, incline, rotate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<MapSection>,
}

/// Grid lines along one axis: `from`, `to`, `cells`, perhaps graded; or `from`, `to`, `size`, `growth` and `near`
/// or `fine`, which a [geology] gives where they are left out; or `lines` alone.
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
    /// Size of the finest cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<Measure<Length>>,
    /// Size of a cell over that of its finer neighbour, at least 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub growth: Option<Measure<Ratio>>,
    /// Size that no cell exceeds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest: Option<Measure<Length>>,
    /// Points where cells are finest; they become grid lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub near: Option<OneOrMany<Length>>,
    /// Interval of equal cells; its ends become grid lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fine: Option<[Measure<Length>; 2]>,
    /// Points that become grid lines though cells are no finer there; needs `size`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub through: Option<OneOrMany<Length>>,
    /// Every grid line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lines: Option<Vec<Measure<Length>>>,
}

impl AxisSection {
    /// Whether nothing is given.
    pub(super) fn is_absent(&self) -> bool {
        *self == Self::default()
    }

    /// The field of cell sizes, if all of its keys are given and no others.
    pub(super) fn size_field(&self) -> Option<SizeField> {
        let points = self.near.iter().flat_map(OneOrMany::si).map(|x| [x, x]);
        let interval = self.fine.iter().map(|[from, to]| [from.si(), to.si()]);
        let zones: Vec<[f64; 2]> = points.chain(interval).collect();
        let others = self.cells.is_some()
            || self.ratio.is_some()
            || self.toward.is_some()
            || self.lines.is_some();
        match (&self.from, &self.to, &self.size, &self.growth) {
            (Some(from), Some(to), Some(size), Some(growth)) if !others && !zones.is_empty() => {
                Some(SizeField {
                    from: from.si(),
                    to: to.si(),
                    zones,
                    through: self.through.iter().flat_map(OneOrMany::si).collect(),
                    size: size.si(),
                    growth: growth.si(),
                    largest: self.largest.as_ref().map_or(f64::INFINITY, Measure::si),
                })
            }
            _ => None,
        }
    }

    /// One of the keys of a field of cell sizes is given.
    pub(super) fn asks_for_sizes(&self) -> bool {
        let lengths = [&self.size, &self.largest].map(Option::is_some);
        let points = [&self.near, &self.through].map(Option::is_some);
        let others = self.growth.is_some() || self.fine.is_some();
        others || lengths.contains(&true) || points.contains(&true)
    }
}

impl MeshSection {
    /// Nodes of the grid before fractures split them; an axis that is not complete counts 0.
    pub fn nodes(&self) -> u128 {
        let count = |axis: &AxisSection| match (axis.cells, &axis.lines) {
            (Some(cells), _) => u128::from(cells.get()) + 1,
            (None, Some(lines)) => lines.len() as u128,
            // what cannot be made counts 0 and is refused where it is made
            (None, None) => axis
                .size_field()
                .and_then(|field| field.cells(0).ok())
                .map_or(0, |cells| (cells as u128).saturating_add(1)),
        };
        count(&self.x)
            .saturating_mul(count(&self.y))
            .saturating_mul(count(&self.z))
    }
}

/// Maps of the finished grid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSection {
    /// Perturbation of the nodes; sides stay flat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distort: Option<DistortSection>,
    /// Squares that become circles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<DiscSection>,
    /// Levels that become surfaces, in any order. [geology] makes them of tops that are not level.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lift: Vec<LiftSection>,
    /// Shear between planes that lean each by its own angle; the sides stay. [geology] makes it of faults that dip.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shear: Vec<ShearSection>,
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

/// The square of half-width `radius` around an axis becomes a disc, in every layer along the axis; sides stay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscSection {
    /// Axis of the disc.
    pub axis: AxisName,
    /// Its radius.
    pub radius: Measure<Length>,
    /// A point on the axis; the centre of the box if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub center: Option<[Measure<Length>; 3]>,
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

/// A plane that leans, with everything up to the next ones and the sides, linearly; upright beyond `z`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShearSection {
    /// Its normal before: x or y.
    pub plane: AxisName,
    /// Its position before.
    pub at: Measure<Length>,
    /// Level z at which it stays there.
    pub level: Measure<Length>,
    /// Its angle to the horizontal, 0 to 180 deg.
    pub dip: Measure<Angle>,
    /// Levels between which it leans.
    pub z: [Measure<Length>; 2],
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

/// Rectangles of grid faces, before any map: give `plane` and `at` or `every`; or physical surfaces of a mesh file: give
/// `surface`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FractureSection {
    /// Its name; several planes are numbered from 1.
    pub name: String,
    /// Physical surfaces of a mesh file, by name or number. The normal agrees across inner edges, and per connected part
    /// N = ∫ n dS is positive along the first of x, y, z along which it has at least half its largest component; closed
    /// parts point outwards.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<GroupNames>,
    /// Normal axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<AxisName>,
    /// Position, or list of positions, along it: grid lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<OneOrMany<Length>>,
    /// Every n-th interior grid line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub every: Option<NonZeroU32>,
    /// With [geology]: its angle to the horizontal, 30 to 150 deg, upright at 90; below 90 it climbs towards the end of its axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dip: Option<Measure<Angle>>,
    /// With `dip`: the level z at which it lies `at` its position; the middle of its depth range if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<Measure<Length>>,
    /// With [geology]: how much lower the layers that it cuts lie beyond it, where its axis is greater.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub throw: Option<Measure<Length>>,
    /// With [geology], in place of `z`: materials of the layers that it cuts, on both sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cuts: Option<Vec<String>>,
    /// Span in x; the full width if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<[Measure<Length>; 2]>,
    /// Span in y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<[Measure<Length>; 2]>,
    /// Span in z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<[Measure<Length>; 2]>,
    /// The normal points against the axis, or against the rule of `surface`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub flip: bool,
    /// Friction angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_angle: Option<Measure<FrictionAngle>>,
    /// Cohesion; 0 if only the angle is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<Measure<Strength>>,
    /// Friction angle after `weakening_distance` of slip; the angle falls linearly until then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamic_friction_angle: Option<Measure<FrictionAngle>>,
    /// Slip over which friction weakens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakening_distance: Option<Measure<Distance>>,
    /// What of its slip weakens a face: `slip`, its length, so that slip back heals, or `path`, the way it has gone, which only grows;
    /// `slip` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakening_by: Option<WeakeningBy>,
    /// Opening before any displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<Measure<Distance>>,
    /// Pressure of the fluid inside, the same on every face (positive pushes the sides apart).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Measure<Stress>>,
    /// In place of `pressure`: it is what the pore pressure of the rock on the two sides of each face has changed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_from: Option<PressureFrom>,
    /// What changes with depth: levels, each with a height `z` and the value of some of `friction_angle`, `cohesion`,
    /// `dynamic_friction_angle`, `weakening_distance` and `pressure`, in place of that of the whole fracture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<Vec<LevelSection>>,
    /// Conductivity C_f0 of the closed fracture for the [fluid], `w³/12` of a width w; where open, `g_N³/12` is added.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conductivity: Option<Measure<Conductivity>>,
    /// Another conductivity of the closed fracture along a direction in its plane; `conductivity` is that across it then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conductivity_along: Option<AlongSection>,
    /// Volume of [fluid] taken up per area and pressure, closed or open; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub storage: Option<Measure<Storage>>,
    /// Pressure of the [fluid] before anything flows; 0 if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub initial_pressure: Option<Measure<Stress>>,
    /// Factor of the pressure in time as `[[time, factor], …]`; that of `[time]` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure_history: Option<Vec<(Measure<Duration>, f64)>>,
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
