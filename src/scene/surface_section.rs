//! A height over x and y as it is written: a level, points along one axis, or a table over both; and levels of a grid that become such.

use std::fmt;

use schemars::JsonSchema;
use serde::de::{self, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};

use super::OneOrMany;
use super::located::{Located, at};
use crate::mesh::Relief;
use crate::units::{Kind, Length, Measure};

/// A level of the grid that becomes a surface; levels between two of them keep their share of the distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LiftSection {
    /// Its z before.
    pub level: Measure<Length>,
    /// Its height after: a level, or a surface over x and y as `top` of a layer.
    pub to: SurfaceSection,
}

/// A level, or a surface over x and y.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum SurfaceSection {
    /// `"-1200 m"`.
    Level(Measure<Length>),
    /// `{ x = [["-2 km", "-1150 m"], ["2 km", "-1300 m"]] }`, the same along y, or `{ x = […], y = […], z = [[…], …] }`.
    Points(SurfacePoints),
}

/// Points of a surface: linear or bilinear between them, constant beyond.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfacePoints {
    /// Pairs of x and z; or the columns of `z`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<Vec<OneOrMany<Length>>>,
    /// Pairs of y and z; or the rows of `z`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<Vec<OneOrMany<Length>>>,
    /// A row per y of a height per x.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<Vec<Vec<Measure<Length>>>>,
}

/// A surface that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceProblem {
    /// Keys or rows that do not belong together.
    #[error(
        "{what} has to be a level, e.g. \"-1200 m\", or a surface: {{ x = [[\"-2 km\", \"-1150 m\"], [\"2 km\", \"-1300 m\"]] }} with pairs of x and z, the same along y, or {{ x = [\"-2 km\", \"2 km\"], y = [\"0 m\", \"1 km\"], z = [[\"-1150 m\", \"-1300 m\"], [\"-1200 m\", \"-1350 m\"]] }} with a row per y"
    )]
    Form {
        /// Which surface.
        what: String,
    },
    /// Points that do not increase.
    #[error("the points of {what} must increase along {axis}: {value} m comes after {before} m")]
    Unsorted {
        /// Which surface.
        what: String,
        /// x or y.
        axis: &'static str,
        /// The point [m].
        value: f64,
        /// The one before it [m].
        before: f64,
    },
    /// A table with another number of rows.
    #[error("`z` of {what} has {found} rows for {wanted} values of y; give a row per y")]
    Rows {
        /// Which surface.
        what: String,
        /// Rows.
        found: usize,
        /// Values of y.
        wanted: usize,
    },
    /// A row of another length.
    #[error(
        "row {row} of `z` of {what} has {found} heights for {wanted} values of x; give a height per x"
    )]
    Row {
        /// Which surface.
        what: String,
        /// Counted from 1.
        row: usize,
        /// Heights in it.
        found: usize,
        /// Values of x.
        wanted: usize,
    },
}

impl SurfaceSection {
    /// The surface; `path` is where it is written and `what` names it.
    ///
    /// # Errors
    /// [`SurfaceProblem`]: another form, points out of order, a table with holes.
    pub(super) fn surface(&self, path: &[&str], what: &str) -> Result<Relief, Located> {
        let points = match self {
            Self::Level(level) => return Ok(Relief::level(level.si())),
            Self::Points(points) => points,
        };
        let refuse = |key: &[&str], problem: SurfaceProblem| at(&[path, key].concat(), problem);
        let form = || refuse(&[], SurfaceProblem::Form { what: what.into() });
        let SurfacePoints { x, y, z } = points;
        let (lines, heights) = match (x, y, z) {
            (Some(x), None, None) => {
                let (x, z) = pairs(x).ok_or_else(form)?;
                ([x, vec![0.0]], z)
            }
            (None, Some(y), None) => {
                let (y, z) = pairs(y).ok_or_else(form)?;
                ([vec![0.0], y], z)
            }
            (Some(x), Some(y), Some(z)) => {
                let lines = [singles(x).ok_or_else(form)?, singles(y).ok_or_else(form)?];
                let [columns, wanted] = [lines[0].len(), lines[1].len()];
                if z.len() != wanted {
                    let (what, found) = (what.into(), z.len());
                    return Err(refuse(
                        &["z"],
                        SurfaceProblem::Rows {
                            what,
                            found,
                            wanted,
                        },
                    ));
                }
                if let Some((j, row)) = z.iter().enumerate().find(|(_, row)| row.len() != columns) {
                    let problem = SurfaceProblem::Row {
                        what: what.into(),
                        row: j + 1,
                        found: row.len(),
                        wanted: columns,
                    };
                    return Err(refuse(&["z", &j.to_string()], problem));
                }
                (lines, z.iter().flatten().map(Measure::si).collect())
            }
            _ => return Err(form()),
        };
        for (axis, lines) in ["x", "y"].into_iter().zip(&lines) {
            for (i, pair) in lines.windows(2).enumerate() {
                if pair[0] >= pair[1] {
                    let problem = SurfaceProblem::Unsorted {
                        what: what.into(),
                        axis,
                        value: pair[1],
                        before: pair[0],
                    };
                    return Err(refuse(&[axis, &(i + 1).to_string()], problem));
                }
            }
        }
        Ok(Relief::new(lines, heights))
    }

