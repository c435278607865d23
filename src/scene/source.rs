//! The text of a scene, and places in it.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

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

    /// Deserializes the text.
    pub(super) fn parse<T: DeserializeOwned>(&self) -> Result<T, SceneError> {
        let parsed = toml::from_str(&self.text).map_err(|e| self.explain(&e))?;
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
            // serde names Rust's types
            message: message.replace("a nonzero u32", "a positive whole number"),
        }
    }
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
