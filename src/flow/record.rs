//! What the fluid of a step did: flow per width, and where its volume went.

use super::{Balance, FlowRecord, FlowStep, Fluid, WellRecord};
use crate::contact::ContactState;

impl Balance<'_> {
    /// Flow per width at the centre of every face, x y z: `q = Σ_e F_e (x_e − x)/A` [m²/s].
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
            for (arm, tau) in edge.arms.iter().zip(edge.tau) {
                let f = arm.face as usize;
                let face = &self.faces[f];
                let flux = tau * (potential[f] - edge.potential);
                for i in 0..3 {
                    q[3 * f + i] += flux * (edge.middle[i] - face.center[i]) / face.area;
                }
            }
        });
        q
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
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, held) = self.potentials(p, step);
        // what leaves each face, for those whose balance is not asked for
        let mut leaving = vec![0.0; self.faces.len()];
        self.network.visit(&mobility, &potential, &held, |edge| {
            for (k, l, weight) in edge.pairs() {
                let k = edge.arms[k].face as usize;
                let l = l.map(|l| edge.arms[l].face as usize);
                let other = l.map_or(edge.potential, |l| potential[l]);
                let flux = step.dt * weight * (potential[k] - other);
                leaving[k] += flux;
                match l {
                    Some(l) => leaving[l] -= flux,
                    // below, all of its arms together
                    None if edge.well.is_some() => {}
                    None => record.out += flux,
                }
            }
            for (k, inflow) in edge.inflows() {
                leaving[k] -= step.dt * inflow;
            }
            if edge.well.is_some() {
                match step.dt * edge.outflow(&potential) {
                    out if out > 0.0 => record.out += out,
                    out => record.injected -= out,
                }
            }
        });
        for (edge, y) in self.stabilized(states, step) {
            let [k, l] = edge.faces.map(|f| f as usize);
            let moved = y * ((p[k] - step.pressure[k]) - (p[l] - step.pressure[l]));
            leaving[k] += moved;
            leaving[l] -= moved;
        }
        for f in 0..self.faces.len() {
            let a = Fluid::aperture(states[f], jumps[3 * f]);
            let [opening, compression] = self.taken(f, a, p[f], step);
            record.stored_opening += opening;
            record.stored_compression += compression;
            match step.injected[f] >= 0.0 {
                true => record.injected += step.injected[f],
                false => record.out -= step.injected[f],
            }
            if step.held[f].is_some() {
                // what holds the pressure brings what the face takes and passes on
                record.out -= opening + compression + leaving[f] - step.injected[f];
            }
        }
        record.error =
            record.injected - record.out - record.stored_opening - record.stored_compression;
        record
    }

    /// What every well did in a step.
    pub fn wells(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> Vec<WellRecord> {
        let mut records = Vec::new();
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, driven) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &driven, |edge| {
            if let Some(well) = edge.well.map(|number| &self.fluid().wells[number]) {
                records.push(WellRecord {
                    name: well.name.clone(),
                    rate: -edge.outflow(&potential),
                    pressure: edge.potential + self.fluid().head(well.head),
                });
            }
        });
        records
    }
}
