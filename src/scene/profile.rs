//! Properties of a fracture that change with depth: rows of a scene, and values along z.

use super::located::{Located, at};
use super::{FractureSection, Problem};
use crate::contact::{Friction, Weakening};
use crate::units::{Distance, FrictionAngle, Kind, Length, Measure, Strength, Stress};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A level of the `profile` of a [[fracture]]: what it has there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LevelSection {
    /// Its height; levels go up or down from row to row.
    pub z: Measure<Length>,
    /// Friction angle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_angle: Option<Measure<FrictionAngle>>,
    /// Cohesion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<Measure<Strength>>,
    /// Friction angle after `weakening_distance` of slip.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dynamic_friction_angle: Option<Measure<FrictionAngle>>,
    /// Slip over which friction weakens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weakening_distance: Option<Measure<Distance>>,
    /// Pressure of the fluid inside.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Measure<Stress>>,
}

/// A `profile` that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileProblem {
    /// A value of the whole fracture beside those of its levels.
    #[error("fracture \"{name}\" has `{key}` and a `profile` with `{key}`; give one of them")]
    Twice {
        /// Its name.
        name: String,
        /// The key.
        key: &'static str,
    },
    /// A profile without levels.
    #[error(
        "the `profile` of fracture \"{name}\" is empty; give levels, e.g. profile = [{{ z = \"-1 km\", friction_angle = \"30 deg\" }}, …]"
    )]
    Empty {
        /// The fracture.
        name: String,
    },
    /// A level without values.
    #[error(
        "this level of the `profile` of fracture \"{name}\" has no value; give `friction_angle`, `cohesion`, `dynamic_friction_angle`, `weakening_distance` or `pressure`"
    )]
    Idle {
        /// The fracture.
        name: String,
    },
    /// Levels that go up and down.
    #[error(
        "the levels in the `profile` of fracture \"{name}\" must go down, or up, from row to row: {level} m comes after {before} m"
    )]
    Unsorted {
        /// The fracture.
        name: String,
        /// z of the row [m].
        level: f64,
        /// z of the row before [m].
        before: f64,
    },
}

/// Values between which there are others.
pub trait Between: Copy {
    /// That at a share of the way to `other`, 0 to 1.
    fn between(self, other: Self, share: f64) -> Self;
}

impl Between for f64 {
    fn between(self, other: Self, share: f64) -> Self {
        self + share * (other - self)
    }
}

impl Between for Friction {
    fn between(self, other: Self, share: f64) -> Self {
        let of = |a: f64, b: f64| a.between(b, share);
        let weakening = self.weakening.zip(other.weakening).map(|(a, b)| Weakening {
            angle: of(a.angle, b.angle),
            distance: of(a.distance, b.distance),
            by: a.by,
        });
        Self {
            angle: of(self.angle, other.angle),
            cohesion: of(self.cohesion, other.cohesion),
            weakening,
        }
    }
}

/// A value along z: linear from level to level, constant below the lowest and above the highest.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile<T> {
    /// z [m], increasing, and the value there; at least one.
    levels: Vec<(f64, T)>,
}

impl<T: Between> Profile<T> {
    /// The same everywhere.
    pub fn constant(value: T) -> Self {
        Self {
            levels: vec![(0.0, value)],
        }
    }

    /// The value at z [m].
    pub fn at(&self, z: f64) -> T {
        let above = self.levels.partition_point(|(level, _)| *level < z);
        match (self.levels[..above].last(), self.levels.get(above)) {
            (Some((low, a)), Some((high, b))) => a.between(*b, (z - low) / (high - low)),
            (Some((_, value)), None) | (None, Some((_, value))) => *value,
            (None, None) => unreachable!("a level at least"),
        }
    }

    /// z of the lowest and of the highest level [m]; equal where the value is the same everywhere.
    pub fn range(&self) -> [f64; 2] {
        [self.levels[0].0, self.levels[self.levels.len() - 1].0]
    }

    /// The values at the levels, from the lowest up.
    pub fn values(&self) -> impl Iterator<Item = T> + '_ {
        self.levels.iter().map(|(_, value)| *value)
    }
}

/// A key of a fracture: one value, or one per level of its `profile`.
struct Column(Option<Profile<f64>>);

impl Column {
    /// From the key itself and from the rows that have it.
    ///
    /// # Errors
    /// Both are given.
    fn new<K: Kind>(
        (path, fracture): (&[&str; 2], &FractureSection),
        key: &'static str,
        own: Option<&Measure<K>>,
        of: impl Fn(&LevelSection) -> Option<&Measure<K>>,
    ) -> Result<Self, Located> {
        let rows = fracture.profile.iter().flatten();
        let given = rows.filter_map(|row| Some((row.z.si(), of(row)?.si())));
        let mut levels: Vec<(f64, f64)> = given.collect();
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        match (own, levels.is_empty()) {
            (Some(_), false) => {
                let name = fracture.name.clone();
                let path = [path[0], path[1], key];
                Err(at(&path, ProfileProblem::Twice { name, key }))
            }
            (Some(value), true) => Ok(Self(Some(Profile::constant(value.si())))),
            (None, true) => Ok(Self(None)),
            (None, false) => Ok(Self(Some(Profile { levels }))),
        }
    }

