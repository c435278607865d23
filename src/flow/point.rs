//! The balance of volumes at a point, and what of it is rounding.

use super::Balance;
use crate::contact::ContactState;
use fracas_operators::vector::norm2;

/// Mean error of a number that is rounded to the nearest, over ε times the number. Unit: 1.
const ROUNDED: f64 = 0.25;

/// The balance at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowPoint {
    /// R per face [m³].
    pub residual: Vec<f64>,
    /// ‖·‖₂ of what R is the sum of, each face's terms by their sizes [m³].
    pub size: f64,
    /// The part of ‖R‖₂ that is rounding [m³].
    pub rounding: f64,
    /// |Σ R| over the faces whose pressure is free, beyond rounding of what prescribed pressures bring: volume lost or made [m³].
    pub lost: f64,
    /// Σ of the volumes in them and of those that come and go [m³].
    pub volume: f64,
}

impl FlowPoint {
    /// The same where this volume is rounding, too [m³].
    pub(crate) fn beyond(self, volume: f64) -> Self {
        Self {
            rounding: self.rounding + volume,
            lost: (self.lost - volume).max(0.0),
            ..self
        }
    }

    /// ‖R‖₂ beyond rounding over the size of its terms; 0 where there is nothing. Unit: 1.
    pub fn relative(&self) -> f64 {
        let left = (norm2(&self.residual) - self.rounding).max(0.0);
        if left == 0.0 { 0.0 } else { left / self.size }
    }

    /// Volume lost over all volumes; 0 where there is none. Unit: 1.
    pub fn loss(&self) -> f64 {
        match self.lost == 0.0 {
            true => 0.0,
            false => self.lost / self.volume,
        }
    }
}

impl Balance<'_> {
    /// Rounding of the volume in open faces [m³]: jumps are differences of displacements that tractions of this size [Pa] cause, and
    /// the roundings of faces are independent.
    pub(crate) fn unseen(&self, states: &[ContactState], traction: f64) -> f64 {
        let open = |f: &usize| states[*f] == ContactState::Open;
        let of = |f: usize| self.compliance[f] * traction * self.faces[f].area;
        let squares: f64 = (0..states.len()).filter(open).map(|f| of(f).powi(2)).sum();
        ROUNDED * f64::EPSILON * squares.sqrt()
    }
}
