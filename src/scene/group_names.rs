//! Physical groups of a mesh file, as a scene writes them.

use std::fmt;

use schemars::JsonSchema;
use serde::de::{self, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::mesh::GroupName;

/// A physical group by name or number, or a list of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GroupNames(pub Vec<GroupName>);

impl fmt::Display for GroupNames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, name) in self.0.iter().enumerate() {
            write!(f, "{}{name}", if i == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}

/// One group in TOML.
struct One<'a>(&'a GroupName);

impl Serialize for One<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            GroupName::Name(name) => serializer.serialize_str(name),
            GroupName::Number(number) => serializer.serialize_i32(*number),
        }
    }
}

impl Serialize for GroupNames {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.as_slice() {
            [one] => One(one).serialize(serializer),
            many => serializer.collect_seq(many.iter().map(One)),
        }
    }
}

/// One group from TOML.
struct Entry(GroupName);

/// Reads one group, and where `LIST` allows it a list of them.
struct Names<const LIST: bool>;

impl<'de, const LIST: bool> Visitor<'de> for Names<LIST> {
    type Value = Vec<GroupName>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = if LIST { ", or a list of them" } else { "" };
        write!(f, "the name or the number of a physical group{list}")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<Self::Value, E> {
        Ok(vec![GroupName::Name(name.into())])
    }

    fn visit_i64<E: de::Error>(self, number: i64) -> Result<Self::Value, E> {
        let number = i32::try_from(number)
            .map_err(|_| E::invalid_value(de::Unexpected::Signed(number), &self))?;
        Ok(vec![GroupName::Number(number)])
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Self::Value, A::Error> {
        if !LIST {
            return Err(de::Error::invalid_type(de::Unexpected::Seq, &self));
        }
        let mut names = Vec::new();
        while let Some(Entry(name)) = list.next_element()? {
            names.push(name);
        }
        match names.is_empty() {
            true => Err(de::Error::invalid_length(0, &self)),
            false => Ok(names),
        }
    }
}

impl<'de> Deserialize<'de> for Entry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut names = deserializer.deserialize_any(Names::<false>)?;
        names
            .pop()
            .map(Entry)
            .ok_or_else(|| de::Error::invalid_length(0, &Names::<false>))
    }
}

impl<'de> Deserialize<'de> for GroupNames {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Names::<true>).map(Self)
    }
}

impl JsonSchema for GroupNames {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "physical groups".into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "type": ["string", "integer", "array"],
            "items": { "type": ["string", "integer"] },
            "minItems": 1,
            "description": "a physical group of the mesh file by name or number, or a list of them",
        })
    }
}
