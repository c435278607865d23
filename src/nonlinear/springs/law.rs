//! A face as springs around multipliers.

use crate::contact::{ContactState, FaceLaw, FacePoint, FaceRows, Friction, SlipSoFar};
use fracas_solvers::saddle::Block;

/// Stiffness that the preconditioner gives a direction in which a face has none or less, times the local stiffness. Unit: 1.
const FLOOR: f64 = 0.1;

/// Springs of stiffness κ per area around multipliers λ, with Coulomb's return:
/// ```text
/// t_N = min(λ_N + κ g_N, 0)
/// w   = λ_T + κ Δg_T        t_T = w min(1, τ_L(t_N, s)/‖w‖)
/// ```
/// The states follow: open where λ_N + κ g_N > 0, slip where ‖w‖ > τ_L, stick elsewhere.
///
/// # Source
/// J. C. Simo, T. A. Laursen, Comput. Struct. 42 (1992) 97–116 (augmented Lagrangian; penalty is λ held at its start).
#[derive(Clone, Copy, Debug)]
pub(in crate::nonlinear) struct SpringLaw {
    /// κ [Pa/m].
    pub(in crate::nonlinear) stiffness: f64,
    /// λ = (λ_N, λ_1, λ_2) [Pa].
    pub(in crate::nonlinear) multiplier: [f64; 3],
    /// Coulomb friction.
    pub(in crate::nonlinear) friction: Friction,
    /// Share of the derivative of weakening that K keeps. Unit: 1.
    pub(in crate::nonlinear) keeps: f64,
}

/// What the springs of a face do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::nonlinear) struct Spring {
    pub(in crate::nonlinear) state: ContactState,
    /// t [Pa].
    pub(in crate::nonlinear) traction: [f64; 3],
    /// K = ∂t/∂g [Pa/m]; unsymmetric in slip: the limit follows the normal traction.
    pub(super) tangent: Block,
    /// m, in slip.
    direction: [f64; 2],
    /// Stiffness across m, κ τ_L/‖w‖, in slip [Pa/m].
    across: f64,
}

impl SpringLaw {
    /// At the jump (g_N, Δg_1, Δg_2) [m], after the slip at the start of the step. A `held` face that sticks
    /// or is open stays so, whatever its springs say.
    pub(in crate::nonlinear) fn at(
        &self,
        jump: [f64; 3],
        start: SlipSoFar,
        held: Option<ContactState>,
    ) -> Spring {
        let kappa = self.stiffness;
        let [normal, w1, w2] = std::array::from_fn(|k| self.multiplier[k] + kappa * jump[k]);
        let mut spring = Spring::held(ContactState::Open);
        let stick = held == Some(ContactState::Stick);
        if held == Some(ContactState::Open) || (normal > 0.0 && !stick) {
            return spring;
        }
        spring.traction[0] = normal;
        spring.tangent[0][0] = kappa;
        let slipped = start.after([jump[1], jump[2]]);
        let limit = self.friction.limit(normal, slipped.slip);
        let size = w1.hypot(w2);
        if stick || size <= limit {
            spring.state = ContactState::Stick;
            spring.traction[1..].copy_from_slice(&[w1, w2]);
            (1..3).for_each(|k| spring.tangent[k][k] = kappa);
            return spring;
        }
        spring.state = ContactState::Slip;
        let law = (self.friction).slip_traction(normal, [w1, w2], &slipped, false);
        spring.direction = law.direction;
        spring.across = kappa * law.turning;
        for i in 0..2 {
            spring.traction[1 + i] = limit * law.direction[i];
            spring.tangent[1 + i][0] = kappa * law.by_normal[i];
            for j in 0..2 {
                spring.tangent[1 + i][1 + j] =
                    kappa * law.by_trial[i][j] + self.keeps * law.by_slip[i][j];
            }
        }
        spring
    }
}

