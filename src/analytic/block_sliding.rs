//! Two blocks that slide on each other, forth and back.

/// Two layers of heights H1 and H2 on a plane cut, the lower held, the top moved by U; only u_x(z) is free:
/// ```text
/// τ = G (U − g)/(H1 + H2)        |τ| ≤ τ_L = c + σ0 tan φ        g moves only where |τ| = τ_L, along τ
/// ```
/// so that U grows elastically up to `U_L = τ_L (H1+H2)/G`, then slips; after a reversal 2 U_L are elastic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockSliding {
    /// Shear modulus G [Pa].
    pub shear: f64,
    /// Heights H1 and H2 [m].
    pub heights: [f64; 2],
    /// Friction angle φ [rad].
    pub friction_angle: f64,
    /// Cohesion c [Pa].
    pub cohesion: f64,
    /// Compression σ0 across the cut, positive [Pa].
    pub compression: f64,
}

/// Where the blocks stand.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlidingState {
    /// Displacement of the top U [m].
    pub top: f64,
    /// Shear traction τ on the cut, the same everywhere [Pa].
    pub traction: f64,
    /// Slip g [m].
    pub slip: f64,
    /// Work done against friction so far, per area of the cut [J/m²].
    pub dissipation: f64,
}

impl BlockSliding {
    /// τ_L [Pa].
    pub fn shear_limit(self) -> f64 {
        self.cohesion + self.compression * self.friction_angle.tan()
    }

    /// G/(H1 + H2) [Pa/m].
    fn stiffness(self) -> f64 {
        self.shear / (self.heights[0] + self.heights[1])
    }

    /// U_L [m]: the displacement of the top from rest at which slip starts.
    pub fn elastic_range(self) -> f64 {
        self.shear_limit() / self.stiffness()
    }

    /// The state after the top moves on to `top` without turning on its way.
    pub fn moved(self, from: SlidingState, top: f64) -> SlidingState {
        let limit = self.shear_limit();
        // elastic trial; what exceeds the limit is slip
        let trial = self.stiffness() * (top - from.slip);
        let traction = trial.clamp(-limit, limit);
        let step = (trial - traction) / self.stiffness();
        SlidingState {
            top,
            traction,
            slip: from.slip + step,
            dissipation: from.dissipation + (traction * step).abs(),
        }
    }

    /// States along a history of the top that starts at rest; the history may turn only at its entries.
    pub fn history(self, tops: &[f64]) -> Vec<SlidingState> {
        let mut now = SlidingState::default();
        tops.iter()
            .map(|top| {
                now = self.moved(now, *top);
                now
            })
            .collect()
    }

    /// Dissipation per area of a closed cycle between −U_m and U_m: `4 τ_L (U_m − U_L)`, zero below U_L [J/m²].
    pub fn cycle_dissipation(self, amplitude: f64) -> f64 {
        4.0 * self.shear_limit() * (amplitude - self.elastic_range()).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// G = 10 GPa, τ_L = 1 MPa + 10 MPa · ½ = 6 MPa, U_L = 6 MPa · 10 m / 10 GPa = 6 mm.
    fn blocks() -> BlockSliding {
        BlockSliding {
            shear: 10e9,
            heights: [4.0, 6.0],
            friction_angle: 0.5f64.atan(),
            cohesion: 1e6,
            compression: 10e6,
        }
    }

    #[test]
    fn stick_then_slip_then_reversal_then_slip_back() {
        let b = blocks();
        approx::assert_relative_eq!(b.elastic_range(), 6e-3, max_relative = 1e-12);
        let path = b.history(&[3e-3, 6e-3, 10e-3, 4e-3, -2e-3, -5e-3]);
        let expected = [
            (3e6, 0.0),
            (6e6, 0.0),
            (6e6, 4e-3),
            (0.0, 4e-3),
            (-6e6, 4e-3),
            (-6e6, 1e-3),
        ];
        for (state, (traction, slip)) in path.iter().zip(expected) {
            assert!((state.traction - traction).abs() < 1e-6, "{state:?}");
            assert!((state.slip - slip).abs() < 1e-15, "{state:?}");
        }
        // 4 mm forth and 3 mm back under 6 MPa
        approx::assert_relative_eq!(path[5].dissipation, 42e3, max_relative = 1e-12);
    }

    #[test]
    fn slip_is_what_the_closed_form_says() {
        let b = blocks();
        let state = b.moved(SlidingState::default(), 15e-3);
        approx::assert_relative_eq!(state.slip, 15e-3 - 6e6 * 10.0 / 10e9, max_relative = 1e-12);
    }

    #[test]
    fn a_closed_cycle_dissipates_what_the_loop_encloses() {
        let b = blocks();
        for amplitude in [5e-3, 8e-3, 20e-3] {
            let path = b.history(&[amplitude, -amplitude, amplitude]);
            let cycle = path[2].dissipation - path[0].dissipation;
            approx::assert_abs_diff_eq!(cycle, b.cycle_dissipation(amplitude), epsilon = 1e-6);
        }
        assert_eq!(b.cycle_dissipation(5e-3), 0.0);
    }
}
