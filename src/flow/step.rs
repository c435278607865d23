//! What is given over a step in time, and what became of the fluid in it.

/// A step: from when, what comes in, what is held.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowStep {
    /// Its length [s].
    pub dt: f64,
    /// Pressure per face at its start [Pa].
    pub pressure: Vec<f64>,
    /// Aperture per face at its start, 0 where closed [m].
    pub aperture: Vec<f64>,
    /// Volume that rates bring to each face, `∫ q dt` [m³].
    pub injected: Vec<f64>,
    /// The same of every source with a rate [m³].
    pub sources: Vec<f64>,
    /// Pressure of faces whose pressure is prescribed, at the end [Pa].
    pub held: Vec<Option<f64>>,
    /// Pressure per edge of prescribed pressure, at the end [Pa].
    pub held_edges: Vec<f64>,
    /// Per well.
    pub wells: Vec<super::WellStep>,
    /// Faces whose jumps of pressure are stabilized as those of open faces are, whatever their states; empty: none.
    pub joined: Vec<bool>,
}

impl FlowStep {
    /// The same with these faces joined.
    pub fn joining(&self, joined: &[bool]) -> Self {
        Self {
            joined: joined.to_vec(),
            ..self.clone()
        }
    }
}

/// Where the fluid of a step went: a line of `flow.csv`.
///
/// Every source, well, face and edge of prescribed pressure counts by what it brings or takes over the step as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlowRecord {
    /// Brought in by all that bring fluid; never negative [m³].
    pub injected: f64,
    /// Taken by the opening of fractures [m³].
    pub stored_opening: f64,
    /// Taken by compression and storage [m³].
    pub stored_compression: f64,
    /// Taken out by all that take fluid; never negative [m³].
    pub out: f64,
    /// `injected − out − stored_opening − stored_compression` [m³].
    pub error: f64,
}
