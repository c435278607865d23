//! Parts as people write them: by name, or as a table with the name for its key and settings behind it.

use serde::Deserializer;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use std::fmt::{Display, Formatter, Result as Formatted};
use std::marker::PhantomData;
use std::str::FromStr;

/// A family of parts that is written so; an unknown key is answered with the keys that there are.
pub(crate) trait Written: FromStr<Err: Display> {
    /// What is read, with an example of both.
    const EXPECTED: &'static str;

    /// From `{ name = settings }`.
    fn from_table<'de, D: Deserializer<'de>>(table: D) -> Result<Self, D::Error>;
}

/// Reads both spellings.
pub(crate) fn read<'de, T: Written, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
    from.deserialize_any(NameOrTable(PhantomData))
}

struct NameOrTable<T>(PhantomData<T>);

impl<'de, T: Written> Visitor<'de> for NameOrTable<T> {
    type Value = T;

    fn expecting(&self, f: &mut Formatter<'_>) -> Formatted {
        f.write_str(T::EXPECTED)
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<T, E> {
        name.parse().map_err(E::custom)
    }

    fn visit_map<M: MapAccess<'de>>(self, mut table: M) -> Result<T, M::Error> {
        let part = T::from_table(MapAccessDeserializer::new(&mut table))?;
        // an enum reads one key and leaves the others
        match table.next_key::<String>()? {
            None => Ok(part),
            Some(key) => Err(Error::custom(format_args!(
                "`{key}` stands beside another name; one part is asked for: {}",
                T::EXPECTED
            ))),
        }
    }
}
