//! Dimensions as exponents of base units.

use std::fmt;
use std::ops::{Add, Mul};

/// Exponents of metre, kilogram, second and radian (an angle is kept apart, so that `30 m` is no dip).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dimension {
    /// Exponent of m.
    pub length: i8,
    /// Exponent of kg.
    pub mass: i8,
    /// Exponent of s.
    pub time: i8,
    /// Exponent of rad.
    pub angle: i8,
}

impl Dimension {
    /// A plain number.
    pub const NONE: Self = Self::new(0, 0, 0);
    /// m.
    pub const LENGTH: Self = Self::new(1, 0, 0);
    /// s.
    pub const TIME: Self = Self::new(0, 0, 1);
    /// kg/(m s²) = Pa.
    pub const STRESS: Self = Self::new(-1, 1, -2);
    /// kg/m³.
    pub const DENSITY: Self = Self::new(-3, 1, 0);
    /// m/s².
    pub const ACCELERATION: Self = Self::new(1, 0, -2);
    /// Pa/m.
    pub const STRESS_GRADIENT: Self = Self::new(-2, 1, -2);
    /// Pa s.
    pub const VISCOSITY: Self = Self::new(-1, 1, -1);
    /// 1/Pa.
    pub const COMPRESSIBILITY: Self = Self::new(1, -1, 2);
    /// m²/s.
    pub const DIFFUSIVITY: Self = Self::new(2, 0, -1);
    /// m².
    pub const AREA: Self = Self::new(2, 0, 0);
    /// m³.
    pub const VOLUME: Self = Self::new(3, 0, 0);
    /// m/Pa.
    pub const STORAGE: Self = Self::new(2, -1, 2);
    /// m³/s.
    pub const RATE: Self = Self::new(3, 0, -1);
    /// rad.
    pub const ANGLE: Self = Self {
        length: 0,
        mass: 0,
        time: 0,
        angle: 1,
    };

    /// `m^length kg^mass s^time`.
    pub const fn new(length: i8, mass: i8, time: i8) -> Self {
        Self {
            length,
            mass,
            time,
            angle: 0,
        }
    }
}

impl Add for Dimension {
    type Output = Self;
    /// Dimension of a product.
    fn add(self, other: Self) -> Self {
        Self {
            length: self.length.saturating_add(other.length),
            mass: self.mass.saturating_add(other.mass),
            time: self.time.saturating_add(other.time),
            angle: self.angle.saturating_add(other.angle),
        }
    }
}

impl Mul<i8> for Dimension {
    type Output = Self;
    /// Dimension of a power.
    fn mul(self, power: i8) -> Self {
        Self {
            length: self.length.saturating_mul(power),
            mass: self.mass.saturating_mul(power),
            time: self.time.saturating_mul(power),
            angle: self.angle.saturating_mul(power),
        }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if *self == Self::STRESS {
            return f.write_str("Pa");
        }
        if *self == Self::STRESS_GRADIENT {
            return f.write_str("Pa/m");
        }
        let factors: Vec<String> = [
            ("kg", self.mass),
            ("m", self.length),
            ("s", self.time),
            ("rad", self.angle),
        ]
        .iter()
        .filter(|(_, power)| *power != 0)
        .map(|(symbol, power)| match power {
            1 => (*symbol).to_string(),
            _ => format!("{symbol}^{power}"),
        })
        .collect();
        match factors.is_empty() {
            true => f.write_str("no dimension"),
            false => f.write_str(&factors.join(" ")),
        }
    }
}
