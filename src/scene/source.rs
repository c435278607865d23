//! The text of a scene, and places in it.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use super::whole_lists::WholeLists;
use super::{Place, SceneError};
use crate::nearest::nearest;

/// A file name and its text.
#[derive(Clone, Debug)]
pub(super) struct Source {
    text: String,
    file: String,
}

impl Source {
    pub(super) fn new(text: &str, file: &str) -> Self {
        Self {
            text: text.into(),
            file: file.into(),
        }
    }

    pub(super) fn file(&self) -> &str {
        &self.file
    }

    /// Line, column and excerpt of a byte range.
    pub(super) fn place(&self, span: Range<usize>) -> Place {
        let start = span.start.min(self.text.len());
        let begin = self.text[..start].rfind('\n').map_or(0, |i| i + 1);
        let end = self.text[begin..]
            .find('\n')
            .map_or(self.text.len(), |i| begin + i);
        let count = |range: Range<usize>| self.text.get(range).map_or(0, |t| t.chars().count());
        Place {
            file: self.file.clone(),
            line: 1 + self.text[..begin].matches('\n').count(),
            column: 1 + count(begin..start),
            excerpt: self.text[begin..end].trim_end().into(),
            width: count(start..span.end.clamp(start, end)).max(1),
        }
    }

    /// The value at a path of keys and indices, or its nearest ancestor that is written.
    pub(super) fn locate(&self, path: &[&str]) -> Place {
        let Ok(root) = DeTable::parse(&self.text) else {
            return self.place(0..0);
        };
        let mut span = 0..0;
        let mut table: Option<&DeTable> = Some(root.get_ref());
        let mut array: Option<&[toml::Spanned<DeValue>]> = None;
        for segment in path {
            let next = match (table, array) {
                (Some(t), _) => {
                    t.iter()
                        .find(|(k, _)| k.get_ref() == segment)
                        .map(|(k, v)| match v.get_ref() {
                            // a table's own span starts at its first key: its name says more
                            DeValue::Table(_) => (k.span(), v),
                            _ => (v.span(), v),
                        })
                }
                (None, Some(a)) => segment
                    .parse::<usize>()
                    .ok()
                    .and_then(|i| a.get(i))
                    .map(|v| (v.span(), v)),
                (None, None) => None,
            };
            let Some((found, value)) = next else { break };
            span = found;
            table = value.get_ref().as_table();
            array = value.get_ref().as_array().map(|a| a.as_ref());
        }
        self.place(span)
    }

    /// Deserializes the text; entries of lists that the type has no place for are errors.
    pub(super) fn parse<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        let parsed = toml::de::Deserializer::parse(&self.text)
            .and_then(|document| T::deserialize(WholeLists(document)))
            .map_err(|e| self.explain(&e))?;
        let root = DeTable::parse(&self.text).ok();
        let beyond = root.and_then(|root| root.get_ref().iter().find_map(|(_, v)| beyond(v)));
        match beyond {
            // the parser takes it for a count, and nothing could write it again
            Some(span) => Err(SceneError::Syntax {
                place: Box::new(self.place(span)),
                message: format!("the largest integer of a scene is {}", i64::MAX),
            }),
            _ => Ok(parsed),
        }
    }

    /// A parser's error with its place; unknown keys and choices get their nearest match.
    fn explain(&self, error: &toml::de::Error) -> SceneError {
        let place = Box::new(self.place(error.span().unwrap_or(0..0)));
        let message = error.message();
        for (prefix, what) in [("unknown field ", "key"), ("unknown variant ", "value")] {
            let Some(rest) = message.strip_prefix(prefix) else {
                continue;
            };
            // serde: unknown field `a`, expected one of `b`, `c`
            let mut names = rest.split('`').skip(1).step_by(2).map(String::from);
            if let Some(found) = names.next() {
                let known: Vec<String> = names.collect();
                return SceneError::Unknown {
                    place,
                    what,
                    nearest: nearest(&found, &known),
                    found,
                    known,
                };
            }
        }
        SceneError::Syntax {
            place,
            message: in_plain_words(message),
        }
    }
}