    /// As it would be written, with as few points as it needs.
    pub(super) fn of(surface: &Relief) -> Self {
        if let Some(level) = surface.is_level() {
            return Self::Level(Measure::metres(level));
        }
        let [x, y] = [0, 1].map(|d| surface.lines(d));
        let pair = |at: f64, z: f64| OneOrMany::Many([at, z].map(Measure::metres).into());
        let single = |at: &f64| OneOrMany::One(Measure::metres(*at));
        Self::Points(match [0, 1].map(|d| surface.varies(d)) {
            [_, false] => SurfacePoints {
                x: Some(x.iter().map(|x| pair(*x, surface.at([*x, y[0]]))).collect()),
                ..SurfacePoints::default()
            },
            [false, _] => SurfacePoints {
                y: Some(y.iter().map(|y| pair(*y, surface.at([x[0], *y]))).collect()),
                ..SurfacePoints::default()
            },
            _ => {
                let height = |x: &f64, y: f64| Measure::metres(surface.at([*x, y]));
                let row = |y: &f64| x.iter().map(|x| height(x, *y)).collect();
                SurfacePoints {
                    x: Some(x.iter().map(single).collect()),
                    y: Some(y.iter().map(single).collect()),
                    z: Some(y.iter().map(row).collect()),
                }
            }
        })
    }
}

/// Rows of two: firsts and seconds; `None` where one is not, or where there are none.
fn pairs(rows: &[OneOrMany<Length>]) -> Option<(Vec<f64>, Vec<f64>)> {
    let pair = |row: &OneOrMany<Length>| match row {
        OneOrMany::Many(pair) if pair.len() == 2 => Some((pair[0].si(), pair[1].si())),
        _ => None,
    };
    let all: Option<Vec<_>> = rows.iter().map(pair).collect();
    all.filter(|all| !all.is_empty())
        .map(|all| all.into_iter().unzip())
}

/// Rows of one; `None` where one is not, or where there are none.
fn singles(rows: &[OneOrMany<Length>]) -> Option<Vec<f64>> {
    let single = |row: &OneOrMany<Length>| match row {
        OneOrMany::One(one) => Some(one.si()),
        OneOrMany::Many(_) => None,
    };
    let all: Option<Vec<_>> = rows.iter().map(single).collect();
    all.filter(|all| !all.is_empty())
}

impl<'de> Deserialize<'de> for SurfaceSection {
    /// Not `untagged`, which would hide what is wrong with a value.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = SurfaceSection;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(
                    f,
                    "{}, e.g. in {}; or a surface",
                    Length::NAME,
                    Length::EXAMPLES
                )
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Self::Value, E> {
                text.parse().map(SurfaceSection::Level).map_err(E::custom)
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Self::Value, E> {
                self.visit_str(&number.to_string())
            }
            fn visit_f64<E: de::Error>(self, number: f64) -> Result<Self::Value, E> {
                self.visit_str(&number.to_string())
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                SurfacePoints::deserialize(MapAccessDeserializer::new(map))
                    .map(SurfaceSection::Points)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl JsonSchema for SurfaceSection {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "a level or a surface".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": ["string", "number", "object"],
            "description": "a level, or a surface over x and y",
        })
    }
}
