//! How far a fluid opens a fracture in one round of the active set.

use super::{Balance, FlowStep};
use crate::contact::ContactState;

/// Open area after a round over that before it, at most; a whole ring of faces opens in any case. Unit: 1.
const GROWTH: f64 = 3.0;

impl Balance<'_> {
    /// Those of the faces that would open, `wanted`, which do: ring by ring around the open ones while the open area grows by no more
    /// than [`GROWTH`]. Where none is open those come first that the step brings fluid to; all open where no ring begins.
    ///
    /// A closed face that stores nothing has the pressure of the open ones beside it, whatever its conductivity, so that a fracture would
    /// open as a whole; but its fluid does not come as fast, and the faces beyond the front would close again one by one.
    ///
    /// # Cost
    /// A visit of every edge per ring.
    pub(crate) fn front(
        &self,
        states: &[ContactState],
        wanted: &[usize],
        step: &FlowStep,
    ) -> Vec<usize> {
        let area = |f: usize| self.faces[f].area;
        let mut reached: Vec<bool> = states.iter().map(|s| *s == ContactState::Open).collect();
        let mut is_wanted = vec![false; states.len()];
        wanted.iter().for_each(|f| is_wanted[*f] = true);
        let mut open: f64 = (0..states.len()).filter(|f| reached[*f]).map(area).sum();
        let mut ring = match open > 0.0 {
            true => self.beside(&reached, &is_wanted),
            false => self.fed(wanted, step),
        };
        let (most, mut taken) = (GROWTH * open, Vec::new());
        while !ring.is_empty() {
            open += ring.iter().map(|f| area(*f)).sum::<f64>();
            if !taken.is_empty() && open > most {
                break;
            }
            ring.iter().for_each(|f| reached[*f] = true);
            taken.append(&mut ring);
            ring = self.beside(&reached, &is_wanted);
        }
        match taken.is_empty() {
            true => wanted.to_vec(),
            false => taken,
        }
    }

    /// Faces of `among` that share an edge or a well with one that is reached, and are not.
    fn beside(&self, reached: &[bool], among: &[bool]) -> Vec<usize> {
        let mut ring = Vec::new();
        for arms in self.network.meetings() {
            let faces = || arms.iter().map(|arm| arm.face as usize);
            if faces().any(|f| reached[f]) {
                ring.extend(faces().filter(|f| among[*f] && !reached[*f]));
            }
        }
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// The faces that rates or wells bring fluid to.
    fn fed(&self, faces: &[usize], step: &FlowStep) -> Vec<usize> {
        let wells = self.fluid().wells.iter().zip(&step.wells);
        let cuts = wells.filter(|(_, step)| step.rate > 0.0);
        let cut: Vec<u32> = cuts
            .flat_map(|(well, _)| well.cuts.iter().map(|(f, _)| *f))
            .collect();
        let is_fed = |f: &usize| step.injected[*f] > 0.0 || cut.contains(&(*f as u32));
        faces.iter().copied().filter(is_fed).collect()
    }

    /// The aperture that all the fluid of a step would give to the smallest face [m].
    pub(crate) fn widest(&self, step: &FlowStep) -> f64 {
        let least = (self.faces.iter()).fold(f64::INFINITY, |least, face| least.min(face.area));
        let by_wells = step.wells.iter().map(|well| step.dt * well.rate);
        let rates = step.injected.iter().copied().chain(by_wells);
        rates.filter(|v| *v > 0.0).sum::<f64>() / least
    }
}
