//! Settings that steer: numbers without a theory that fixes them, each with a range, and in its documentation what was measured.
//!
//! They are fields of plain structs in the tree of settings. What builds from them refuses what is out of range, and an experiment halves
//! and doubles one after the other by [`Steering::SETTINGS`].

use serde::{Deserialize, Deserializer, de::Error};

/// Plain settings that know their names and ranges.
pub trait Steering: Copy + Default + 'static {
    /// In the order of the struct.
    const SETTINGS: &'static [Setting<Self>];

    /// The same, where every number is in its range.
    ///
    /// # Errors
    /// [`OutOfRange`] of the first that is not.
    fn checked(self) -> Result<Self, OutOfRange> {
        match Self::SETTINGS.iter().find(|setting| !setting.fits(&self)) {
            None => Ok(self),
            Some(setting) => Err(OutOfRange {
                name: setting.name,
                value: (setting.value)(&self),
                range: setting.range,
            }),
        }
    }
}

/// A number among settings of type `S`.
#[derive(Clone, Copy, Debug)]
pub struct Setting<S> {
    /// Its key.
    pub name: &'static str,
    /// Least and largest value.
    pub range: [f64; 2],
    /// Its value.
    pub value: fn(&S) -> f64,
    /// Another value; whole numbers are rounded.
    pub set: fn(&mut S, f64),
}

impl<S> Setting<S> {
    fn fits(&self, settings: &S) -> bool {
        let [least, most] = self.range;
        (least..=most).contains(&(self.value)(settings))
    }
}

/// A number, with an exponent in place of many zeros.
fn digits(value: f64) -> String {
    const LONGEST: usize = 24;
    let plain = value.to_string();
    match plain.len() <= LONGEST {
        true => plain,
        false => format!("{value:e}"),
    }
}

/// A setting beyond its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {}: expected a number from {} to {}", digits(*value), digits(range[0]), digits(range[1]))]
pub struct OutOfRange {
    /// Its key.
    pub name: &'static str,
    /// What was asked for.
    pub value: f64,
    /// Least and largest value.
    pub range: [f64; 2],
}

/// Reads settings and refuses what is out of range: `#[serde(deserialize_with = "…")]` of the field that nests them.
///
/// # Errors
/// Of the reader, or [`OutOfRange`] as one.
pub fn in_range<'de, S, D>(deserializer: D) -> Result<S, D::Error>
where
    S: Steering + Deserialize<'de>,
    D: Deserializer<'de>,
{
    S::deserialize(deserializer)?
        .checked()
        .map_err(D::Error::custom)
}

/// `f64` or `usize`.
pub trait Number: Copy {
    /// As a real number.
    fn real(self) -> f64;

    /// The nearest to a real number.
    fn nearest(value: f64) -> Self;
}

impl Number for f64 {
    fn real(self) -> f64 {
        self
    }

    fn nearest(value: f64) -> Self {
        value
    }
}

impl Number for usize {
    fn real(self) -> f64 {
        self as f64
    }

    fn nearest(value: f64) -> Self {
        value.round() as usize
    }
}

/// Names and ranges of the settings of a struct that steer: `steering! { Type: field [least, most], … }`.
#[macro_export]
macro_rules! steering {
    ($name:ident: $($field:ident [$least:expr, $most:expr]),* $(,)?) => {
        impl $crate::steering::Steering for $name {
            const SETTINGS: &'static [$crate::steering::Setting<Self>] = &[$($crate::steering::Setting {
                name: stringify!($field),
                range: [$least, $most],
                value: |settings| $crate::steering::Number::real(settings.$field),
                set: |settings, value| settings.$field = $crate::steering::Number::nearest(value),
            },)*];
        }
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Pair {
        share: f64,
        count: usize,
    }

    impl Default for Pair {
        fn default() -> Self {
            Self {
                share: 0.5,
                count: 3,
            }
        }
    }

    steering! { Pair: share [0.0, 1.0], count [1.0, 10.0] }

    #[test]
    fn settings_are_read_set_and_refused_by_their_names() {
        #[derive(Debug, Deserialize)]
        struct Tree {
            #[serde(deserialize_with = "in_range")]
            pair: Pair,
        }
        let read = |text: &str| serde_json::from_str::<Tree>(text).map(|tree| tree.pair);
        assert_eq!(read(r#"{"pair": {}}"#).unwrap(), Pair::default());
        let mut pair = read(r#"{"pair": {"count": 7}}"#).unwrap();
        assert_eq!((pair.share, pair.count), (0.5, 7));
        for (setting, value, name) in [(0, 1.5, "share"), (1, 0.4, "count"), (0, f64::NAN, "share")]
        {
            let before = pair;
            (Pair::SETTINGS[setting].set)(&mut pair, value);
            let refused = pair.checked().unwrap_err();
            assert_eq!(refused.name, name);
            pair = before;
        }
        let refused = read(r#"{"pair": {"share": 2.0}}"#).unwrap_err().to_string();
        assert!(
            refused.contains("share = 2: expected a number from 0 to 1"),
            "{refused}"
        );
        let refused = OutOfRange {
            name: "share",
            value: 0.5,
            range: [1.0, 1e300],
        };
        let refused = refused.to_string();
        assert_eq!(refused, "share = 0.5: expected a number from 1 to 1e300");
    }
}
