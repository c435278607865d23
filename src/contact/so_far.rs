//! The slip that friction follows: the vector, which may go back, or its path, which only grows.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What of its slip weakens a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum WeakeningBy {
    /// ‖γ‖, the length of the slip: a face that slips back heals.
    #[default]
    Slip,
    /// ∫ ‖dγ‖, the way that the face has gone: nothing heals.
    Path,
}

/// The slip of a face up to the start of a step, as its friction follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlipSoFar {
    /// (γ_1, γ_2) [m].
    Vector([f64; 2]),
    /// ∫ ‖dγ‖ [m].
    Path(f64),
}

impl Default for SlipSoFar {
    fn default() -> Self {
        Self::Vector([0.0; 2])
    }
}

/// The slip s that friction takes at some Δg_T of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slipped {
    /// s [m].
    pub slip: f64,
    /// Its derivative ∂s/∂Δg_T is this vector over its length [m].
    toward: [f64; 2],
    length: f64,
}

impl SlipSoFar {
    /// Of a face that has got to the slip γ [m] straight.
    pub fn straight(by: WeakeningBy, gamma: [f64; 2]) -> Self {
        match by {
            WeakeningBy::Slip => Self::Vector(gamma),
            WeakeningBy::Path => Self::Path(gamma[0].hypot(gamma[1])),
        }
    }

    /// s at the start of the step [m].
    pub fn slip(self) -> f64 {
        match self {
            Self::Vector([a, b]) => a.hypot(b),
            Self::Path(path) => path,
        }
    }

    /// `s = ‖γ + Δg_T‖`, or `s = ∫ ‖dγ‖ + ‖Δg_T‖`, after `moved` = Δg_T [m].
    pub fn after(self, moved: [f64; 2]) -> Slipped {
        match self {
            Self::Vector(start) => {
                let toward = [start[0] + moved[0], start[1] + moved[1]];
                let length = toward[0].hypot(toward[1]);
                Slipped {
                    slip: length,
                    toward,
                    length,
                }
            }
            Self::Path(path) => {
                let length = moved[0].hypot(moved[1]);
                Slipped {
                    slip: path + length,
                    toward: moved,
                    length,
                }
            }
        }
    }
}

impl Slipped {
    /// `rate ∂s/∂Δg_T`; 0 where s has no derivative.
    pub fn along(&self, rate: f64) -> [f64; 2] {
        let length = self.length;
        self.toward
            .map(|v| if length > 0.0 { rate * v / length } else { 0.0 })
    }

    /// ∂s along a direction m; 1 where s has no derivative, as any slip adds to it.
    pub(crate) fn share(&self, m: [f64; 2]) -> f64 {
        match self.length > 0.0 {
            true => (m[0] * self.toward[0] + m[1] * self.toward[1]) / self.length,
            false => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::signed;

    const STARTS: [SlipSoFar; 2] = [SlipSoFar::Vector([3e-3, -2e-3]), SlipSoFar::Path(5e-3)];

    #[test]
    fn the_derivative_is_that_of_the_slip() {
        for start in STARTS {
            for k in 0..50 {
                let moved = [signed(2 * k), signed(2 * k + 1)].map(|v| 1e-2 * v);
                let along = start.after(moved).along(1.0);
                for i in 0..2 {
                    let at = |h: f64| {
                        let mut moved = moved;
                        moved[i] += h;
                        start.after(moved).slip
                    };
                    let difference = (at(1e-7) - at(-1e-7)) / 2e-7;
                    assert!((difference - along[i]).abs() < 1e-3, "{start:?} {moved:?}");
                }
                let m = [0.6, -0.8];
                let share = along[0] * m[0] + along[1] * m[1];
                assert!((start.after(moved).share(m) - share).abs() < 1e-12);
            }
        }
    }

    /// Forth and back the vector is what it was, and the path twice as long.
    #[test]
    fn slip_back_heals_the_vector_alone() {
        let there = [4e-3, -3e-3];
        let back = there.map(|v| -v);
        let [vector, path] =
            [WeakeningBy::Slip, WeakeningBy::Path].map(|by| SlipSoFar::straight(by, there));
        assert_eq!((vector.slip(), path.slip()), (5e-3, 5e-3));
        assert_eq!(vector.after(back).slip, 0.0);
        assert_eq!(path.after(back).slip, 1e-2);
        assert_eq!(path.after([0.0; 2]).along(1.0), [0.0; 2]);
        assert_eq!(path.after([0.0; 2]).share([1.0, 0.0]), 1.0);
    }
}
