//! Quantities with units, parsed at the border: `"25 GPa"`, `"30 deg"`, `"22 kPa/m"`, `"0.25"`.
//!
//! Inside the model every number is SI. [`Quantity`] keeps what was written, so that a scene can be printed back.

mod dimension;
mod kind;
mod symbol;

use std::fmt;
use std::str::FromStr;

pub use dimension::Dimension;
pub use kind::{
    Acceleration, Angle, Area, BiotCoefficient, Compressibility, Conductivity, Density,
    Diffusivity, Distance, Duration, FrictionAngle, Kind, Length, Measure, MeshUnit, Poisson,
    PorePressure, Rate, Ratio, RockViscosity, Stiffness, Storage, Strength, Stress, StressGradient,
    Viscosity,
};

pub(crate) use kind::MOST;

/// A number with a unit: value = number · factor(unit).
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    number: f64,
    unit: String,
    factor: f64,
    dimension: Dimension,
}

impl Quantity {
    /// A number without unit.
    pub fn dimensionless(number: f64) -> Self {
        Self {
            number,
            unit: String::new(),
            factor: 1.0,
            dimension: Dimension::NONE,
        }
    }

    /// So many metres.
    pub(crate) fn metres(number: f64) -> Self {
        Self {
            number,
            unit: "m".into(),
            factor: 1.0,
            dimension: Dimension::LENGTH,
        }
    }

    /// 90 deg.
    pub(crate) fn right_angle() -> Self {
        Self {
            number: 90.0,
            unit: "deg".into(),
            factor: std::f64::consts::PI / 180.0,
            dimension: Dimension::ANGLE,
        }
    }

    /// Value in SI units (angles in radians).
    pub fn si(&self) -> f64 {
        self.number * self.factor
    }

    /// Exponents of length, mass, time and angle.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// Unit as it was written; empty for a plain number.
    pub fn unit(&self) -> &str {
        &self.unit
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.number.abs();
        let plain = magnitude == 0.0 || (1e-4..1e9).contains(&magnitude);
        match plain {
            true => write!(f, "{}", self.number)?,
            false => write!(f, "{:e}", self.number)?,
        }
        match self.unit.is_empty() {
            true => Ok(()),
            false => write!(f, " {}", self.unit),
        }
    }
}

impl FromStr for Quantity {
    type Err = UnitError;

    fn from_str(text: &str) -> Result<Self, UnitError> {
        let trimmed = text.trim();
        let split = number_len(trimmed);
        let number: f64 = trimmed[..split]
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite())
            .ok_or_else(|| UnitError::NotANumber { text: text.into() })?;
        let unit = trimmed[split..].trim();
        let (factor, dimension) = symbol::parse(unit).map_err(|symbol| UnitError::UnknownUnit {
            text: text.into(),
            nearest: symbol::nearest(&symbol),
            symbol,
        })?;
        let quantity = Self {
            number,
            unit: unit.into(),
            factor,
            dimension,
        };
        match quantity.si().is_finite() {
            true => Ok(quantity),
            false => Err(UnitError::NotANumber { text: text.into() }),
        }
    }
}

/// Length of the longest prefix `[+-] digits [. digits] [e [+-] digits]`.
fn number_len(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut i: usize| {
        while bytes.get(i).is_some_and(u8::is_ascii_digit) {
            i += 1;
        }
        i
    };
    let sign = |i: usize| i + usize::from(matches!(bytes.get(i), Some(b'+' | b'-')));
    let mut end = digits(sign(0));
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let start = sign(end + 1);
        let stop = digits(start);
        if stop > start {
            end = stop;
        }
    }
    end
}

