//! The slip law with a direction that stays defined where slip begins.

use super::law::{FaceLaw, FacePoint, FaceRows};
use super::{ContactState, FaceMeasure};

impl FaceLaw {
    /// Rows as [`rows`](FaceLaw::rows), with the direction of slip and of new-slip taken from the trial traction:
    /// ```text
    /// r_T = ω (τ_L m − t_T)        m = w/‖w‖        w = t_T + Δg_T/ω
    /// ∂m/∂t_T = (I − m mᵀ)/‖w‖     ∂m/∂Δg_T = (I − m mᵀ)/(ω ‖w‖)
    /// ```
    /// With `lagged` the derivatives leave out `∂τ_L/∂s`: weakening faster than the rock around is stiff makes the tangent
    /// indefinite, and Newton goes astray where the limit of the iterate before leads on.
    ///
    /// The solutions are those with `m = Δg_T/‖Δg_T‖`. As slip goes to nothing the rows across m become those of stick, where
    /// the direction of Δg_T alone is noise and its derivative without bound.
    ///
    /// # Source
    /// P. Alart, A. Curnier, CMAME 92 (1991) 353–375, with the augmentation parameter 1/ω.
    pub fn projected_rows(&self, state: ContactState, point: &FacePoint, lagged: bool) -> FaceRows {
        self.turned_rows(state, point, lagged, f64::INFINITY)
    }

    /// The same with `∂m/∂w` taken at the circle where w lies within it: slip against its traction, as a face that has just closed shows
    /// it.
    ///
    /// The derivative `τ_L/‖w‖ (I − m mᵀ)` there exceeds that of stick, so that the tangent holds a spring of negative stiffness: the
    /// system is indefinite, RACP takes two to four times as many iterations and the line search steps of a sixteenth. At a solution w lies
    /// outside, where both tangents are one.
    ///
    /// # Source
    /// The remedy is that of S. Hüeber, G. Stadler, B. Wohlmuth, SIAM J. Sci. Comput. 30 (2008) 572–596, §4.
    pub fn damped_rows(&self, state: ContactState, point: &FacePoint, lagged: bool) -> FaceRows {
        self.turned_rows(state, point, lagged, 1.0)
    }

    fn turned_rows(
        &self,
        state: ContactState,
        point: &FacePoint,
        lagged: bool,
        most: f64,
    ) -> FaceRows {
        let mut rows = self.rows(state, point);
        if !matches!(state, ContactState::NewSlip | ContactState::Slip) {
            return rows;
        }
        let FacePoint {
            traction: t,
            jump,
            start,
        } = *point;
        let omega = self.compliance;
        let w = [1, 2].map(|k: usize| t[k] + jump[k] / omega);
        let slipped = start.after([jump[1], jump[2]]);
        let slip = self.friction.slip_traction(t[0], w, &slipped, lagged);
        let share = match slip.turning > most {
            true => most / slip.turning,
            false => 1.0,
        };
        for i in 0..2 {
            rows.residual[1 + i] = omega * (slip.limit * slip.direction[i] - t[1 + i]);
            rows.by_traction[1 + i][0] = omega * slip.by_normal[i];
            for j in 0..2 {
                let one = f64::from(u8::from(i == j));
                let by_trial = share * slip.by_trial[i][j];
                rows.by_traction[1 + i][1 + j] = omega * (by_trial - one);
                rows.by_jump[1 + i][1 + j] = by_trial + omega * slip.by_slip[i][j];
            }
        }
        rows
    }

