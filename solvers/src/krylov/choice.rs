//! Reading and writing a [`KrylovChoice`]: `gmres`, `gmres:50`, `{ gmres = { restart = 50 } }`.

use super::{Fgmres, Gmres, KrylovChoice, METHODS};
use crate::written::{self, Written};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

/// A method that does not exist or a restart that makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownMethod {
    /// No method of this name.
    #[error("no Krylov method `{found}`; there are cg, minres, sqmr, gmres, fgmres, bicgstab{}", METHODS.names())]
    Name {
        /// As written.
        found: String,
    },
    /// Not a positive number after the colon.
    #[error("`{found}` is no restart length; write for example {method}:50")]
    Restart {
        /// The method.
        method: &'static str,
        /// As written.
        found: String,
    },
    /// A restart for a method that has none.
    #[error("{method} has no restart length")]
    NoRestart {
        /// The method.
        method: &'static str,
    },
}

impl fmt::Display for KrylovChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gmres(Gmres { restart }) | Self::Fgmres(Fgmres { restart }) => {
                write!(f, "{}:{restart}", self.name())
            }
            _ => f.write_str(self.name()),
        }
    }
}

impl FromStr for KrylovChoice {
    type Err = UnknownMethod;

    fn from_str(text: &str) -> Result<Self, UnknownMethod> {
        let (name, length) = match text.split_once(':') {
            Some((name, length)) => (name, Some(length)),
            None => (text, None),
        };
        let mut choice = Self::all()
            .into_iter()
            .find(|choice| choice.name() == name)
            .or_else(|| METHODS.find(name).map(Self::Other))
            .ok_or_else(|| UnknownMethod::Name { found: text.into() })?;
        let Some(length) = length else {
            return Ok(choice);
        };
        let method = choice.name();
        match &mut choice {
            Self::Gmres(Gmres { restart }) | Self::Fgmres(Fgmres { restart }) => {
                *restart = length.parse().map_err(|_| UnknownMethod::Restart {
                    method,
                    found: length.into(),
                })?;
                Ok(choice)
            }
            _ => Err(UnknownMethod::NoRestart { method }),
        }
    }
}

impl Serialize for KrylovChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for KrylovChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        written::read(deserializer)
    }
}

impl Written for KrylovChoice {
    const EXPECTED: &'static str =
        "a Krylov method such as \"gmres:50\" or { gmres = { restart = 50 } }";

    fn from_table<'de, D: Deserializer<'de>>(table: D) -> Result<Self, D::Error> {
        Self::deserialize(table)
    }
}

impl JsonSchema for KrylovChoice {
    fn schema_name() -> Cow<'static, str> {
        "KrylovChoice".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let empty = json_schema!({ "type": "object", "additionalProperties": false });
        let restarted = json_schema!({
            "type": "object",
            "properties": { "restart": { "type": "integer", "minimum": 1 } },
            "additionalProperties": false
        });
        let tables: serde_json::Map<String, serde_json::Value> = Self::all()
            .iter()
            .map(|choice| {
                let settings = match choice {
                    Self::Gmres(_) | Self::Fgmres(_) => &restarted,
                    _ => &empty,
                };
                (choice.name().to_owned(), settings.clone().to_value())
            })
            .collect();
        let names: Vec<&str> = Self::all().iter().map(Self::name).collect();
        json_schema!({
            "description": "A Krylov method: \"gmres\", \"gmres:50\" or { gmres = { restart = 50 } }.",
            "anyOf": [
                { "type": "string", "pattern": format!("^({})$|^f?gmres:[1-9][0-9]*$", names.join("|")) },
                {
                    "type": "object", "properties": tables, "additionalProperties": false,
                    "minProperties": 1, "maxProperties": 1
                }
            ]
        })
    }
}
