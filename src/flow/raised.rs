//! Given pressures, on their way from those that the fluid has.

use super::{Balance, Control, FlowStep};

impl Balance<'_> {
    /// The step with given pressures that have gone a `share` of the way (0 to 1) from those of the fluid at its start: on a face from its own,
    /// on an edge and in a well from the mean potential of the faces that meet there. Rates are whole: steps that fail with them are halved.
    pub(crate) fn raised(&self, step: &FlowStep, share: f64) -> FlowStep {
        let mut raised = step.clone();
        let on_the_way = |from: f64, to: &mut f64| *to = (1.0 - share) * from + share * *to;
        for (held, p) in raised.held.iter_mut().zip(&step.pressure) {
            held.iter_mut().for_each(|held| on_the_way(*p, held));
        }
        let (potential, _) = self.potentials(&step.pressure, step);
        let mut beside = vec![[0.0; 2]; step.held_edges.len()];
        for (number, face) in self.network.held_edge_faces() {
            beside[number][0] += potential[face];
            beside[number][1] += 1.0;
        }
        let edges = raised.held_edges.iter_mut().zip(&self.held_middles);
        for ((held, middle), [sum, faces]) in edges.zip(beside) {
            on_the_way(sum / faces + self.fluid().head(*middle), held);
        }
        for (well, drilled) in raised.wells.iter_mut().zip(&self.fluid().wells) {
            let cuts = drilled.cuts.iter().map(|(f, _)| potential[*f as usize]);
            let mean = cuts.sum::<f64>() / drilled.cuts.len() as f64;
            let is_given = well.control == Control::Pressure;
            let given = well.pressure.iter_mut().filter(|_| is_given);
            given.for_each(|given| on_the_way(mean, given));
        }
        raised
    }
}
