//! PETSc's options as text, the same for as long as the process lasts, so that settings stay plain values.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize};
use std::borrow::Cow;
use std::fmt::{self, Display, Formatter};
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

/// Options as on PETSc's command line: names begin with `-`, and each has one value or none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize)]
pub struct Options(&'static str);

/// A text that PETSc would read otherwise, or in part.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "options = {text:?}: {word:?} is no option of PETSc; write names with a minus, each with one value or none: \"-pc_gamg_agg_nsmooths 1\""
)]
pub struct BadOptions {
    /// All of it.
    pub text: String,
    /// The first word that does not fit.
    pub word: String,
}

/// Every text asked for so far, once.
static TEXTS: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());

impl Options {
    /// The text.
    pub fn as_str(self) -> &'static str {
        self.0
    }
}

impl Display for Options {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.0)
    }
}

/// `-name`, not a negative number.
fn is_name(word: &str) -> bool {
    word.strip_prefix('-')
        .is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_alphabetic()))
}

impl FromStr for Options {
    type Err = BadOptions;

    fn from_str(text: &str) -> Result<Self, BadOptions> {
        let mut may_be_value = false;
        for word in text.split_whitespace() {
            let name = is_name(word);
            let is_plain = word.chars().all(|c| c.is_ascii_graphic() && c != '#');
            if !(is_plain && (name || may_be_value)) {
                return Err(BadOptions {
                    text: text.to_owned(),
                    word: word.to_owned(),
                });
            }
            may_be_value = name;
        }
        let mut texts = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = texts.iter().find(|known| **known == text) {
            return Ok(Self(known));
        }
        let kept: &'static str = Box::leak(text.to_owned().into_boxed_str());
        texts.push(kept);
        Ok(Self(kept))
    }
}

impl<'de> Deserialize<'de> for Options {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

impl JsonSchema for Options {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Options".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_have_one_value_or_none_and_a_text_is_kept_once() {
        let text = "-pc_gamg_threshold -0.01 -mg_levels_ksp_max_it 3 -pc_gamg_reuse_interpolation";
        let options: Options = text.parse().unwrap();
        assert_eq!(options.to_string(), text);
        let again: Options = text.parse().unwrap();
        assert!(std::ptr::eq(options.as_str(), again.as_str()));
        let read: Options = serde_json::from_str("\"\"").unwrap();
        assert_eq!(read, Options::default());
        for (bad, word) in [
            ("pc_gamg_threshold 0", "pc_gamg_threshold"),
            ("-a 1 2", "2"),
            ("-5", "-5"),
            ("-a # b", "#"),
            ("-ä 1", "-ä"),
        ] {
            assert_eq!(bad.parse::<Options>().unwrap_err().word, word);
        }
    }
}
