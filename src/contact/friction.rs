//! Coulomb friction, constant or weakening with slip.

use super::WeakeningBy;

/// Linear weakening of the friction angle with slip: `φ(s) = φ_s − s (φ_s − φ_d)/d_c` up to `s = d_c`, then φ_d.
///
/// # Source
/// M. Ferronato, SNA'25 lecture (slip weakening).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weakening {
    /// Dynamic friction angle φ_d [rad].
    pub angle: f64,
    /// Slip d_c over which the angle falls [m].
    pub distance: f64,
    /// What of the slip it follows.
    pub by: WeakeningBy,
}

/// Coulomb friction of a fracture: `τ_L = max(c − t_N tan φ(s), 0)`, t_N ≤ 0 in compression, s the slip so far: ‖γ‖, or its
/// path ([`WeakeningBy`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Friction angle φ, with weakening the static one φ_s [rad].
    pub angle: f64,
    /// Cohesion c [Pa].
    pub cohesion: f64,
    /// How the angle falls with slip, if it does.
    pub weakening: Option<Weakening>,
}

impl Friction {
    /// No resistance to slip.
    pub const NONE: Self = Self {
        angle: 0.0,
        cohesion: 0.0,
        weakening: None,
    };

    /// φ(s) [rad] and `dφ/ds` [rad/m].
    fn angle_at(self, slip: f64) -> (f64, f64) {
        match self.weakening {
            Some(w) if slip < w.distance => {
                let fall = (self.angle - w.angle) / w.distance;
                (self.angle - slip * fall, -fall)
            }
            Some(w) => (w.angle, 0.0),
            None => (self.angle, 0.0),
        }
    }

    /// The same without cohesion.
    pub(crate) fn torn(self) -> Self {
        Self {
            cohesion: 0.0,
            ..self
        }
    }

    /// The same, as it is after `slip` [m], without weakening.
    pub(crate) fn at_slip(self, slip: f64) -> Self {
        Self {
            angle: self.angle_at(slip).0,
            weakening: None,
            ..self
        }
    }

    /// A share of it: the cohesion and the tangents of both angles are so much smaller.
    pub(crate) fn share(self, share: f64) -> Self {
        let angle = |angle: f64| (share * angle.tan()).atan();
        let weakening = |w: Weakening| Weakening {
            angle: angle(w.angle),
            ..w
        };
        Self {
            angle: angle(self.angle),
            cohesion: share * self.cohesion,
            weakening: self.weakening.map(weakening),
        }
    }

    /// τ_L [Pa]: the largest shear traction that a face carries under the normal traction `t_n` [Pa] after `slip` [m];
    /// never negative, whatever tension an iterate has.
    pub fn limit(self, t_n: f64, slip: f64) -> f64 {
        (self.cohesion - t_n * self.angle_at(slip).0.tan()).max(0.0)
    }

    /// `∂τ_L/∂t_N = −tan φ(s)`, 0 where tension leaves no limit.
    pub fn by_normal(self, t_n: f64, slip: f64) -> f64 {
        match self.limit(t_n, slip) > 0.0 {
            true => -self.angle_at(slip).0.tan(),
            false => 0.0,
        }
    }

    /// `∂τ_L/∂s = −t_N φ'(s)/cos² φ(s)` [Pa/m]: negative where slip weakens a compressed face.
    pub fn by_slip(self, t_n: f64, slip: f64) -> f64 {
        let (angle, rate) = self.angle_at(slip);
        match self.limit(t_n, slip) > 0.0 {
            true => -t_n * rate / angle.cos().powi(2),
            false => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEAK: Friction = Friction {
        angle: 0.6,
        cohesion: 1e5,
        weakening: Some(Weakening {
            angle: 0.4,
            distance: 5e-3,
            by: WeakeningBy::Slip,
        }),
    };

    #[test]
    fn the_angle_falls_linearly_and_then_stays() {
        let slope = |slip| -WEAK.by_normal(-1e6, slip);
        assert_eq!(slope(0.0), 0.6f64.tan());
        assert!((slope(2.5e-3) - 0.5f64.tan()).abs() < 1e-15);
        assert_eq!(slope(5e-3), 0.4f64.tan());
        assert_eq!(slope(1.0), 0.4f64.tan());
        assert_eq!(WEAK.limit(-1e6, 1.0), 1e5 + 1e6 * 0.4f64.tan());
    }

    #[test]
    fn the_rate_is_the_derivative_of_the_limit() {
        for slip in [1e-4, 2e-3, 4.9e-3, 6e-3] {
            let h = 1e-7;
            let difference = (WEAK.limit(-3e6, slip + h) - WEAK.limit(-3e6, slip - h)) / (2.0 * h);
            let exact = WEAK.by_slip(-3e6, slip);
            assert!((difference - exact).abs() < 1e-2, "{difference} {exact}");
        }
    }

    #[test]
    fn tension_leaves_no_limit() {
        assert_eq!(WEAK.limit(1e6, 0.0), 0.0);
        assert_eq!(WEAK.by_normal(1e6, 0.0), 0.0);
        assert_eq!(WEAK.by_slip(1e6, 1e-3), 0.0);
        assert!(
            WEAK.limit(1e5, 0.0) > 0.0,
            "cohesion holds a little tension"
        );
    }
}
