//! A crack in plane strain, opened by pressure or by volume.

use super::Rock;

/// A straight crack of length 2a in unbounded rock in plane strain, opened from inside:
/// ```text
/// w(s) = (4(1−ν²) p/E) √(a² − s²)      |s| ≤ a        V = 2π(1−ν²) p a²/E per unit of thickness
/// ```
///
/// # Source
/// I. N. Sneddon, *The distribution of stress in the neighbourhood of a crack in an elastic solid*, Proc. R. Soc. A 187
/// (1946) 229–260.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineCrack {
    /// The rock.
    pub rock: Rock,
    /// Half-length a [m].
    pub half_length: f64,
    /// Pressure p above the stress that closes the crack [Pa].
    pub pressure: f64,
}

impl LineCrack {
    /// The crack that holds a volume per thickness V [m²] at uniform pressure: `p = VE/(2π(1−ν²)a²)`.
    pub fn of_volume(rock: Rock, half_length: f64, volume: f64) -> Self {
        let per_pressure = std::f64::consts::TAU * rock.plane_strain_compliance();
        Self {
            rock,
            half_length,
            pressure: volume / (per_pressure * half_length * half_length),
        }
    }

    /// Opening w at distance s from the middle [m]; zero outside the crack.
    pub fn opening(self, s: f64) -> f64 {
        let square = self.half_length * self.half_length - s * s;
        4.0 * self.rock.plane_strain_compliance() * self.pressure * square.max(0.0).sqrt()
    }

    /// Mean opening between s = `from` and s = `to` [m].
    pub fn mean_opening(self, from: f64, to: f64) -> f64 {
        let factor = 4.0 * self.rock.plane_strain_compliance() * self.pressure;
        factor * ellipse_area(self.half_length, from, to) / (to - from)
    }

    /// Opening in the middle [m].
    pub fn peak_opening(self) -> f64 {
        self.opening(0.0)
    }

    /// Volume per thickness V [m²].
    pub fn volume(self) -> f64 {
        let a = self.half_length;
        std::f64::consts::TAU * self.rock.plane_strain_compliance() * self.pressure * a * a
    }
}

/// `∫ √(a² − s²) ds` from `from` to `to`, the integrand zero outside [−a, a].
pub(super) fn ellipse_area(a: f64, from: f64, to: f64) -> f64 {
    let primitive = |s: f64| {
        let s = s.clamp(-a, a);
        0.5 * (s * (a * a - s * s).sqrt() + a * a * (s / a).asin())
    };
    primitive(to) - primitive(from)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CRACK: LineCrack = LineCrack {
        rock: Rock {
            young: 25e9,
            poisson: 0.25,
        },
        half_length: 1.0,
        pressure: 2e6,
    };

    #[test]
    fn two_megapascal_open_a_metre_by_three_tenths_of_a_millimetre() {
        approx::assert_relative_eq!(CRACK.peak_opening(), 0.3e-3, max_relative = 1e-12);
        assert_eq!(CRACK.opening(1.0), 0.0);
        assert_eq!(CRACK.opening(-1.5), 0.0);
    }

    #[test]
    fn volume_is_the_integral_of_the_opening_and_gives_the_pressure_back() {
        let integral = CRACK.mean_opening(-1.0, 1.0) * 2.0;
        approx::assert_relative_eq!(CRACK.volume(), integral, max_relative = 1e-12);
        let again = LineCrack::of_volume(CRACK.rock, 1.0, CRACK.volume());
        approx::assert_relative_eq!(again.pressure, 2e6, max_relative = 1e-12);
    }

    #[test]
    fn mean_opening_agrees_with_a_sum() {
        let (from, to, n) = (-0.35, 0.9, 20_000);
        let h = (to - from) / f64::from(n);
        let sum: f64 = (0..n)
            .map(|i| CRACK.opening(from + (f64::from(i) + 0.5) * h))
            .sum();
        let mean = CRACK.mean_opening(from, to);
        approx::assert_relative_eq!(mean, sum / f64::from(n), max_relative = 1e-8);
    }
}
