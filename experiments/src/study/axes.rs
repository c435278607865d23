//! What a study varies.

use super::{Choice, Inner, Load, Name, Setting, State};
use fracas::units::Quantity;
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, SaddleMethod};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::num::NonZeroU32;
use toml::{Table, Value};

/// Lists of values; rows are their product.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axes {
    /// Name of these rows, where a study has several products.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub part: String,
    /// What is measured of these rows; by default what the study asks for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<Name>,
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
    /// Values that go together under a name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub together: Vec<Together>,
    /// Contact states.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub state: Vec<State>,
    /// Factors of H.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stabilization: Vec<f64>,
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
    /// Threads of a row.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub threads: Vec<u16>,
}

/// `[[axes.together]]`: an axis of variants, each with its own values of several keys.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Together {
    /// Name of the axis.
    pub name: String,
    /// Its variants.
    pub values: Vec<Setting>,
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
            part: String::new(),
            measures: Vec::new(),
            scene: Vec::new(),
            system: Vec::new(),
            set: BTreeMap::new(),
            refine: one_factor(),
            together: Vec::new(),
            state: Vec::new(),
            stabilization: Vec::new(),
            rhs: one_default(),
            method: one_default(),
            augmentation: one_default(),
            inner: one_default(),
            krylov: one_default(),
            tolerance: one_tolerance(),
            threads: Vec::new(),
        }
    }
}

impl Axes {
    /// True where rows have scenes.
    pub(super) fn has_scenes(&self) -> bool {
        let mut variants = self.together.iter().flat_map(|t| &t.values);
        !self.scene.is_empty() || variants.any(|variant| variant.scene.is_some())
    }

    /// True where rows have system folders.
    pub(super) fn has_systems(&self) -> bool {
        let mut variants = self.together.iter().flat_map(|t| &t.values);
        !self.system.is_empty() || variants.any(|variant| variant.system.is_some())
    }

    /// A key that says which system a scene becomes, where one is said.
    pub(super) fn of_scenes(&self) -> Option<&'static str> {
        let variants = || self.together.iter().flat_map(|t| &t.values);
        let state = !self.state.is_empty() || variants().any(|v| v.state.is_some());
        let factor =
            !self.stabilization.is_empty() || variants().any(|v| v.stabilization.is_some());
        match (state, factor) {
            (true, _) => Some("state"),
            (false, true) => Some("stabilization"),
            (false, false) => None,
        }
    }

    /// A key that says how a system is solved, where one is said.
    pub(super) fn of_solves(&self) -> Option<&'static str> {
        let none = Self::default();
        let said = [
            ("rhs", self.rhs != none.rhs),
            ("method", self.method != none.method),
            ("augmentation", self.augmentation != none.augmentation),
            ("inner", self.inner != none.inner),
            ("krylov", self.krylov != none.krylov),
        ];
        let own = said.iter().find(|(_, said)| *said).map(|(key, _)| *key);
        let variants = self.together.iter().flat_map(|t| &t.values);
        let mut keys = variants.flat_map(Setting::said);
        own.or_else(|| keys.find(|key| said.iter().any(|(known, _)| known == key)))
    }

    /// An axis and a value that stands in it twice.
    pub(super) fn repeated(&self) -> Option<(String, String)> {
        let mut found = None;
        let Ok(axes) = Table::try_from(self) else {
            return None;
        };
        flatten(&axes, "", &mut |key, value| {
            let (Value::Array(values), false) = (value, key == "measures") else {
                return;
            };
            let lists: Vec<(&str, &Value)> = match key.as_str() {
                "together" => (values.iter())
                    .filter_map(|axis| Some((axis.get("name")?.as_str()?, axis.get("values")?)))
                    .collect(),
                key => vec![(key, value)],
            };
            for (name, list) in lists {
                let list = list.as_array().map_or(&[][..], Vec::as_slice);
                let is_again = |k: &usize| list[..*k].iter().any(|v| is_same(v, &list[*k]));
                let again = (1..list.len()).find(is_again);
                if let (Some(k), None) = (again, &found) {
                    let name = name.strip_prefix("set.").unwrap_or(name);
                    found = Some((name.to_owned(), shown(&list[k])));
                }
            }
        });
        found
    }

    /// Scenes and systems, those of variants included.
    pub(super) fn sources(&mut self) -> (Vec<&mut String>, Vec<&mut String>) {
        let mut scenes: Vec<&mut String> = self.scene.iter_mut().collect();
        let mut systems: Vec<&mut String> = self.system.iter_mut().collect();
        for variant in self.together.iter_mut().flat_map(|t| &mut t.values) {
            scenes.extend(&mut variant.scene);
            systems.extend(&mut variant.system);
        }
        (scenes, systems)
    }
}

/// Two values of an axis that are one: numbers, or quantities, of one size. Variants of one name may differ: a bar or a point for both.
fn is_same(a: &Value, b: &Value) -> bool {
    let number = |v: &Value| v.as_float().or(v.as_integer().map(|i| i as f64));
    let si = |v: &Value| v.as_str()?.parse::<Quantity>().ok().map(|q| q.si());
    let equal = |a: Option<f64>, b: Option<f64>| a.is_some() && a == b;
    a == b || equal(number(a), number(b)) || equal(si(a), si(b))
}

/// A value as it is written; of a variant its name.
fn shown(value: &Value) -> String {
    match value.get("name").unwrap_or(value) {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// `[axes]`, or several `[[axes]]` whose rows follow each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Products(pub Vec<Axes>);

impl<'de> Deserialize<'de> for Products {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrMany;
        impl<'de> Visitor<'de> for OneOrMany {
            type Value = Products;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("[axes] or several [[axes]]")
            }

            fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<Products, M::Error> {
                let axes = Axes::deserialize(MapAccessDeserializer::new(map))?;
                Ok(Products(vec![axes]))
            }

            fn visit_seq<S: SeqAccess<'de>>(self, seq: S) -> Result<Products, S::Error> {
                Deserialize::deserialize(SeqAccessDeserializer::new(seq)).map(Products)
            }
        }
        deserializer.deserialize_any(OneOrMany)
    }
}

impl Serialize for Products {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [one] => one.serialize(serializer),
            many => many.serialize(serializer),
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
