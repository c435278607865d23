//! What the fluid of a step did: flow per width, and where its volume went.

use super::balance::ROUNDINGS;
use super::{Balance, Control, FlowRecord, FlowStep, Fluid, WellRecord, WellStep};
use crate::contact::ContactState;

/// What leaves a face in a step where a pressure is given.
struct Passage {
    face: usize,
    /// Number of the well that it leads to.
    well: Option<usize>,
    /// What leaves [m³].
    volume: f64,
    /// What of it is a rounding of potentials [m³].
    rounding: f64,
}

impl Balance<'_> {
    /// Flow per width at the centre of every face, x y z, in the plane of the face: `q = Σ_e F_e (x_e − x)/A` [m²/s].
    ///
    /// What a well brings spreads from the centre to all sides and is no flow across the face.
    pub fn fluxes(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> Vec<f64> {
        let mut q = vec![0.0; 3 * self.faces.len()];
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, held) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &held, |edge| {
            if edge.well.is_some() {
                return;
            }
            for (f, flux) in edge.fluxes() {
                let face = &self.faces[f];
                let off: [f64; 3] = std::array::from_fn(|i| edge.middle[i] - face.center[i]);
                // the middle of an edge of a warped face lies beside its mean plane
                let n = face.frame[0];
                let height: f64 = (0..3).map(|i| off[i] * n[i]).sum();
                for i in 0..3 {
                    q[3 * f + i] += flux * (off[i] - height * n[i]) / face.area;
                }
            }
        });
        q
    }

    /// What leaves faces where a pressure is given: through edges and wells, and out of faces of prescribed pressure.
    ///
    /// `τ (Φ_f − Φ_e)` is the difference of two numbers that are rounded, of which a large τ makes much. As much of what the balance of a
    /// face, and then of the faces connected to it, leaves over as this can be goes with what passes there.
    fn passages(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> Vec<Passage> {
        let n = self.faces.len();
        let (mut passages, mut left, mut rounding) = (Vec::new(), vec![0.0; n], vec![0.0; n]);
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, driven) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &driven, |edge| {
            for passing in edge.passing() {
                let (face, weight) = (passing.from, passing.weight);
                let volume = step.dt * weight * passing.drop;
                let unsure = step.dt * weight * passing.apart;
                let unsure = ROUNDINGS * f64::EPSILON * unsure;
                left[face] += volume;
                rounding[face] += unsure;
                match passing.to {
                    Some(l) => {
                        left[l] -= volume;
                        rounding[l] += unsure;
                    }
                    None => passages.push(Passage {
                        face,
                        well: edge.well,
                        volume,
                        rounding: unsure,
                    }),
                }
            }
            for (k, inflow) in edge.inflows() {
                left[k] -= step.dt * inflow;
            }
        });
        for (edge, y) in self.stabilized(states, step) {
            let [k, l] = edge.faces.map(|f| f as usize);
            let moved = y * ((p[k] - step.pressure[k]) - (p[l] - step.pressure[l]));
            left[k] += moved;
            left[l] -= moved;
        }
        for f in 0..n {
            let a = Fluid::aperture(states[f], jumps[3 * f]);
            let [opening, compression] = self.taken(f, a, p[f], step);
            left[f] += opening + compression - step.injected[f];
            // what holds the pressure of a face brings what its balance leaves over
            if step.held[f].is_some() {
                passages.push(Passage {
                    face: f,
                    well: None,
                    volume: -left[f],
                    rounding: rounding[f],
                });
                left[f] = 0.0;
            }
        }
        let each: Vec<Vec<u32>> = (0..n as u32).map(|f| vec![f]).collect();
        for parts in [&each, &self.parts] {
            settle(&mut passages, &mut left, parts);
        }
        passages
    }

    /// Where the fluid of a step went.
    pub fn record(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> FlowRecord {
        let mut record = FlowRecord::default();
        for f in 0..self.faces.len() {
            let a = Fluid::aperture(states[f], jumps[3 * f]);
            let [opening, compression] = self.taken(f, a, p[f], step);
            record.stored_opening += opening;
            record.stored_compression += compression;
        }
        let passages = self.passages(states, jumps, p, step);
        let others = passages.iter().filter(|passage| passage.well.is_none());
        let others = others.map(|passage| -passage.volume);
        let wells = self.brought_by_wells(&passages, step);
        let sources = step.sources.iter().copied();
        for volume in sources.chain(wells).chain(others) {
            match volume > 0.0 {
                true => record.injected += volume,
                false => record.out -= volume,
            }
        }
        record.error =
            record.injected - record.out - record.stored_opening - record.stored_compression;
        record
    }

    /// Volume per well: that of its rate, or what passes where its pressure is given [m³].
    fn brought_by_wells(&self, passages: &[Passage], step: &FlowStep) -> Vec<f64> {
        let rates = step.wells.iter().map(|well| step.dt * well.inflow());
        let mut volumes: Vec<f64> = rates.collect();
        for passage in passages {
            if let Some(well) = passage.well {
                volumes[well] -= passage.volume;
            }
        }
        volumes
    }

    /// What every well did in a step.
    pub fn wells(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> Vec<WellRecord> {
        let mut pressures = vec![f64::NAN; step.wells.len()];
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, driven) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &driven, |edge| {
            if let Some(well) = edge.well {
                pressures[well] = edge.potential + self.fluid().head(self.fluid().wells[well].head);
            }
        });
        let passages = self.passages(states, jumps, p, step);
        let volumes = self.brought_by_wells(&passages, step);
        let rate = |(well, volume): (&WellStep, f64)| match well.control {
            Control::Rate | Control::Shut => well.inflow(),
            Control::Pressure | Control::Limit => volume / step.dt,
        };
        let rates = step.wells.iter().zip(volumes).map(rate);
        let wells = self.fluid().wells.iter().zip(rates).zip(pressures);
        wells
            .map(|((well, rate), pressure)| WellRecord {
                name: well.name.clone(),
                rate,
                pressure,
            })
            .collect()
    }
}

/// Passages take up what is left over in each part, by the shares of their rounding and no more than that.
fn settle(passages: &mut [Passage], left: &mut [f64], parts: &[Vec<u32>]) {
    let mut part_of = vec![usize::MAX; left.len()];
    for (number, part) in parts.iter().enumerate() {
        part.iter().for_each(|f| part_of[*f as usize] = number);
    }
    let mut over = vec![0.0; parts.len()];
    let mut rounding = over.clone();
    (0..left.len()).for_each(|f| over[part_of[f]] += left[f]);
    for passage in passages.iter() {
        rounding[part_of[passage.face]] += passage.rounding;
    }
    for passage in passages.iter_mut().filter(|passage| passage.rounding > 0.0) {
        let part = part_of[passage.face];
        let taken = (over[part] / rounding[part]).clamp(-1.0, 1.0) * passage.rounding;
        passage.volume -= taken;
        left[passage.face] -= taken;
    }
}
