//! The shear traction of slip in the direction of a trial traction, and its derivatives.

use super::{Friction, Slipped};

/// `t_T = τ_L(t_N, s) m`, `m = w/‖w‖`: a shear traction at its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SlipTraction {
    /// τ_L [Pa].
    pub(crate) limit: f64,
    /// m; 0 where w = 0.
    pub(crate) direction: [f64; 2],
    /// `τ_L/‖w‖`: 1 where slip begins, 0 where w = 0.
    pub(crate) turning: f64,
    /// `∂t_T/∂w = τ_L/‖w‖ (I − m mᵀ)`.
    pub(crate) by_trial: [[f64; 2]; 2],
    /// `∂t_T/∂t_N = m ∂τ_L/∂t_N`.
    pub(crate) by_normal: [f64; 2],
    /// `∂t_T/∂Δg_T = m ∂τ_L/∂s (∂s/∂Δg_T)ᵀ` at a given w [Pa/m].
    pub(crate) by_slip: [[f64; 2]; 2],
}

impl Friction {
    /// The shear traction of slip for a trial traction w [Pa] after the slip in all; with `lagged` its derivatives
    /// leave out weakening.
    pub(crate) fn slip_traction(
        self,
        t_n: f64,
        w: [f64; 2],
        slipped: &Slipped,
        lagged: bool,
    ) -> SlipTraction {
        let (size, slip) = (w[0].hypot(w[1]), slipped.slip);
        let limit = self.limit(t_n, slip);
        let m = w.map(|w| if size > 0.0 { w / size } else { 0.0 });
        let turning = if size > 0.0 { limit / size } else { 0.0 };
        let rate = match lagged {
            true => 0.0,
            false => self.by_slip(t_n, slip),
        };
        let along = slipped.along(rate);
        let by_normal = self.by_normal(t_n, slip);
        let one = |i: usize, j: usize| f64::from(u8::from(i == j));
        SlipTraction {
            limit,
            direction: m,
            turning,
            by_trial: [0, 1]
                .map(|i: usize| [0, 1].map(|j: usize| turning * (one(i, j) - m[i] * m[j]))),
            by_normal: m.map(|m| by_normal * m),
            by_slip: m.map(|m| along.map(|a| m * a)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{SlipSoFar, Weakening, WeakeningBy};

    const WEAK: Friction = Friction {
        angle: 0.5,
        cohesion: 2e5,
        weakening: Some(Weakening {
            angle: 0.3,
            distance: 4e-3,
            by: WeakeningBy::Slip,
        }),
    };

    /// From rest.
    fn slipped(g: [f64; 2]) -> Slipped {
        SlipSoFar::default().after(g)
    }

    #[test]
    fn derivatives_are_those_of_the_traction() {
        for start in [SlipSoFar::default(), SlipSoFar::Path(1e-3)] {
            derivatives_are_those(start);
        }
    }

    fn derivatives_are_those(start: SlipSoFar) {
        let law = |x: [f64; 5]| {
            let slipped = start.after([x[3], x[4]]);
            WEAK.slip_traction(x[0], [x[1], x[2]], &slipped, false)
        };
        let traction = |x: [f64; 5]| {
            let slip = law(x);
            slip.direction.map(|m| slip.limit * m)
        };
        let x = [-4e6, 1.5e6, -0.8e6, 3e-4, 2e-4];
        let at = law(x);
        for k in 0..5 {
            let h = if k < 3 { 10.0 } else { 1e-8 };
            let moved = |s: f64| {
                let mut y = x;
                y[k] += s;
                traction(y)
            };
            let (plus, minus) = (moved(h), moved(-h));
            for i in 0..2 {
                let exact = match k {
                    0 => at.by_normal[i],
                    1 | 2 => at.by_trial[i][k - 1],
                    _ => at.by_slip[i][k - 3],
                };
                let difference = (plus[i] - minus[i]) / (2.0 * h);
                let scale = if k < 3 { 1.0 } else { 1e9 };
                assert!(
                    (difference - exact).abs() < 1e-6 * scale,
                    "{i} {k}: {difference} {exact}"
                );
            }
        }
    }

    #[test]
    fn no_trial_has_no_direction_and_lag_leaves_out_weakening_alone() {
        let none = WEAK.slip_traction(-1e6, [0.0; 2], &slipped([1e-3, 0.0]), false);
        assert_eq!((none.direction, none.turning), ([0.0; 2], 0.0));
        let at = |lagged| WEAK.slip_traction(-1e6, [3e5, 4e5], &slipped([1e-3, 0.0]), lagged);
        assert_eq!(at(true).by_slip, [[0.0; 2]; 2]);
        assert!(at(false).by_slip[0][0] < 0.0);
        assert_eq!(
            SlipTraction {
                by_slip: [[0.0; 2]; 2],
                ..at(false)
            },
            at(true)
        );
    }
}
