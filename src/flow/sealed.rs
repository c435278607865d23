//! Fractures that nothing leaves, all closed, of an incompressible fluid: their pressure is known up to a constant.

use super::{Balance, FlowStep};
use crate::contact::ContactState;
use crate::mesh::FractureFace;

/// Share of the volumes that come and go below which nothing is left over. Unit: 1.
const NOTHING: f64 = 1e-11;

/// Connected faces, all closed, that take up nothing and let nothing out.
#[derive(Clone, Debug, PartialEq)]
pub struct Sealed {
    /// Its faces, increasing.
    pub faces: Vec<u32>,
    /// Volume that would have to be in them though they are closed [m³]: above 0 they must open, below 0 more is asked of them than
    /// they hold; 0 where it is rounding.
    pub excess: f64,
}

impl Balance<'_> {
    /// The sealed parts in these states.
    pub fn sealed(&self, states: &[ContactState], step: &FlowStep) -> Vec<Sealed> {
        let closed = |faces: &&Vec<u32>| self.is_sealed(faces, states);
        let excess = |faces: &Vec<u32>| {
            let (mut excess, mut size) = (0.0, 0.0);
            for f in faces.iter().map(|f| *f as usize) {
                let held = self.faces[f].area * step.aperture[f];
                excess += step.injected[f] + held;
                size += step.injected[f].abs() + held.abs();
            }
            let brought = step.well_volume(&self.fluid().wells, faces);
            excess += brought;
            size += brought.abs();
            match excess.abs() <= NOTHING * size {
                true => 0.0,
                false => excess,
            }
        };
        let sealed = |faces: &Vec<u32>| Sealed {
            excess: excess(faces),
            faces: faces.clone(),
        };
        self.closable.iter().filter(closed).map(sealed).collect()
    }

    /// True where every face is closed.
    pub(super) fn is_sealed(&self, faces: &[u32], states: &[ContactState]) -> bool {
        faces
            .iter()
            .all(|f| states[*f as usize] != ContactState::Open)
    }

    /// Faces of a sealed part that open first: those that fluid comes to, else those that were open, else all.
    pub fn to_open(&self, sealed: &Sealed, step: &FlowStep) -> Vec<u32> {
        let which = |holds: &dyn Fn(usize) -> bool| -> Vec<u32> {
            let faces = sealed.faces.iter().copied();
            faces.filter(|f| holds(*f as usize)).collect()
        };
        let wells = self.fluid().wells.iter().zip(&step.wells);
        let cut: Vec<usize> = wells
            .filter(|(_, step)| step.rate > 0.0)
            .flat_map(|(well, _)| well.cuts.iter().map(|(f, _)| *f as usize))
            .collect();
        let fed = which(&|f| step.injected[f] > 0.0 || cut.contains(&f));
        if !fed.is_empty() {
            return fed;
        }
        let open = which(&|f| step.aperture[f] > 0.0);
        match open.is_empty() {
            true => sealed.faces.clone(),
            false => open,
        }
    }
}

/// Parts that are sealed where all their faces are closed: none of their faces stores fluid or has a pressure of its own.
pub(super) fn closable(
    faces: &[FractureFace],
    meetings: impl Iterator<Item = Vec<u32>>,
    open_ended: impl Fn(usize) -> bool,
) -> Vec<Vec<u32>> {
    let mut parent: Vec<usize> = (0..faces.len()).collect();
    let mut root = |mut f: usize, to: Option<usize>| {
        while parent[f] != f {
            parent[f] = parent[parent[f]];
            f = parent[f];
        }
        if let Some(to) = to {
            parent[f] = to;
        }
        f
    };
    for meeting in meetings {
        for pair in meeting.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|f| root(f as usize, None));
            // the lower number stands for both
            root(a.max(b), Some(a.min(b)));
        }
    }
    let mut parts: Vec<Vec<u32>> = vec![Vec::new(); faces.len()];
    for f in 0..faces.len() {
        parts[root(f, None)].push(f as u32);
    }
    parts.retain(|part| !part.is_empty() && !part.iter().any(|f| open_ended(*f as usize)));
    parts
}