/// What is wrong with a written quantity.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UnitError {
    /// No finite number in front.
    #[error(
        "\"{text}\" does not start with a finite number; write a number and a unit, e.g. \"4 m\""
    )]
    NotANumber {
        /// What was written.
        text: String,
    },
    /// A number of which products leave the range of f64.
    #[error(
        "\"{text}\" is out of range: in SI units quantities are 0 or from {:e} to {:e} in size",
        kind::LEAST,
        kind::MOST
    )]
    Extreme {
        /// What was written.
        text: String,
    },
    /// A unit that is not in the table.
    #[error("\"{text}\": unknown unit \"{symbol}\"; nearest known units: {}", nearest.join(", "))]
    UnknownUnit {
        /// What was written.
        text: String,
        /// The symbol that is unknown.
        symbol: String,
        /// Known symbols that look alike.
        nearest: Vec<&'static str>,
    },
    /// A unit of another dimension.
    #[error(
        "\"{text}\" has the unit \"{unit}\" ({found}), expected {kind} ({expected}), e.g. in {examples}"
    )]
    WrongDimension {
        /// What was written.
        text: String,
        /// Its unit.
        unit: String,
        /// Its dimension.
        found: Dimension,
        /// What is expected here.
        kind: &'static str,
        /// Its dimension.
        expected: Dimension,
        /// Units of that dimension.
        examples: &'static str,
    },
    /// A number without unit where one is needed (only zero may go without).
    #[error("\"{text}\" has no unit, expected {kind}, e.g. in {examples}")]
    MissingUnit {
        /// What was written.
        text: String,
        /// What is expected here.
        kind: &'static str,
        /// Units of that dimension.
        examples: &'static str,
    },
    /// A value that cannot be.
    #[error("{kind} is \"{text}\", but it must be {requirement}")]
    OutOfRange {
        /// What was written.
        text: String,
        /// What is expected here.
        kind: &'static str,
        /// The condition on it.
        requirement: &'static str,
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn si(text: &str) -> f64 {
        text.parse::<Quantity>().unwrap().si()
    }

    #[test]
    fn values_in_si() {
        for (text, value) in [
            ("25 GPa", 25e9),
            ("25GPa", 25e9),
            ("4 m", 4.0),
            ("1 mm", 1e-3),
            ("0.25", 0.25),
            ("22 kPa/m", 22e3),
            ("10 bar", 1e6),
            ("1e17 Pa*s", 1e17),
            ("1 day", 86400.0),
            ("2200 kg/m3", 2200.0),
            ("2200 kg/m^3", 2200.0),
            ("2.2 g/cm³", 2200.0),
            ("9.81 m/s^2", 9.81),
            ("180 deg", std::f64::consts::PI),
            ("5 %", 0.05),
            ("1 cP", 1e-3),
            ("1 darcy", 9.869233e-13),
        ] {
            approx::assert_relative_eq!(si(text), value, max_relative = 1e-14);
        }
    }

    #[test]
    fn errors_say_what_was_found_and_what_is_near() {
        let text = |t: &str| t.parse::<Quantity>().unwrap_err().to_string();
        assert_eq!(
            text("25 Gpa"),
            "\"25 Gpa\": unknown unit \"Gpa\"; nearest known units: GPa, Pa, kPa"
        );
        assert!(text("m 4").contains("does not start with a finite number"));
        assert!(text("1e400 m").contains("finite"));
        assert!(text("").contains("finite"));
        let wrong = "4 kg".parse::<Measure<Length>>().unwrap_err().to_string();
        assert_eq!(
            wrong,
            "\"4 kg\" has the unit \"kg\" (kg), expected a length (m), e.g. in m, mm, km"
        );
        let none = "4".parse::<Measure<Length>>().unwrap_err().to_string();
        assert_eq!(
            none,
            "\"4\" has no unit, expected a length, e.g. in m, mm, km"
        );
        let range = "0.5".parse::<Measure<Poisson>>().unwrap_err().to_string();
        assert_eq!(
            range,
            "Poisson's ratio is \"0.5\", but it must be between -1 and 0.5, both excluded"
        );
        let extreme = |text: &str| text.parse::<Measure<Length>>().unwrap_err().to_string();
        assert_eq!(
            extreme("1e-101 m"),
            "\"1e-101 m\" is out of range: in SI units quantities are 0 or from 1e-100 to 1e100 in size"
        );
        assert!(extreme("-1e98 km").contains("out of range"));
        assert_eq!("0".parse::<Measure<Length>>().unwrap().si(), 0.0);
    }

    proptest! {
        #[test]
        fn display_reads_back_the_same_bits(number in proptest::num::f64::NORMAL, unit in 0..5usize) {
            let unit = ["", "m", "GPa", "kPa/m", "Pa*s"][unit];
            let Ok(quantity) = format!("{number:e} {unit}").parse::<Quantity>() else {
                return Ok(()); // overflow in SI units
            };
            let back: Quantity = quantity.to_string().parse().unwrap();
            prop_assert_eq!(back.si().to_bits(), quantity.si().to_bits());
            prop_assert_eq!(back.dimension(), quantity.dimension());
        }

        #[test]
        fn no_text_panics(text in "\\PC*") {
            let _ = text.parse::<Quantity>();
        }
    }
}
