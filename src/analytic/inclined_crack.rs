//! A closed crack that slides under compression.

use super::Rock;
use super::line_crack::ellipse_area;

/// A straight crack of length 2b in unbounded rock in plane strain, at the angle ψ to a uniaxial compression σ:
/// ```text
/// t_N = −σ sin²ψ        τ_L = c + σ sin²ψ tan θ        Δτ = σ sinψ cosψ − τ_L
/// g_T(s) = (4(1−ν²)/E) Δτ √(b² − s²)      |s| ≤ b, zero where Δτ ≤ 0
/// ```
/// With s = b − ξ and c = 0 this is `(4(1−ν²)/E) σ sinψ (cosψ − sinψ tanθ) √(b² − (b−ξ)²)`.
///
/// # Source
/// A.-V. Phan, J. A. L. Napier, L. J. Gray, T. Kaplan, *Symmetric-Galerkin BEM simulation of fracture with frictional
/// contact*, Int. J. Numer. Meth. Engng 57 (2003) 835–851.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InclinedCrack {
    /// The rock.
    pub rock: Rock,
    /// Compression σ, positive [Pa].
    pub compression: f64,
    /// Angle ψ between the crack and the direction of compression [rad].
    pub inclination: f64,
    /// Friction angle θ [rad].
    pub friction_angle: f64,
    /// Cohesion c [Pa].
    pub cohesion: f64,
    /// Half-length b [m].
    pub half_length: f64,
}

impl InclinedCrack {
    /// Normal traction t_N on the crack, the same everywhere [Pa].
    pub fn normal_traction(self) -> f64 {
        -self.compression * self.inclination.sin().powi(2)
    }

    /// Shear traction that the crack can carry: τ_L [Pa].
    pub fn shear_limit(self) -> f64 {
        self.cohesion - self.normal_traction() * self.friction_angle.tan()
    }

    /// Shear traction that the uncracked rock would carry there: σ sinψ cosψ [Pa].
    pub fn far_shear(self) -> f64 {
        self.compression * self.inclination.sin() * self.inclination.cos()
    }

    /// Drop of the shear traction, Δτ; zero where the crack sticks [Pa].
    pub fn stress_drop(self) -> f64 {
        (self.far_shear() - self.shear_limit()).max(0.0)
    }

    fn slip_factor(self) -> f64 {
        4.0 * self.rock.plane_strain_compliance() * self.stress_drop()
    }

    /// Slip at distance s from the middle [m]; zero outside the crack.
    pub fn slip(self, s: f64) -> f64 {
        let square = self.half_length * self.half_length - s * s;
        self.slip_factor() * square.max(0.0).sqrt()
    }

    /// Mean slip between s = `from` and s = `to` [m].
    pub fn mean_slip(self, from: f64, to: f64) -> f64 {
        self.slip_factor() * ellipse_area(self.half_length, from, to) / (to - from)
    }

    /// Slip in the middle [m].
    pub fn peak_slip(self) -> f64 {
        self.slip(0.0)
    }

    /// ∫ g_T ds over the crack [m²].
    pub fn slip_area(self) -> f64 {
        let b = self.half_length;
        2.0 * b * self.mean_slip(-b, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crack() -> InclinedCrack {
        InclinedCrack {
            rock: Rock {
                young: 25e9,
                poisson: 0.25,
            },
            compression: 100e6,
            inclination: 20f64.to_radians(),
            friction_angle: 30f64.to_radians(),
            cohesion: 0.0,
            half_length: 1.0,
        }
    }

    #[test]
    fn the_case_of_the_literature() {
        let c = crack();
        approx::assert_relative_eq!(c.normal_traction(), -11.69778e6, max_relative = 1e-6);
        approx::assert_relative_eq!(c.peak_slip(), 3.80785e-3, max_relative = 2e-6);
        approx::assert_relative_eq!(c.slip_area(), 5.98136e-3, max_relative = 2e-6);
    }

    #[test]
    fn the_printed_form_is_the_same() {
        let c = crack();
        let (psi, theta) = (c.inclination, c.friction_angle);
        for xi in [0.0, 0.1, 0.7, 1.0, 1.6, 2.0] {
            let printed = 4.0 * (1.0 - 0.25 * 0.25) / 25e9
                * 100e6
                * psi.sin()
                * (psi.cos() - psi.sin() * theta.tan())
                * f64::sqrt(1.0 - (1.0 - xi) * (1.0 - xi));
            approx::assert_relative_eq!(c.slip(1.0 - xi), printed, max_relative = 1e-12);
        }
    }

    #[test]
    fn a_strong_crack_sticks() {
        let strong = InclinedCrack {
            cohesion: 30e6,
            ..crack()
        };
        assert!(strong.far_shear() < strong.shear_limit());
        assert_eq!(strong.peak_slip(), 0.0);
        assert_eq!(strong.slip_area(), 0.0);
    }
}
