//! Fractures that nothing leaves, all closed, of an incompressible fluid: their pressure is known up to a constant.

use super::{Balance, Control, FlowStep, WellStep};
use crate::contact::ContactState;

/// Share of the volumes that come and go below which nothing is left over. Unit: 1.
const NOTHING: f64 = 1e-11;

/// Connected faces, all closed, that take up nothing and let nothing out.
#[derive(Clone, Debug, PartialEq)]
pub struct Sealed {
    /// Its faces, increasing.
    pub faces: Vec<u32>,
    /// Volume that would have to be in them though they are closed, whatever wells their limits throttle [m³]: above 0 they must open,
    /// below 0 more is asked of them than they hold; 0 where it is rounding.
    pub excess: f64,
    /// The same if no limit throttles a well [m³].
    pub asked: f64,
    /// Largest limit of the wells that inject [Pa]: −∞ where none does, ∞ where one has none.
    pub reach: f64,
}

impl Balance<'_> {
    /// The sealed parts in these states.
    pub fn sealed(&self, states: &[ContactState], step: &FlowStep) -> Vec<Sealed> {
        let closed = |faces: &&Vec<u32>| is_closed(faces, states);
        let sealed = |faces: &Vec<u32>| {
            // wells throttled so that most is in the part, or least
            let kept = |sign: f64| {
                self.brought(faces, step, |well| match well.limit() {
                    Some(_) if sign * well.rate < 0.0 => 0.0,
                    _ => well.rate,
                })
            };
            let (most, least) = (kept(1.0), kept(-1.0));
            let wells = step.wells_in(&self.fluid().wells, faces);
            let limits = wells.filter(|(_, well)| well.rate > 0.0);
            let limits = limits.map(|(_, well)| well.limit().unwrap_or(f64::INFINITY));
            Sealed {
                excess: least.max(0.0) + most.min(0.0),
                asked: self.brought(faces, step, |well| well.rate),
                reach: limits.fold(f64::NEG_INFINITY, f64::max),
                faces: faces.clone(),
            }
        };
        self.closable.iter().filter(closed).map(sealed).collect()
    }

    /// What sources bring to a part, with what was in it, and wells at these rates; 0 where it is rounding [m³].
    pub(super) fn brought(
        &self,
        faces: &[u32],
        step: &FlowStep,
        rate: impl Fn(&WellStep) -> f64,
    ) -> f64 {
        let (mut sum, mut size) = (0.0, 0.0);
        let mut add = |volume: f64| {
            sum += volume;
            size += volume.abs();
        };
        for f in faces.iter().map(|f| *f as usize) {
            add(step.injected[f]);
            add(self.faces[f].area * step.aperture[f]);
        }
        let wells = step.wells_in(&self.fluid().wells, faces);
        wells.for_each(|(_, well)| add(step.dt * rate(well)));
        match sum.abs() <= NOTHING * size {
            true => 0.0,
            false => sum,
        }
    }

    /// True where every face is closed, and no well at its limit gives the part its pressure.
    pub(super) fn is_sealed(
        &self,
        faces: &[u32],
        states: &[ContactState],
        step: &FlowStep,
    ) -> bool {
        let mut wells = step.wells_in(&self.fluid().wells, faces);
        is_closed(faces, states) && wells.all(|(_, well)| well.control != Control::Limit)
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

/// True where every face is closed.
pub(super) fn is_closed(faces: &[u32], states: &[ContactState]) -> bool {
    let closed = |f: &u32| states[*f as usize] != ContactState::Open;
    faces.iter().all(closed)
}

/// Faces that meet, directly or through others, increasing in each part.
pub(super) fn connected(faces: usize, meetings: impl Iterator<Item = Vec<u32>>) -> Vec<Vec<u32>> {
    let mut parent: Vec<usize> = (0..faces).collect();
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
    let mut parts: Vec<Vec<u32>> = vec![Vec::new(); faces];
    for f in 0..faces {
        parts[root(f, None)].push(f as u32);
    }
    parts.retain(|part| !part.is_empty());
    parts
}
