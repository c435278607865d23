//! What a study varies.

use super::{Choice, Inner, Load};
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, SaddleMethod};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use toml::{Table, Value};

/// Lists of values; rows are their product.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// Scene files, or names of the gallery.
    #[serde(default)]
    pub scene: Vec<String>,
    /// System folders; `set` and `refine` are not for them.
    #[serde(default)]
    pub system: Vec<String>,
    /// Values of keys of the scenes.
    #[serde(default, deserialize_with = "flattened")]
    pub set: BTreeMap<String, Vec<Value>>,
    /// Factors on every cell count of the grid.
    #[serde(default = "one_factor")]
    pub refine: Vec<NonZeroU32>,
    /// Right-hand sides.
    #[serde(default = "one_default")]
    pub rhs: Vec<Choice<Load>>,
    /// Preconditioners of the whole system.
    #[serde(default = "one_default")]
    pub method: Vec<Choice<SaddleMethod>>,
    /// C.
    #[serde(default = "one_default")]
    pub augmentation: Vec<Choice<AugmentationChoice>>,
    /// Solvers of the displacement block.
    #[serde(default = "one_default")]
    pub inner: Vec<Choice<Inner>>,
    /// Iterations.
    #[serde(default = "one_default")]
    pub krylov: Vec<Choice<KrylovChoice>>,
    /// Tolerances.
    #[serde(default = "one_tolerance")]
    pub tolerance: Vec<Tolerance>,
}

fn one_factor() -> Vec<NonZeroU32> {
    vec![NonZeroU32::MIN]
}

fn one_default<D: Default>() -> Vec<D> {
    vec![D::default()]
}

fn one_tolerance() -> Vec<Tolerance> {
    vec![Tolerance(1e-8)]
}

impl Default for Axes {
    fn default() -> Self {
        Self {
            scene: Vec::new(),
            system: Vec::new(),
            set: BTreeMap::new(),
            refine: one_factor(),
            rhs: one_default(),
            method: one_default(),
            augmentation: one_default(),
            inner: one_default(),
            krylov: one_default(),
            tolerance: one_tolerance(),
        }
    }
}

/// Between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance(pub(super) f64);

impl TryFrom<f64> for Tolerance {
    type Error = &'static str;

    fn try_from(value: f64) -> Result<Self, Self::Error> {
        match value > 0.0 && value < 1.0 {
            true => Ok(Self(value)),
            false => Err("a tolerance is a number between 0 and 1"),
        }
    }
}

impl<'de> Deserialize<'de> for Tolerance {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        f64::deserialize(deserializer)?
            .try_into()
            .map_err(serde::de::Error::custom)
    }
}

impl Serialize for Tolerance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0)
    }
}

/// Keys of nested tables joined by dots; what is no list is a list of one.
fn flattened<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, Vec<Value>>, D::Error> {
    let mut flat = BTreeMap::new();
    flatten(&Table::deserialize(deserializer)?, "", &mut |key, value| {
        let values = match value {
            Value::Array(values) => values.clone(),
            single => vec![single.clone()],
        };
        flat.insert(key, values);
    });
    Ok(flat)
}

/// Gives every value of nested tables with its dotted key.
pub(super) fn flatten(table: &Table, before: &str, give: &mut impl FnMut(String, &Value)) {
    for (key, value) in table {
        let key = format!("{before}{key}");
        match value {
            Value::Table(inner) => flatten(inner, &format!("{key}."), give),
            value => give(key, value),
        }
    }
}