impl Spring {
    /// The rows `(P(t + κ g) − t)/κ` of a face around its own tractions t, and their derivatives: Newton on the natural map, per unit of
    /// area [m]. An open face has those of the [`FaceLaw`].
    pub(in crate::nonlinear) fn rows(
        &self,
        law: &FaceLaw,
        point: &FacePoint,
        kappa: f64,
    ) -> FaceRows {
        if self.state == ContactState::Open {
            return law.rows(ContactState::Open, point);
        }
        let each = |i: usize, j: usize| {
            let one = f64::from(u8::from(i == j));
            (self.tangent[i][j] / kappa - one) / kappa
        };
        FaceRows {
            residual: std::array::from_fn(|k| (self.traction[k] - point.traction[k]) / kappa),
            by_jump: self.tangent.map(|row| row.map(|v| v / kappa)),
            by_traction: std::array::from_fn(|i| std::array::from_fn(|j| each(i, j))),
        }
    }

    /// A face in stick without a traction.
    pub(super) fn stuck(kappa: f64) -> Self {
        Self::at_limit(ContactState::Stick, kappa, [0.0; 3], 0.0)
    }

    /// A face that bears t [Pa]; in slip it does so in the direction of its shear, at a limit that only its normal traction
    /// moves, by `by_normal`.
    pub(super) fn at_limit(state: ContactState, kappa: f64, t: [f64; 3], by_normal: f64) -> Self {
        let mut spring = Self::held(state);
        if state == ContactState::Open {
            return spring;
        }
        spring.traction = t;
        (0..3).for_each(|k| spring.tangent[k][k] = kappa);
        if state == ContactState::Stick {
            return spring;
        }
        let shear = t[1].hypot(t[2]);
        let m = [t[1], t[2]].map(|t| if shear > 0.0 { t / shear } else { 0.0 });
        (spring.direction, spring.across) = (m, kappa);
        for i in 0..2 {
            spring.tangent[1 + i][0] = kappa * by_normal * m[i];
            (0..2).for_each(|j| spring.tangent[1 + i][1 + j] -= kappa * m[i] * m[j]);
        }
        spring
    }

    /// True where K is symmetric.
    pub(super) fn is_symmetric(&self) -> bool {
        let k = &self.tangent;
        k[1][0] == k[0][1] && k[2][0] == k[0][2] && k[1][2] == k[2][1]
    }

    /// A face in this state, without a traction.
    fn held(state: ContactState) -> Self {
        Self {
            state,
            traction: [0.0; 3],
            tangent: [[0.0; 3]; 3],
            direction: [0.0; 2],
            across: 0.0,
        }
    }

    /// True for a slip against the slip of `other`.
    pub(super) fn reverses(&self, other: &Self) -> bool {
        let [a, b] = [self.direction, other.direction];
        a[0] * b[0] + a[1] * b[1] < 0.0
    }

    /// Inverse of the symmetric part of K without weakening, no direction softer than a tenth of the local stiffness 1/ω
    /// [m/Pa]: what S_u is built of.
    pub(super) fn compliance(&self, stiffness: f64, omega: f64) -> Block {
        let floor = FLOOR / omega;
        let soft = |k: f64| 1.0 / k.max(floor);
        let mut c = [[0.0; 3]; 3];
        match self.state {
            ContactState::Open => (0..3).for_each(|k| c[k][k] = 1.0 / floor),
            ContactState::Slip | ContactState::NewSlip => {
                let m = self.direction;
                c[0][0] = soft(stiffness);
                for i in 0..2 {
                    for j in 0..2 {
                        let one = f64::from(u8::from(i == j));
                        let (along, rest) = (m[i] * m[j], one - m[i] * m[j]);
                        c[1 + i][1 + j] = along / floor + rest * soft(self.across);
                    }
                }
            }
            ContactState::Stick => (0..3).for_each(|k| c[k][k] = soft(stiffness)),
        }
        c
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Weakening, WeakeningBy};

    const LAW: SpringLaw = SpringLaw {
        stiffness: 4e10,
        multiplier: [-2e6, 3e5, -1e5],
        friction: Friction {
            angle: 0.5,
            cohesion: 2e5,
            weakening: Some(Weakening {
                angle: 0.3,
                distance: 4e-3,
                by: WeakeningBy::Slip,
            }),
        },
        keeps: 1.0,
    };
    const START: SlipSoFar = SlipSoFar::Vector([3e-4, 2e-4]);

