//! Values of axes that have names.

use fracas::solve::{InnerRule, RightHandSide};
use fracas_operators::random::Random;
use fracas_solvers::saddle::InnerChoice;
use fracas_solvers::saddle::inner::UnknownInner;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};
use std::fmt;
use std::str::FromStr;
use toml::Value;

/// What leaves the choice to the program.
const DEFAULT: &str = "default";

/// A name and what it stands for; `default` stands for nothing chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice<V> {
    text: String,
    /// Absent for `default`.
    pub value: Option<V>,
}

impl<V> Default for Choice<V> {
    fn default() -> Self {
        Self {
            text: DEFAULT.into(),
            value: None,
        }
    }
}

impl<V> fmt::Display for Choice<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl<V: FromStr> FromStr for Choice<V> {
    type Err = V::Err;

    fn from_str(text: &str) -> Result<Self, V::Err> {
        if text == DEFAULT {
            return Ok(Self::default());
        }
        Ok(Self {
            text: text.into(),
            value: Some(text.parse()?),
        })
    }
}

/// A name, or a table of settings, whose text is the table.
impl<'de, V: DeserializeOwned> Deserialize<'de> for Choice<V> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        let text = match &value {
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        Ok(match text.as_str() {
            DEFAULT => Self::default(),
            _ => Self {
                value: Some(value.try_into().map_err(de::Error::custom)?),
                text,
            },
        })
    }
}

impl<V> Serialize for Choice<V> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let table = self.text.starts_with('{').then(|| self.text.parse());
        match table {
            Some(Ok(table)) => Value::serialize(&table, serializer),
            _ => serializer.serialize_str(&self.text),
        }
    }
}

/// An inner solver by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inner {
    /// What fits the system.
    Auto,
    /// This one.
    Named(InnerChoice),
}

impl<'de> Deserialize<'de> for Inner {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = Value::deserialize(deserializer)?;
        match value.as_str() {
            Some(name) => name.parse().map_err(de::Error::custom),
            None => (value.try_into().map(Self::Named)).map_err(de::Error::custom),
        }
    }
}

impl FromStr for Inner {
    type Err = UnknownInnerName;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        if name == "auto" {
            return Ok(Self::Auto);
        }
        name.parse().map(Self::Named).map_err(UnknownInnerName)
    }
}

impl Inner {
    /// The solver that is named, and what may take its place.
    pub fn choose(inner: Option<Self>) -> (Option<InnerChoice>, InnerRule) {
        match inner {
            None => (None, InnerRule::OrElse),
            Some(Self::Auto) => (None, InnerRule::Auto),
            Some(Self::Named(inner)) => (Some(inner), InnerRule::Fixed),
        }
    }
}

/// A name that no inner solver has.
#[derive(Debug, thiserror::Error)]
#[error("{0}; or auto")]
pub struct UnknownInnerName(UnknownInner);

/// A right-hand side by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Load {
    /// One that the program knows.
    Known(RightHandSide),
    /// Independent entries, uniform in [−1, 1), from a seed.
    Random(u64),
}

/// A name that no right-hand side has.
#[derive(Debug, thiserror::Error)]
#[error("no right-hand side `{0}`; there are system, sin, ones and random:SEED")]
pub struct UnknownLoad(String);

impl<'de> Deserialize<'de> for Load {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map_err(de::Error::custom)
    }
}

impl FromStr for Load {
    type Err = UnknownLoad;

    fn from_str(name: &str) -> Result<Self, UnknownLoad> {
        let unknown = || UnknownLoad(name.into());
        match name {
            "system" => Ok(Self::Known(RightHandSide::System)),
            "sin" => Ok(Self::Known(RightHandSide::Sin)),
            "ones" => Ok(Self::Known(RightHandSide::Ones)),
            _ => {
                let seed = name.strip_prefix("random:").ok_or_else(unknown)?;
                seed.parse().map(Self::Random).map_err(|_| unknown())
            }
        }
    }
}

impl Load {
    /// What `solve` is asked for.
    pub(super) fn known(self) -> RightHandSide {
        match self {
            Self::Known(rhs) => rhs,
            Self::Random(_) => RightHandSide::Given,
        }
    }

    /// The entries, where `solve` does not know them.
    pub(super) fn entries(self, n: usize) -> Option<Vec<f64>> {
        let Self::Random(seed) = self else {
            return None;
        };
        let mut random = Random::new(seed);
        Some((0..n).map(|_| random.between(-1.0, 1.0)).collect())
    }
}
