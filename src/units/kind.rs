//! Quantities of a known kind, checked when they are read.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::{Dimension, Quantity, UnitError};

/// Smallest and largest size of a quantity but 0, in SI units: of larger and smaller ones products leave the range of f64 (1e±308).
pub(super) const LEAST: f64 = 1e-100;
pub(crate) const MOST: f64 = 1e100;

/// What a quantity means: its dimension and the values that it may take.
pub trait Kind {
    /// Name with article, for messages.
    const NAME: &'static str;
    /// Its dimension.
    const DIMENSION: Dimension;
    /// Some of its units, for messages.
    const EXAMPLES: &'static str;
    /// Condition on the value, for messages.
    const REQUIREMENT: &'static str = "finite";
    /// Whether the condition holds for a value in SI units.
    fn admits(_si: f64) -> bool {
        true
    }
}

macro_rules! kind {
    ($name:ident, $text:literal, $dimension:ident, $examples:literal $(, $requirement:literal, $admits:expr)?) => {
        #[doc = concat!("Kind: ", $text, ".")]
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name;
        impl Kind for $name {
            const NAME: &'static str = $text;
            const DIMENSION: Dimension = Dimension::$dimension;
            const EXAMPLES: &'static str = $examples;
            $(const REQUIREMENT: &'static str = $requirement;
            fn admits(si: f64) -> bool {
                let admits: fn(f64) -> bool = $admits;
                admits(si)
            })?
        }
    };
}

kind!(Length, "a length", LENGTH, "m, mm, km");
kind!(
    Distance,
    "a distance",
    LENGTH,
    "um, mm, m",
    "zero or positive",
    |v| v >= 0.0
);
kind!(
    Duration,
    "a time",
    TIME,
    "s, h, day, year",
    "zero or positive",
    |v| v >= 0.0
);
kind!(Area, "an area", AREA, "m2, km2", "positive", |v| v > 0.0);
kind!(
    MeshUnit,
    "the unit of a mesh",
    LENGTH,
    "m, mm, km",
    "positive",
    |v| v > 0.0
);
kind!(Angle, "an angle", ANGLE, "deg, rad");
kind!(Stress, "a stress", STRESS, "Pa, MPa, bar");
kind!(
    PorePressure,
    "a pore pressure",
    STRESS,
    "Pa, MPa, bar",
    "zero or positive",
    |v| v >= 0.0
);
kind!(
    StressGradient,
    "a stress gradient",
    STRESS_GRADIENT,
    "Pa/m, kPa/m, bar/m"
);
kind!(Acceleration, "an acceleration", ACCELERATION, "m/s^2");
kind!(
    Stiffness,
    "Young's modulus",
    STRESS,
    "Pa, MPa, GPa",
    "positive",
    |v| v > 0.0
);
kind!(
    Strength,
    "a strength",
    STRESS,
    "Pa, MPa, bar",
    "zero or positive",
    |v| v >= 0.0
);
kind!(
    Density,
    "a density",
    DENSITY,
    "kg/m3, g/cm3",
    "zero or positive",
    |v| v >= 0.0
);
kind!(
    Poisson,
    "Poisson's ratio",
    NONE,
    "no unit",
    "between -1 and 0.5, both excluded",
    |v| v > -1.0 && v < 0.5
);
kind!(Ratio, "a ratio", NONE, "no unit", "positive", |v| v > 0.0);
kind!(
    FrictionAngle,
    "a friction angle",
    ANGLE,
    "deg, rad",
    "at least 0 and less than 90 deg",
    |v| (0.0..std::f64::consts::FRAC_PI_2).contains(&v)
);

kind!(
    Viscosity,
    "a viscosity",
    VISCOSITY,
    "Pa*s, cP",
    "positive",
    |v| v > 0.0
);
kind!(
    RockViscosity,
    "the viscosity of rock",
    VISCOSITY,
    "Pa*s",
    "positive",
    |v| v > 0.0
);
kind!(
    Compressibility,
    "a compressibility",
    COMPRESSIBILITY,
    "1/Pa, 1/GPa",
    "zero or positive",
    |v| v >= 0.0
);
kind!(
    Conductivity,
    "the conductivity of a fracture",
    VOLUME,
    "m3, mm3",
    "positive",
    |v| v > 0.0
);
kind!(
    Diffusivity,
    "a diffusivity",
    DIFFUSIVITY,
    "m2/s, m2/day",
    "positive",
    |v| v > 0.0
);
kind!(
    Storage,
    "the storage of a fracture",
    STORAGE,
    "m/Pa, mm/MPa",
    "zero or positive",
    |v| v >= 0.0
);
kind!(Rate, "a rate", RATE, "m3/s, L/s, L/min");
kind!(
    BiotCoefficient,
    "Biot's coefficient",
    NONE,
    "no unit",
    "at least 0 and at most 1",
    |v| (0.0..=1.0).contains(&v)
);