/// A message of serde that does not end with the name of a type of Rust.
fn in_plain_words(message: &str) -> String {
    const COUNT: &str = "a whole number, 0 or more";
    for (name, words) in [
        ("a nonzero u32", "a whole number from 1 to 4294967295"),
        ("usize", COUNT),
        ("u64", COUNT),
        ("u32", "a whole number from 0 to 4294967295"),
        ("u8", "a whole number from 0 to 255"),
        ("f64", "a number"),
    ] {
        let start = message.strip_suffix(name).unwrap_or_default();
        if start.ends_with(", expected ") {
            return format!("{start}{words}");
        }
    }
    message.into()
}

/// Where an integer is written that the 64 bits with sign of TOML do not hold.
fn beyond(value: &toml::Spanned<DeValue<'_>>) -> Option<Range<usize>> {
    match value.get_ref() {
        DeValue::Integer(n) => match i64::from_str_radix(n.as_str(), n.radix()) {
            Ok(_) => None,
            Err(_) => Some(value.span()),
        },
        DeValue::Array(array) => array.iter().find_map(beyond),
        DeValue::Table(table) => table.iter().find_map(|(_, v)| beyond(v)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// What is said of a text of keys with values of this type.
    fn said<T: DeserializeOwned>(text: &str) -> String {
        let source = Source::new(text, "s.toml");
        match source.parse::<BTreeMap<String, T>>() {
            Ok(_) => panic!("accepted {text}"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn no_type_of_rust_is_named() {
        let count = "expected a whole number, 0 or more\n";
        let negative = said::<usize>("n = -1");
        let start = format!("s.toml:1:5: invalid value: integer `-1`, {count}");
        assert!(negative.starts_with(&start), "{negative}");
        let text = said::<u64>("n = 'one'");
        assert!(text.contains(count), "{text}");
        for (text, end) in [
            (said::<u32>("n = 5000000000"), "from 0 to 4294967295\n"),
            (said::<u8>("n = 256"), "from 0 to 255\n"),
            (
                said::<std::num::NonZeroU32>("n = 0"),
                "from 1 to 4294967295\n",
            ),
        ] {
            let end = format!(", expected a whole number {end}");
            assert!(text.contains(&end), "{text}");
        }
        let text = said::<f64>("n = 'f64'");
        let start = "s.toml:1:5: invalid type: string \"f64\", expected a number\n";
        assert!(text.starts_with(start), "{text}");
        let text = said::<String>("n = 1");
        assert!(text.contains(", expected a string\n"), "{text}");
        assert_eq!(in_plain_words("the type is usize"), "the type is usize");
    }

    #[test]
    fn what_follows_the_last_entry_of_a_list_is_refused() {
        #[derive(serde::Deserialize)]
        #[serde(rename_all = "lowercase")]
        enum Choice {
            #[allow(dead_code)]
            Pair(Option<[f64; 2]>),
        }
        let pair = said::<(f64, f64)>("n = [1, 2, 'x']");
        let start = "s.toml:1:5: a list of 2 entries was expected, this one has 3\n";
        assert!(pair.starts_with(start), "{pair}");
        let nested = said::<Vec<Option<[u8; 1]>>>("a = [[7]]\nb = [\n[8],\n  [9, {}, []]]");
        let start = "s.toml:4:3: a list of 1 entry was expected, this one has 3\n";
        assert!(nested.starts_with(start), "{nested}");
        let chosen = said::<Choice>("c = { pair = [1, 2, 3] }");
        let start = "s.toml:1:14: a list of 2 entries was expected, this one has 3\n";
        assert!(chosen.starts_with(start), "{chosen}");
        let short = said::<(f64, f64)>("n = [1]");
        assert!(short.starts_with("s.toml:1:5: invalid length 1"), "{short}");
        let whole = Source::new("a = [1, 2]\nb = []\nc = [3]", "s.toml");
        let whole: BTreeMap<String, Vec<u8>> = whole.parse().unwrap();
        assert_eq!(whole.values().map(Vec::len).sum::<usize>(), 3);
    }
}
