//! What is given over a step in time, and what became of the fluid in it.

use super::{Balance, Control, Given, Place, WellGiven, WellStep};

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
    pub wells: Vec<WellStep>,
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

impl Balance<'_> {
    /// The step from `times[0]` to `times[1]` [s]; `factor` is that of a history at a time.
    pub fn step(
        &self,
        times: [f64; 2],
        pressure: Vec<f64>,
        aperture: Vec<f64>,
        factor: impl Fn(usize, f64) -> f64,
    ) -> FlowStep {
        let mut step = FlowStep {
            dt: times[1] - times[0],
            pressure,
            aperture,
            injected: vec![0.0; self.faces.len()],
            sources: Vec::new(),
            held: vec![None; self.faces.len()],
            held_edges: Vec::new(),
            wells: Vec::new(),
            joined: Vec::new(),
        };
        let fluid = self.fluid();
        for well in &fluid.wells {
            let head = fluid.head(well.head);
            step.wells.push(match well.given {
                WellGiven::Rate(rate, limit) => WellStep {
                    // as for sources
                    rate: 0.5
                        * rate
                        * (factor(well.history, times[0]) + factor(well.history, times[1])),
                    pressure: limit.map(|p| p - head),
                    control: Control::Rate,
                },
                WellGiven::Pressure(p) => WellStep {
                    rate: 0.0,
                    pressure: Some(p * factor(well.history, times[1]) - head),
                    control: Control::Pressure,
                },
            });
        }
        for source in &fluid.sources {
            match (&source.place, source.given) {
                (Place::Faces(faces), Given::Rate(rate)) => {
                    // histories are linear between the times that steps land on
                    let mean =
                        0.5 * (factor(source.history, times[0]) + factor(source.history, times[1]));
                    let area = |f: &u32| self.faces[*f as usize].area;
                    let whole: f64 = faces.iter().map(area).sum();
                    step.sources.push(step.dt * rate * mean);
                    for f in faces {
                        step.injected[*f as usize] += step.dt * rate * mean * area(f) / whole;
                    }
                }
                (Place::Faces(faces), Given::Pressure(p)) => {
                    let p = p * factor(source.history, times[1]);
                    for f in faces.iter().map(|f| *f as usize) {
                        let weight = fluid.weight(self.faces[f].center, source.level);
                        step.held[f] = Some(p + weight);
                    }
                }
                (Place::Edges(edges), Given::Pressure(p)) => {
                    let p = p * factor(source.history, times[1]);
                    let first = step.held_edges.len();
                    let middles = self.held_middles[first..].iter().take(edges.len());
                    let of = |x: &[f64; 3]| p + fluid.weight(*x, source.level);
                    step.held_edges.extend(middles.map(of));
                }
                // no scene has it
                (Place::Edges(_), Given::Rate(_)) => {}
            }
        }
        step
    }
}