/// A quantity of kind `K`.
pub struct Measure<K> {
    quantity: Quantity,
    kind: PhantomData<K>,
}

impl<K: Kind> Measure<K> {
    /// Value in SI units.
    pub fn si(&self) -> f64 {
        self.quantity.si()
    }

    /// Checks dimension and range.
    ///
    /// # Errors
    /// [`UnitError`] that names the unit found, the kind expected and units that fit. Zero needs no unit.
    pub fn new(quantity: Quantity) -> Result<Self, UnitError> {
        let text = quantity.to_string();
        let zero = quantity.si() == 0.0 && quantity.unit().is_empty();
        if quantity.dimension() != K::DIMENSION && !zero {
            return Err(match quantity.unit() {
                "" => UnitError::MissingUnit {
                    text,
                    kind: K::NAME,
                    examples: K::EXAMPLES,
                },
                unit => UnitError::WrongDimension {
                    unit: unit.into(),
                    text,
                    found: quantity.dimension(),
                    kind: K::NAME,
                    expected: K::DIMENSION,
                    examples: K::EXAMPLES,
                },
            });
        }
        let size = quantity.si().abs();
        if size != 0.0 && !(LEAST..=MOST).contains(&size) {
            return Err(UnitError::Extreme { text });
        }
        if !K::admits(quantity.si()) {
            return Err(UnitError::OutOfRange {
                text,
                kind: K::NAME,
                requirement: K::REQUIREMENT,
            });
        }
        Ok(Self {
            quantity,
            kind: PhantomData,
        })
    }
}

impl Measure<Length> {
    /// So many metres.
    pub(crate) fn metres(value: f64) -> Self {
        Self {
            quantity: Quantity::metres(value),
            kind: PhantomData,
        }
    }
}

impl Measure<Ratio> {
    /// A positive number.
    pub(crate) fn ratio(value: f64) -> Self {
        Self {
            quantity: Quantity::dimensionless(value),
            kind: PhantomData,
        }
    }
}

impl Measure<Angle> {
    /// 90 deg.
    pub(crate) fn right() -> Self {
        Self {
            quantity: Quantity::right_angle(),
            kind: PhantomData,
        }
    }
}

impl<K> Clone for Measure<K> {
    fn clone(&self) -> Self {
        Self {
            quantity: self.quantity.clone(),
            kind: PhantomData,
        }
    }
}

impl<K> PartialEq for Measure<K> {
    fn eq(&self, other: &Self) -> bool {
        self.quantity == other.quantity
    }
}

impl<K> fmt::Debug for Measure<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.quantity)
    }
}

impl<K> fmt::Display for Measure<K> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.quantity)
    }
}

impl<K: Kind> FromStr for Measure<K> {
    type Err = UnitError;
    fn from_str(text: &str) -> Result<Self, UnitError> {
        Self::new(text.parse()?)
    }
}

impl<K> Serialize for Measure<K> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.quantity.unit() {
            "" => serializer.serialize_f64(self.quantity.si()),
            _ => serializer.collect_str(&self.quantity),
        }
    }
}

impl<'de, K: Kind> Deserialize<'de> for Measure<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Visitor<K>(PhantomData<K>);
        impl<K: Kind> de::Visitor<'_> for Visitor<K> {
            type Value = Measure<K>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}, e.g. in {}", K::NAME, K::EXAMPLES)
            }
            fn visit_str<E: de::Error>(self, text: &str) -> Result<Measure<K>, E> {
                text.parse().map_err(E::custom)
            }
            fn visit_f64<E: de::Error>(self, number: f64) -> Result<Measure<K>, E> {
                if !number.is_finite() {
                    return Err(E::custom(UnitError::NotANumber {
                        text: number.to_string(),
                    }));
                }
                Measure::new(Quantity::dimensionless(number)).map_err(E::custom)
            }
            fn visit_i64<E: de::Error>(self, number: i64) -> Result<Measure<K>, E> {
                self.visit_f64(number as f64)
            }
        }
        deserializer.deserialize_any(Visitor(PhantomData))
    }
}

impl<K: Kind> schemars::JsonSchema for Measure<K> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        K::NAME.into()
    }
    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let article = format!("{}, in {}; {}", K::NAME, K::EXAMPLES, K::REQUIREMENT);
        schemars::json_schema!({ "type": ["string", "number"], "description": article })
    }
}
