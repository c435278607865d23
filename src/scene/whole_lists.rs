//! Lists that are read to their end: pairs and arrays of serde do not look at what follows their last entry.

use std::fmt;

use fracas_solvers::words::by_number;
use serde::de::{
    self, DeserializeSeed, Deserializer, EnumAccess, MapAccess, SeqAccess, VariantAccess, Visitor,
};
use serde::forward_to_deserialize_any;

/// A deserializer, or a part that it hands on, that refuses a list with entries that nothing has read.
pub(super) struct WholeLists<P>(pub(super) P);

impl<'de, P: Deserializer<'de>> Deserializer<'de> for WholeLists<P> {
    type Error = P::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, P::Error> {
        self.0.deserialize_any(WholeLists(visitor))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, P::Error> {
        self.0.deserialize_option(WholeLists(visitor))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        visitor: V,
    ) -> Result<V::Value, P::Error> {
        let visitor = WholeLists(visitor);
        self.0.deserialize_newtype_struct(name, visitor)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, P::Error> {
        let visitor = WholeLists(visitor);
        self.0.deserialize_struct(name, fields, visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, P::Error> {
        let visitor = WholeLists(visitor);
        self.0.deserialize_enum(name, variants, visitor)
    }

    // as the crate toml does
    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit
        unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// Hands single values on.
macro_rules! hand_on {
    ($($visit:ident($value:ty);)+) => {
        $(
            fn $visit<E: de::Error>(self, value: $value) -> Result<V::Value, E> {
                self.0.$visit(value)
            }
        )+
    };
}

impl<'de, V: Visitor<'de>> Visitor<'de> for WholeLists<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.expecting(f)
    }

    // what a TOML file holds
    hand_on! {
        visit_bool(bool);
        visit_i64(i64);
        visit_u64(u64);
        visit_i128(i128);
        visit_u128(u128);
        visit_f64(f64);
        visit_str(&str);
        visit_borrowed_str(&'de str);
        visit_string(String);
    }

    fn visit_some<D: Deserializer<'de>>(self, some: D) -> Result<V::Value, D::Error> {
        self.0.visit_some(WholeLists(some))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, inner: D) -> Result<V::Value, D::Error> {
        self.0.visit_newtype_struct(WholeLists(inner))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<V::Value, A::Error> {
        let entries = list.size_hint();
        let value = self.0.visit_seq(WholeLists(&mut list))?;
        // the crate toml knows both
        match (entries, list.size_hint()) {
            (Some(entries), Some(left)) if left > 0 => {
                let read = entries - left;
                let word = by_number(read, "entry", "entries");
                let message =
                    format!("a list of {read} {word} was expected, this one has {entries}");
                Err(de::Error::custom(message))
            }
            _ => Ok(value),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<V::Value, A::Error> {
        self.0.visit_map(WholeLists(map))
    }

    fn visit_enum<A: EnumAccess<'de>>(self, choice: A) -> Result<V::Value, A::Error> {
        self.0.visit_enum(WholeLists(choice))
    }
}

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for WholeLists<S> {
    type Value = S::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<S::Value, D::Error> {
        self.0.deserialize(WholeLists(deserializer))
    }
}

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for WholeLists<A> {
    type Error = A::Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        self.0.next_element_seed(WholeLists(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for WholeLists<A> {
    type Error = A::Error;

    // a key holds no list
    fn next_key_seed<S: DeserializeSeed<'de>>(
        &mut self,
        seed: S,
    ) -> Result<Option<S::Value>, A::Error> {
        self.0.next_key_seed(seed)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, A::Error> {
        self.0.next_value_seed(WholeLists(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.0.size_hint()
    }
}

impl<'de, A: EnumAccess<'de>> EnumAccess<'de> for WholeLists<A> {
    type Error = A::Error;
    type Variant = WholeLists<A::Variant>;

    fn variant_seed<S: DeserializeSeed<'de>>(
        self,
        seed: S,
    ) -> Result<(S::Value, Self::Variant), A::Error> {
        let (name, content) = self.0.variant_seed(seed)?;
        Ok((name, WholeLists(content)))
    }
}

impl<'de, A: VariantAccess<'de>> VariantAccess<'de> for WholeLists<A> {
    type Error = A::Error;

    fn unit_variant(self) -> Result<(), A::Error> {
        self.0.unit_variant()
    }

    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, A::Error> {
        self.0.newtype_variant_seed(WholeLists(seed))
    }

    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, A::Error> {
        self.0.tuple_variant(len, WholeLists(visitor))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        self.0.struct_variant(fields, WholeLists(visitor))
    }
}
