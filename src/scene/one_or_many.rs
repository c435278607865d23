//! One quantity or a list of them.

use std::fmt;
use std::marker::PhantomData;

use schemars::JsonSchema;
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::units::{Kind, Measure};

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

    /// All of them, to change.
    pub(super) fn as_mut_slice(&mut self) -> &mut [Measure<K>] {
        match self {
            Self::One(one) => std::slice::from_mut(one),
            Self::Many(many) => many,
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
