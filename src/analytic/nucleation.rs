//! The length that slip must reach before it runs away.

use super::Rock;

/// Friction that falls linearly with slip, under a constant normal traction.
///
/// # Source
/// K. Uenishi, J. R. Rice, *Universal nucleation length for slip-weakening rupture instability under nonuniform fault
/// loading*, J. Geophys. Res. 108 (2003) 2042.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearWeakening {
    /// Static friction coefficient f_s [1].
    pub static_friction: f64,
    /// Dynamic friction coefficient f_d [1].
    pub dynamic_friction: f64,
    /// Slip at which f_d is reached: d_c [m].
    pub critical_slip: f64,
    /// Normal traction, compression negative [Pa].
    pub normal_traction: f64,
}

/// Share of the nucleation half-length that a face or an element may have, so that where slip runs away does not depend on it. Unit: 1.
pub const RESOLVED: f64 = 0.2;

/// Half-length at instability in units of `G/((1−ν)W)` [1].
const UNIVERSAL: f64 = 0.578_887;

impl LinearWeakening {
    /// Strength lost per slip, `W = (f_s − f_d)|σ_N|/d_c` [Pa/m].
    pub fn slope(self) -> f64 {
        (self.static_friction - self.dynamic_friction) * self.normal_traction.abs()
            / self.critical_slip
    }

    /// [`nucleation_half_length`] of this slope [m].
    pub fn nucleation_half_length(self, rock: Rock) -> f64 {
        nucleation_half_length(rock, self.slope())
    }
}

/// Half-length of the slipping zone at which quasi-static slip has no next step in plane strain,
/// `0.578887 G/((1−ν) W)` [m]; infinite without weakening.
pub fn nucleation_half_length(rock: Rock, slope: f64) -> f64 {
    match slope > 0.0 {
        true => UNIVERSAL * rock.shear() / ((1.0 - rock.poisson) * slope),
        false => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROCK: Rock = Rock {
        young: 25e9,
        poisson: 0.25,
    };
    const FAULT: LinearWeakening = LinearWeakening {
        static_friction: 0.6,
        dynamic_friction: 0.45,
        critical_slip: 5e-3,
        normal_traction: -20e6,
    };

    #[test]
    fn a_fault_of_a_gas_field() {
        // W = 0.15 · 20 MPa / 5 mm = 600 MPa/m; G = 10 GPa; 0.578887 · 10 000 / (0.75 · 600)
        approx::assert_relative_eq!(FAULT.slope(), 600e6, max_relative = 1e-12);
        let half = FAULT.nucleation_half_length(ROCK);
        approx::assert_relative_eq!(half, 12.864_156, max_relative = 1e-6);
    }

    #[test]
    fn the_length_is_inverse_to_the_weakening() {
        let slow = LinearWeakening {
            critical_slip: 4.0 * FAULT.critical_slip,
            ..FAULT
        };
        let ratio = slow.nucleation_half_length(ROCK) / FAULT.nucleation_half_length(ROCK);
        approx::assert_relative_eq!(ratio, 4.0, max_relative = 1e-12);
        let none = LinearWeakening {
            dynamic_friction: 0.6,
            ..FAULT
        };
        assert_eq!(none.nucleation_half_length(ROCK), f64::INFINITY);
    }
}