    #[test]
    fn tangents_are_derivatives_in_every_state() {
        for (jump, state) in [
            ([-1e-5, 1e-6, 2e-6], ContactState::Stick),
            ([-1e-5, 3e-4, -1e-4], ContactState::Slip),
            ([1e-4, 3e-4, -1e-4], ContactState::Open),
        ] {
            for start in [START, SlipSoFar::Path(1e-3)] {
                let spring = LAW.at(jump, start, None);
                assert_eq!(spring.state, state);
                for j in 0..3 {
                    let h = 1e-10;
                    let moved = |s: f64| {
                        let mut g = jump;
                        g[j] += s;
                        LAW.at(g, start, None).traction
                    };
                    let (plus, minus) = (moved(h), moved(-h));
                    for i in 0..3 {
                        let difference = (plus[i] - minus[i]) / (2.0 * h);
                        let error = (difference - spring.tangent[i][j]).abs() / LAW.stiffness;
                        assert!(error < 1e-6, "{state:?} {i} {j}: {error:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn at_limits_that_nothing_moves_only_slip_along_the_shear_is_free() {
        let friction = Friction {
            weakening: None,
            ..LAW.friction
        };
        let law = SpringLaw { friction, ..LAW };
        for (jump, state) in [
            ([-1e-5, 1e-6, 2e-6], ContactState::Stick),
            ([-1e-5, 3e-4, -1e-4], ContactState::Slip),
            ([1e-4, 3e-4, -1e-4], ContactState::Open),
        ] {
            let spring = law.at(jump, START, None);
            let t = spring.traction;
            let by_normal = friction.by_normal(t[0], 0.0);
            let frozen = Spring::at_limit(state, law.stiffness, t, by_normal);
            assert_eq!(frozen.state, spring.state);
            let m = [0.0, spring.direction[0], spring.direction[1]];
            // slip turns the more freely the further it has gone: across m the law is softer
            let turned = (law.stiffness - spring.across) * f64::from(u8::from(m != [0.0; 3]));
            for i in 0..3 {
                for j in 0..3 {
                    let across = if i == j { 1.0 } else { 0.0 } - m[i] * m[j];
                    let across = if i * j == 0 { 0.0 } else { turned * across };
                    let error = frozen.tangent[i][j] - across - spring.tangent[i][j];
                    assert!(error.abs() < 1e-9 * law.stiffness, "{state:?} {i} {j}");
                }
            }
        }
    }

    #[test]
    fn tractions_obey_coulomb_and_signorini() {
        for k in 0..200 {
            let x = f64::from(k);
            let jump = [x.sin(), (1.7 * x).cos(), (2.3 * x).sin()].map(|v| 1e-4 * v);
            let spring = LAW.at(jump, START, None);
            let [n, t1, t2] = spring.traction;
            let slip = START.after([jump[1], jump[2]]).slip;
            assert!(n <= 0.0);
            assert!(t1.hypot(t2) <= LAW.friction.limit(n, slip) * (1.0 + 1e-14));
            if spring.state == ContactState::Open {
                assert_eq!(spring.traction, [0.0; 3]);
            }
        }
    }

    #[test]
    fn the_compliance_is_the_inverse_of_a_symmetric_tangent() {
        // without friction by pressure and weakening, and above the floor, K is symmetric but for the rank along m
        let law = SpringLaw {
            friction: Friction {
                angle: 0.0,
                cohesion: 2e5,
                weakening: None,
            },
            ..LAW
        };
        let omega = 1e-10;
        let spring = law.at([-1e-5, 4e-6, -1e-6], START, None);
        assert_eq!(spring.state, ContactState::Slip);
        let c = spring.compliance(law.stiffness, omega);
        let m = [0.0, spring.direction[0], spring.direction[1]];
        for i in 0..3 {
            for j in 0..3 {
                // C (K + floor m mᵀ) = I
                let product: f64 = (0..3)
                    .map(|k| c[i][k] * (spring.tangent[k][j] + FLOOR / omega * m[k] * m[j]))
                    .sum();
                let one = f64::from(u8::from(i == j));
                assert!((product - one).abs() < 1e-10, "{i} {j}: {product}");
            }
        }
    }
}
