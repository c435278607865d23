//! Coulomb friction.

/// Coulomb friction of a fracture: `τ_L = c − t_N tan φ`, t_N ≤ 0 in compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Friction angle φ [rad].
    pub angle: f64,
    /// Cohesion c [Pa].
    pub cohesion: f64,
}

impl Friction {
    /// τ_L [Pa]: the largest shear traction that a face carries under the normal traction `t_n` [Pa].
    pub fn limit(self, t_n: f64) -> f64 {
        self.cohesion - t_n * self.slope()
    }

    /// `−∂τ_L/∂t_N = tan φ`.
    pub fn slope(self) -> f64 {
        self.angle.tan()
    }
}
