//! Residual and tangent of one face in a given state.

use super::{ContactState, Friction, SlipSoFar};
use fracas_operators::small::{Matrix3, diagonal};

/// Where a face stands: traction and jump in its frame (n, t1, t2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FacePoint {
    /// (t_N, t_1, t_2) [Pa].
    pub traction: [f64; 3],
    /// (g_N, Δg_1, Δg_2): the normal jump in all, the tangential one over the step [m].
    pub jump: [f64; 3],
    /// The slip at the start of the step; only weakening friction asks for it.
    pub start: SlipSoFar,
}

/// The rows of a face per unit of area: r [m] and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceRows {
    /// r.
    pub residual: [f64; 3],
    /// ∂r/∂(jump), dimensionless.
    pub by_jump: Matrix3<f64>,
    /// ∂r/∂(traction) [m/Pa].
    pub by_traction: Matrix3<f64>,
}

/// The contact rows of a face:
/// ```text
/// stick     r_N = g_N     r_T = Δg_T
/// slip      r_N = g_N     r_T = ω (τ_L m − t_T)       τ_L = max(c − t_N tan φ(s), 0),  s = ‖γ at the start + Δg_T‖ or that of [`SlipSoFar`]
/// open      r   = −ω t
/// m = Δg_T/‖Δg_T‖ in slip; t_T/‖t_T‖, frozen, in new-slip and where ‖Δg_T‖ ≤ tiny; r_T = −ω t_T where t_T = 0 as well
/// ```
/// Traction rows are negated, so that in `B2 u − H t = g` the block `H = −A_f ∂r/∂t` has `+ω A_f` on their diagonal and B2
/// a positive semi-definite multiple `ω τ_L (I − m mᵀ)/‖Δg_T‖` of the tangential rows of B1ᵀ; weakening adds
/// `ω ∂τ_L/∂s m (∂s/∂Δg_T)ᵀ`, which is negative along the slip. The compliance ω gives them the unit of the jumps.
///
/// # Source
/// M. Ferronato, SNA'25 lecture (Karush–Kuhn–Tucker conditions, maximum plastic dissipation); derivatives as in the authors' open codes. Signs
/// and ω are choices of this project.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceLaw {
    /// Coulomb friction.
    pub friction: Friction,
    /// ω [m/Pa].
    pub compliance: f64,
    /// ‖Δg_T‖ up to which the direction of slip is that of the shear traction [m].
    pub tiny: f64,
}

/// Length of (v_1, v_2).
fn tangential_norm(v: [f64; 3]) -> f64 {
    v[1].hypot(v[2])
}

impl FaceLaw {
    /// Residual and tangent in `state`.
    pub fn rows(&self, state: ContactState, point: &FacePoint) -> FaceRows {
        let FacePoint {
            traction: t,
            jump,
            start,
        } = *point;
        let omega = self.compliance;
        match state {
            ContactState::Stick => FaceRows {
                residual: jump,
                by_jump: diagonal([1.0; 3]),
                by_traction: diagonal([0.0; 3]),
            },
            ContactState::Open => FaceRows {
                residual: t.map(|t| -omega * t),
                by_jump: diagonal([0.0; 3]),
                by_traction: diagonal([-omega; 3]),
            },
            ContactState::NewSlip | ContactState::Slip => {
                let (m, turning) = self.direction(state, point);
                let slipped = start.after([jump[1], jump[2]]);
                let limit = self.friction.limit(t[0], slipped.slip);
                // ∂τ_L/∂Δg_T = ∂τ_L/∂s ∂s/∂Δg_T
                let rate = self.friction.by_slip(t[0], slipped.slip);
                let by_normal = self.friction.by_normal(t[0], slipped.slip);
                let along = slipped.along(rate);
                let mut rows = FaceRows {
                    residual: jump,
                    by_jump: diagonal([1.0, 0.0, 0.0]),
                    by_traction: diagonal([0.0, -omega, -omega]),
                };
                for i in 1..3 {
                    rows.residual[i] = omega * (limit * m[i] - t[i]);
                    rows.by_traction[i][0] = omega * by_normal * m[i];
                    for j in 1..3 {
                        let projector = f64::from(u8::from(i == j)) - m[i] * m[j];
                        rows.by_jump[i][j] =
                            omega * (limit * turning * projector + m[i] * along[j - 1]);
                    }
                }
                rows
            }
        }
    }

    /// m, and `1/‖Δg_T‖` where m turns with the slip (else 0).
    fn direction(&self, state: ContactState, point: &FacePoint) -> ([f64; 3], f64) {
        let slip = tangential_norm(point.jump);
        let unit = |v: [f64; 3], norm: f64| [0.0, v[1] / norm, v[2] / norm];
        if state == ContactState::Slip && slip > self.tiny {
            return (unit(point.jump, slip), 1.0 / slip);
        }
        let shear = tangential_norm(point.traction);
        let m = if shear > 0.0 {
            unit(point.traction, shear)
        } else {
            [0.0; 3]
        };
        (m, 0.0)
    }
}

#[cfg(test)]
mod tests;