    /// What a face shows: its gap, its normal traction, and the trial traction `‖t_T + Δg_T/ω‖` against the limit.
    pub fn measure(&self, point: &FacePoint) -> FaceMeasure {
        let FacePoint {
            traction: t,
            jump,
            start,
        } = *point;
        let trial = |k: usize| t[k] + jump[k] / self.compliance;
        FaceMeasure {
            gap: jump[0],
            t_n: t[0],
            trial: trial(1).hypot(trial(2)),
            limit: self
                .friction
                .limit(t[0], start.after([jump[1], jump[2]]).slip),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Friction, SlipSoFar, Weakening, WeakeningBy};

    const LAW: FaceLaw = FaceLaw {
        friction: Friction {
            angle: 0.5,
            cohesion: 2e5,
            weakening: Some(Weakening {
                angle: 0.3,
                distance: 4e-3,
                by: WeakeningBy::Slip,
            }),
        },
        compliance: 3e-10,
        tiny: 1e-9,
    };

    #[test]
    fn tangents_are_derivatives() {
        for (traction, jump) in [
            ([-4e6, 1.5e6, -0.8e6], [1e-5, 2e-3, -1e-3]),
            ([-4e6, 1.5e6, -0.8e6], [0.0, 1e-9, 2e-9]),
            ([-1e6, 0.0, 5e5], [0.0, 1e-4, 0.0]),
            ([3e6, 1e5, 2e5], [0.0, 1e-4, 3e-4]),
        ] {
            let starts = [SlipSoFar::Vector([3e-4, 2e-4]), SlipSoFar::Path(1e-3)];
            for start in starts {
                let point = FacePoint {
                    traction,
                    jump,
                    start,
                };
                let rows = LAW.projected_rows(ContactState::Slip, &point, false);
                // a path has a corner where nothing moves in the step
                let short = (1e-3 * jump[1].hypot(jump[2])).min(1e-8);
                for k in 0..3 {
                    for (which, h) in [(0, short), (1, 10.0)] {
                        let moved = |s: f64| {
                            let mut p = point;
                            match which {
                                0 => p.jump[k] += s,
                                _ => p.traction[k] += s,
                            }
                            LAW.projected_rows(ContactState::Slip, &p, false).residual
                        };
                        let (plus, minus) = (moved(h), moved(-h));
                        let (exact, scale) = match which {
                            0 => (rows.by_jump, 1.0),
                            _ => (rows.by_traction, LAW.compliance),
                        };
                        for i in 0..3 {
                            let difference = (plus[i] - minus[i]) / (2.0 * h);
                            let error = (difference - exact[i][k]).abs() / scale;
                            assert!(error < 1e-4, "{point:?} {which} {i} {k}: {error:e}");
                        }
                    }
                }
            }
        }
    }

    /// Where w lies outside the circle both tangents are one to the last bit; inside, the damped one holds no negative spring.
    #[test]
    fn the_damped_tangent_is_the_exact_one_outside_the_circle_and_no_more_than_that_of_stick_inside()
     {
        let friction = Friction {
            weakening: None,
            ..LAW.friction
        };
        let law = FaceLaw { friction, ..LAW };
        let (mut inside, mut outside) = (0, 0);
        for k in 0..400 {
            let number = |i: usize| fracas_operators::random::signed((7 * k + i) as u64);
            let point = FacePoint {
                traction: [-2e6 + 2e6 * number(0), 1e6 * number(1), 1e6 * number(2)],
                jump: [0.0, 1e-4 * number(3), 1e-4 * number(4)],
                start: SlipSoFar::Vector([0.0; 2]),
            };
            let exact = law.projected_rows(ContactState::Slip, &point, false);
            let damped = law.damped_rows(ContactState::Slip, &point, false);
            assert_eq!(exact.residual, damped.residual);
            let measure = law.measure(&point);
            if measure.trial >= measure.limit {
                outside += 1;
                assert_eq!(
                    (exact.by_jump, exact.by_traction),
                    (damped.by_jump, damped.by_traction)
                );
                continue;
            }
            inside += 1;
            // ∂r/∂Δg_T = D, ∂r/∂t_T = ω (D − I), 0 ≤ D ≤ I: no spring −ω (D − I)⁻¹D is negative
            let d = [1, 2].map(|i: usize| [damped.by_jump[i][1], damped.by_jump[i][2]]);
            let trace = d[0][0] + d[1][1];
            assert!((trace - 1.0).abs() < 1e-12, "{d:?}");
            assert!(exact.by_jump[1][1] + exact.by_jump[2][2] > 1.0);
            for i in 0..2 {
                for j in 0..2 {
                    let one = f64::from(u8::from(i == j));
                    let by_traction = damped.by_traction[1 + i][1 + j] / law.compliance;
                    assert!((by_traction - d[i][j] + one).abs() < 1e-12);
                }
            }
        }
        assert!(inside > 50 && outside > 50, "{inside} {outside}");
    }

    #[test]
    fn solutions_are_those_of_the_slip_law() {
        let friction = Friction {
            weakening: None,
            ..LAW.friction
        };
        let law = FaceLaw { friction, ..LAW };
        let limit = friction.limit(-5e6, 0.0);
        let point = FacePoint {
            traction: [-5e6, 0.6 * limit, -0.8 * limit],
            jump: [0.0, 3e-3, -4e-3],
            start: SlipSoFar::Vector([0.0; 2]),
        };
        for rows in [
            law.rows(ContactState::Slip, &point),
            law.projected_rows(ContactState::Slip, &point, false),
        ] {
            assert!(
                rows.residual
                    .iter()
                    .all(|r| r.abs() < 1e-9 * law.compliance * limit)
            );
        }
    }

    #[test]
    fn without_slip_the_rows_across_the_shear_are_those_of_stick() {
        let limit = LAW.friction.limit(-4e6, 0.0);
        let point = FacePoint {
            traction: [-4e6, limit, 0.0],
            jump: [0.0; 3],
            start: SlipSoFar::Vector([0.0; 2]),
        };
        let rows = LAW.projected_rows(ContactState::Slip, &point, false);
        assert!((rows.by_jump[2][2] - 1.0).abs() < 1e-12);
        assert!(rows.by_traction[2][2].abs() < 1e-12 * LAW.compliance);
        assert!((rows.by_traction[1][1] + LAW.compliance).abs() < 1e-12 * LAW.compliance);
    }

    #[test]
    fn slip_against_the_shear_shows_as_a_trial_below_the_limit() {
        let limit = LAW.friction.limit(-4e6, 0.0);
        let at = |slip: f64| {
            LAW.measure(&FacePoint {
                traction: [-4e6, limit, 0.0],
                jump: [0.0, slip, 0.0],
                start: SlipSoFar::Vector([0.0; 2]),
            })
        };
        assert!(at(-1e-5).trial < limit && at(1e-5).trial > limit);
    }
}
