//! Wells: lines that join the faces they cross.

use super::FlowStep;

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
    /// What its pressure is, or is limited by [Pa].
    pub pressure: Option<f64>,
    /// It is rate that is given.
    pub by_rate: bool,
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
        let free = shut + self.rate / total;
        match (self.pressure, self.by_rate) {
            (Some(p), false) => (p, true),
            (Some(most), true) if self.rate > 0.0 && free > most => (most, true),
            (Some(least), true) if self.rate < 0.0 && free < least => (least, true),
            _ => (free, false),
        }
    }
}

impl FlowStep {
    /// Volume that wells bring to a part of the fractures if no limit stops them [m³].
    pub(super) fn well_volume(&self, wells: &[Well], faces: &[u32]) -> f64 {
        let here = |well: &Well| (well.cuts.first()).is_some_and(|(f, _)| faces.contains(f));
        let volumes = wells.iter().zip(&self.wells).filter(|(well, _)| here(well));
        volumes.map(|(_, step)| self.dt * step.rate).sum()
    }
}
