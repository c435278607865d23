//! What state a face takes next.

use super::ContactState;

/// What a face shows once equilibrium is reached in its present state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FaceMeasure {
    /// Normal jump g_N, positive where open [m].
    pub gap: f64,
    /// Normal traction t_N, negative in compression [Pa].
    pub t_n: f64,
    /// Trial shear `‖t_T + Δg_T/ω‖` [Pa]: ‖t_T‖ in stick; in slip beyond the limit where slip follows the traction, below it
    /// where it goes against it.
    pub trial: f64,
    /// τ_L [Pa].
    pub limit: f64,
}

/// What counts as zero on a face.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Thresholds {
    /// Overlap that an open face may have [m].
    pub jump: f64,
    /// Tension that a closed face may carry, and what shear in stick may exceed the limit by [Pa].
    pub traction: f64,
    /// What the trial shear of a slipping face, of which its jump is a part, may fall short of the limit by [Pa].
    pub slip: f64,
}

/// The next state:
/// ```text
/// open                     g_N < −tol_g             → stick, else open
/// closed                   t_N > tol_N              → open, else
///   stick                  τ > τ_L + tol_N          → new-slip
///   new-slip, slip         τ < τ_L − tol_T          → stick, else slip
/// ```
/// τ is the trial shear, so that a face which would slip against its traction, and produce energy, sticks.
/// The published 5 % of hysteresis, by which a sticking face may carry more than its limit, is left out.
///
/// # Source
/// M. Ferronato, SNA'25 lecture (active set); transitions as in the authors' open codes, which compare ‖t_T‖ itself.
pub fn next_state(state: ContactState, face: &FaceMeasure, tolerance: &Thresholds) -> ContactState {
    use ContactState::{NewSlip, Open, Slip, Stick};
    if state == Open {
        return if face.gap < -tolerance.jump {
            Stick
        } else {
            Open
        };
    }
    if face.t_n > tolerance.traction {
        return Open;
    }
    let above = face.trial > face.limit + tolerance.traction;
    let below = face.trial < face.limit - tolerance.slip;
    match state {
        Stick if above => NewSlip,
        Stick => Stick,
        _ if below => Stick,
        _ => Slip,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ContactState::{NewSlip, Open, Slip, Stick};

    const TOLERANCE: Thresholds = Thresholds {
        jump: 1e-9,
        traction: 1.0,
        slip: 1.0,
    };

    fn face(gap: f64, t_n: f64, trial: f64, limit: f64) -> FaceMeasure {
        FaceMeasure {
            gap,
            t_n,
            trial,
            limit,
        }
    }

    #[test]
    fn every_transition_of_the_table() {
        let closed = |trial: f64| face(0.0, -1e6, trial, 6e5);
        let table = [
            (Open, face(1e-3, 0.0, 0.0, 0.0), Open),
            (Open, face(-1e-10, 0.0, 0.0, 0.0), Open),
            (Open, face(-1e-8, 0.0, 0.0, 0.0), Stick),
            (Stick, face(0.0, 2.0, 0.0, 0.0), Open),
            (NewSlip, face(0.0, 2.0, 1.0, 0.0), Open),
            (Slip, face(0.0, 2.0, 1.0, 0.0), Open),
            (Stick, face(0.0, 0.5, 0.0, 0.0), Stick),
            (Stick, closed(5e5), Stick),
            (Stick, closed(6e5), Stick),
            (Stick, closed(6.1e5), NewSlip),
            (NewSlip, closed(6e5), Slip),
            (NewSlip, closed(5e5), Stick),
            (Slip, closed(6e5), Slip),
            (Slip, closed(7e5), Slip),
            (Slip, closed(5e5), Stick),
        ];
        for (state, measure, expected) in table {
            assert_eq!(
                next_state(state, &measure, &TOLERANCE),
                expected,
                "{state:?} {measure:?}"
            );
        }
    }
}
