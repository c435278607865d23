//! What follows M⁻¹r in the series of an error.

use super::EnergyNorms;
use crate::krylov::System;
use fracas_operators::Fields;
use fracas_operators::vector::axpy;

/// Times that an error may be longer than M⁻¹r by terms that fall alike. Unit: 1.
pub const FOLLOWS: f64 = 10.0;

/// Of `𝒜⁻¹r = Σ (I − M⁻¹𝒜)ᵏ e`, `e = M⁻¹r`, what the second term says.
///
/// Where 𝒜 is not symmetric M⁻¹𝒜 may be far from normal, and the Ritz values of a few iterations tell little of it: tractions of faces in slip
/// were wrong by 2.6e-3 where 4.7e-5 was said, beside a Ritz value of 0.12.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    /// Norms of e.
    first: Fields<f64>,
    /// Norms of `M⁻¹(r − 𝒜e)`.
    second: Fields<f64>,
    /// Norms of both together: with the second a field sees what the errors of another do to it.
    both: Fields<f64>,
}

impl Series {
    /// Of the residual `system.rhs` with this e and its norms.
    ///
    /// # Cost
    /// A product with 𝒜, a solve with M and two norms.
    pub fn new(
        (e, first): (&[f64], Fields<f64>),
        system: &System<'_, f64>,
        norms: &EnergyNorms<'_>,
        work: &mut [f64],
    ) -> Self {
        let mut next = system.correction(e, work);
        let second = norms.error(&next);
        axpy(1.0, e, &mut next);
        Self {
            first,
            second,
            both: norms.error(&next),
        }
    }

    /// Norms of e.
    pub(super) fn first(&self) -> Fields<f64> {
        self.first
    }

    /// Norms of the term behind e.
    pub(super) fn second(&self) -> Fields<f64> {
        self.second
    }

    /// Norms of the first two terms together.
    pub(super) fn both(&self) -> Fields<f64> {
        self.both
    }

    /// Norms of the sum, field by field: where the second term is θ times as long as the first, and those behind it fall alike, the sum is
    /// 1/(1 − θ) times as long, up to [`FOLLOWS`]; it is no shorter than both together.
    pub fn sum(&self) -> Fields<f64> {
        self.first.map(|field, first| {
            let share = match first {
                0.0 => 0.0,
                _ => (self.second[field] / first).min(1.0 - FOLLOWS.recip()),
            };
            // NaN of either is kept
            let sum = first / (1.0 - share);
            let both = self.both[field];
            if both <= sum { sum } else { both }
        })
    }
}
