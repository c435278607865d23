//! A disc-shaped crack, opened by pressure or by volume.

use super::Rock;

/// A circular crack of radius R in unbounded rock, opened from inside:
/// ```text
/// w(r) = (8(1−ν²) p/(πE)) √(R² − r²)      r ≤ R        V = 16(1−ν²) p R³/(3E)
/// ```
///
/// # Source
/// I. N. Sneddon, *The distribution of stress in the neighbourhood of a crack in an elastic solid*, Proc. R. Soc. A 187
/// (1946) 229–260.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PennyCrack {
    /// The rock.
    pub rock: Rock,
    /// Radius R [m].
    pub radius: f64,
    /// Pressure p above the stress that closes the crack [Pa].
    pub pressure: f64,
}

impl PennyCrack {
    /// The crack that holds a volume V [m³] at uniform pressure: `p = 3EV/(16(1−ν²)R³)`.
    pub fn of_volume(rock: Rock, radius: f64, volume: f64) -> Self {
        let per_pressure = 16.0 / 3.0 * rock.plane_strain_compliance();
        Self {
            rock,
            radius,
            pressure: volume / (per_pressure * radius.powi(3)),
        }
    }

    /// Opening w at distance r from the centre [m]; zero outside the crack.
    pub fn opening(self, r: f64) -> f64 {
        let factor = 8.0 / std::f64::consts::PI * self.rock.plane_strain_compliance();
        let square = self.radius * self.radius - r * r;
        factor * self.pressure * square.max(0.0).sqrt()
    }

    /// Opening in the centre [m].
    pub fn peak_opening(self) -> f64 {
        self.opening(0.0)
    }

    /// Volume V [m³].
    pub fn volume(self) -> f64 {
        let r = self.radius;
        16.0 / 3.0 * self.rock.plane_strain_compliance() * self.pressure * r.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CRACK: PennyCrack = PennyCrack {
        rock: Rock {
            young: 25e9,
            poisson: 0.25,
        },
        radius: 1.0,
        pressure: 2e6,
    };

    #[test]
    fn two_megapascal_open_a_disc_of_a_metre_by_a_fifth_of_a_millimetre() {
        approx::assert_relative_eq!(CRACK.peak_opening(), 0.190_986e-3, max_relative = 1e-6);
        assert_eq!(CRACK.opening(1.0), 0.0);
        assert_eq!(CRACK.opening(2.0), 0.0);
    }

    #[test]
    fn volume_is_the_integral_of_the_opening_and_gives_the_pressure_back() {
        // midpoints of r² weigh rings of equal area
        let n = 20_000;
        let ring = std::f64::consts::PI / f64::from(n);
        let sum: f64 = (0..n)
            .map(|i| ring * CRACK.opening(((f64::from(i) + 0.5) / f64::from(n)).sqrt()))
            .sum();
        approx::assert_relative_eq!(CRACK.volume(), sum, max_relative = 1e-6);
        let again = PennyCrack::of_volume(CRACK.rock, 1.0, CRACK.volume());
        approx::assert_relative_eq!(again.pressure, 2e6, max_relative = 1e-12);
    }
}