    /// Where it may bend: nowhere if it has one value.
    fn levels(&self) -> impl Iterator<Item = f64> + '_ {
        let bent = self.0.iter().filter(|profile| profile.levels.len() > 1);
        bent.flat_map(|profile| profile.levels.iter().map(|(z, _)| *z))
    }

    /// Its value; 0 where it has none.
    fn at(&self, z: f64) -> f64 {
        self.0.as_ref().map_or(0.0, |profile| profile.at(z))
    }
}

/// Refuses levels that do not go up, or down, from row to row, and rows that say nothing.
fn require_levels(path: &[&str; 2], fracture: &FractureSection) -> Result<(), Located> {
    let Some(rows) = &fracture.profile else {
        return Ok(());
    };
    let name = || fracture.name.clone();
    let refuse = |row: usize, problem: ProfileProblem| {
        let row = row.to_string();
        Err(at(&[path[0], path[1], "profile", &row], problem))
    };
    if rows.is_empty() {
        return Err(at(
            &[path[0], path[1], "profile"],
            ProfileProblem::Empty { name: name() },
        ));
    }
    for (i, row) in rows.iter().enumerate() {
        let says = row.friction_angle.is_some()
            || row.cohesion.is_some()
            || row.dynamic_friction_angle.is_some()
            || row.weakening_distance.is_some()
            || row.pressure.is_some();
        if !says {
            return refuse(i, ProfileProblem::Idle { name: name() });
        }
    }
    let z: Vec<f64> = rows.iter().map(|row| row.z.si()).collect();
    for i in 1..z.len() {
        let (step, first) = (z[i] - z[i - 1], z[1] - z[0]);
        if step == 0.0 || step.signum() != first.signum() {
            let (before, level) = (z[i - 1], z[i]);
            return refuse(
                i,
                ProfileProblem::Unsorted {
                    name: name(),
                    level,
                    before,
                },
            );
        }
    }
    Ok(())
}

/// Friction of a fracture along z; none where the scene gives neither angle nor cohesion.
///
/// # Errors
/// Levels out of order, a key here and there, half of the weakening data.
pub(super) fn friction(
    number: usize,
    fracture: &FractureSection,
) -> Result<Option<Profile<Friction>>, Located> {
    let number = number.to_string();
    let path = ["fracture", number.as_str()];
    require_levels(&path, fracture)?;
    let place = (&path, fracture);
    let angle = Column::new(
        place,
        "friction_angle",
        fracture.friction_angle.as_ref(),
        |row| row.friction_angle.as_ref(),
    )?;
    let cohesion = Column::new(place, "cohesion", fracture.cohesion.as_ref(), |row| {
        row.cohesion.as_ref()
    })?;
    let dynamic = Column::new(
        place,
        "dynamic_friction_angle",
        fracture.dynamic_friction_angle.as_ref(),
        |row| row.dynamic_friction_angle.as_ref(),
    )?;
    let distance = Column::new(
        place,
        "weakening_distance",
        fracture.weakening_distance.as_ref(),
        |row| row.weakening_distance.as_ref(),
    )?;
    let above_zero = |column: &Profile<f64>| column.values().all(|value| value > 0.0);
    let weakens = match (&angle.0, &dynamic.0, &distance.0) {
        (_, None, None) => false,
        (Some(_), Some(_), Some(distance)) if above_zero(distance) => true,
        _ => {
            let name = fracture.name.clone();
            return Err(at(&path, Problem::Weakening { name }));
        }
    };
    if !weakens && fracture.weakening_by.is_some() {
        let (key, without) = ("weakening_by", "dynamic_friction_angle");
        let what = format!("fracture \"{}\"", fracture.name);
        let path = [path[0], path[1], key];
        return Err(at(&path, Problem::Idle { key, what, without }));
    }
    if angle.0.is_none() && cohesion.0.is_none() {
        return Ok(None);
    }
    let columns = [&angle, &cohesion, &dynamic, &distance];
    let mut levels: Vec<f64> = columns.into_iter().flat_map(Column::levels).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    if levels.is_empty() {
        levels.push(0.0);
    }
    let of = |z: f64| Friction {
        angle: angle.at(z),
        cohesion: cohesion.at(z),
        weakening: weakens.then(|| Weakening {
            angle: dynamic.at(z),
            distance: distance.at(z),
            by: fracture.weakening_by.unwrap_or_default(),
        }),
    };
    let levels = levels.into_iter().map(|z| (z, of(z))).collect();
    Ok(Some(Profile { levels }))
}

/// Pressure in a fracture along z [Pa]; 0 where the scene gives none.
///
/// # Errors
/// A pressure of its own and one in the `profile`.
pub(super) fn pressure(number: usize, fracture: &FractureSection) -> Result<Profile<f64>, Located> {
    let number = number.to_string();
    let place = (&["fracture", number.as_str()], fracture);
    let column = Column::new(place, "pressure", fracture.pressure.as_ref(), |row| {
        row.pressure.as_ref()
    })?;
    Ok(column.0.unwrap_or_else(|| Profile::constant(0.0)))
}

impl FractureSection {
    /// True where it has a pressure of its own, here or there.
    pub(super) fn has_pressure(&self) -> bool {
        let mut rows = self.profile.iter().flatten();
        self.pressure.is_some() || rows.any(|row| row.pressure.is_some())
    }
}
