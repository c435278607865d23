//! Wells: lines that join the faces they cross.

use super::FlowStep;
use std::borrow::Cow;

/// A well with the faces that it cuts; they meet in it as on an edge of the [`Network`](super::Network).
///
/// Each face takes `τ_k (Φ_w − Φ_k)`, `τ = WI C_f/μ`, `WI = 2π/ln(r_e/r_w)` with `r_e = 0.14 √(a² + b²)` for sides a and b of the face. The
/// potential of the well is the same along it: its fluid stands in equilibrium with its weight.
///
/// # Source
/// D. W. Peaceman, SPE J. 18 (1978) 183–194.
#[derive(Clone, Debug, PartialEq)]
pub struct Well {
    /// Its name.
    pub name: String,
    /// Faces, each with WI. Unit: 1.
    pub cuts: Vec<(u32, f64)>,
    /// Where its pressure is told [m].
    pub head: [f64; 3],
    /// What is given, at the factor 1 of its history.
    pub given: WellGiven,
    /// Number of its history.
    pub history: usize,
}

/// What controls a well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WellGiven {
    /// Volume per time [m³/s], and the pressure that injection does not exceed and withdrawal does not go below, if any [Pa].
    Rate(f64, Option<f64>),
    /// Pressure [Pa].
    Pressure(f64),
}

/// A well in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WellStep {
    /// Mean rate over the step, 0 where pressure controls it [m³/s].
    pub rate: f64,
    /// Potential that it has, or that limits it [Pa].
    pub pressure: Option<f64>,
    /// What holds of it.
    pub control: Control,
}

/// What holds of a well: with a limit Φ_L, the sign s of its rate Q and what it brings, q,
/// ```text
/// q = Q, s (Φ_L − Φ_w) ≥ 0      or      Φ_w = Φ_L, 0 ≤ s q ≤ s Q      or      q = 0, s (Φ_L − Φ_w) ≤ 0
/// ```
/// so that a limit throttles a well down to nothing and never turns it round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Its pressure is prescribed.
    Pressure,
    /// It brings its rate.
    Rate,
    /// It is at its limit of pressure and brings a part of its rate.
    Limit,
    /// It brings nothing: the pressure of the fractures is beyond its limit.
    Shut,
}

/// What a well did in a step: its columns of `flow.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct WellRecord {
    /// Its name.
    pub name: String,
    /// Mean rate into the fractures [m³/s].
    pub rate: f64,
    /// Pressure at its upper end [Pa].
    pub pressure: f64,
}

/// What drives edges: prescribed potentials per held edge, and wells.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Driven {
    /// Potential per held edge [Pa].
    pub(super) held: Vec<f64>,
    /// Per well.
    pub(super) wells: Vec<WellStep>,
}

impl WellStep {
    /// Potential of a well for the one at which it lets nothing out and the sum of its τ, and whether pressure controls it.
    pub(super) fn potential(&self, shut: f64, total: f64) -> (f64, bool) {
        match (self.control, self.pressure) {
            (Control::Pressure | Control::Limit, Some(p)) => (p, true),
            _ => (shut + self.inflow() / total, false),
        }
    }

    /// The rate at which it is known to bring fluid, 0 where pressure controls it [m³/s].
    pub(super) fn inflow(&self) -> f64 {
        match self.control {
            Control::Rate => self.rate,
            Control::Pressure | Control::Limit | Control::Shut => 0.0,
        }
    }

    /// Its limit, where it has one that its rate may meet [Pa].
    pub(super) fn limit(&self) -> Option<f64> {
        let limited = self.control != Control::Pressure && self.rate != 0.0;
        self.pressure.filter(|_| limited)
    }
}

impl FlowStep {
    /// What holds of every well.
    pub fn controls(&self) -> Vec<Control> {
        self.wells.iter().map(|well| well.control).collect()
    }

    /// The same with these controls.
    pub(crate) fn controlled(&self, controls: &[Control]) -> Cow<'_, Self> {
        let now = self.wells.iter().map(|well| well.control);
        if now.eq(controls.iter().copied()) {
            return Cow::Borrowed(self);
        }
        let mut step = self.clone();
        for (well, control) in step.wells.iter_mut().zip(controls) {
            well.control = *control;
        }
        Cow::Owned(step)
    }

    /// Number of wells that may meet a limit.
    pub(crate) fn limited(&self) -> usize {
        let limits = self.wells.iter().filter_map(WellStep::limit);
        limits.count()
    }

    /// The wells that cut a part of the fractures, by their numbers.
    pub(super) fn wells_in<'s>(
        &'s self,
        wells: &'s [Well],
        faces: &'s [u32],
    ) -> impl Iterator<Item = (usize, &'s WellStep)> {
        let here = |well: &Well| (well.cuts.first()).is_some_and(|(f, _)| faces.contains(f));
        let numbered = wells.iter().zip(&self.wells).enumerate();
        numbered
            .filter(move |(_, (well, _))| here(well))
            .map(|(i, (_, step))| (i, step))
    }
}
