//! Closed parts whose storage rounding loses beside what flows in a step: their balance as a whole.

use super::network::Network;
use super::sealed::is_closed;
use super::well::Driven;
use super::{Balance, Control, FlowStep, Fluid, WellStep};
use crate::contact::ContactState;
use crate::mesh::FractureFace;

/// What flows over a step per pressure, over what the part stores, above which a face of it is given the balance of the whole: half of
/// the digits of its pressure are left there. Unit: 1.
const DROWNED: f64 = 1e8;

/// A connected part of several faces that store fluid, and that nothing gives a pressure but its storage while they are closed.
#[derive(Clone, Debug)]
pub(super) struct Reservoir {
    /// Its faces, that which lets most through first.
    pub(super) faces: Vec<u32>,
    /// `∂F/∂p`, the largest of a face, where all are closed [m³/(Pa s)].
    conductance: f64,
    /// `Σ A (c_f w + s)`, where all are closed [m³/Pa].
    storage: f64,
}

/// The balance of a part, without the fluxes between its faces.
pub(super) struct Whole {
    /// `Σ_f A (a − a₀) + A c_f (p w − p₀ w₀) + A s (p − p₀) − ∫ q dt` [m³].
    pub(super) residual: f64,
    /// The sizes of its terms [m³].
    pub(super) size: f64,
    /// Those that are rounded [m³].
    pub(super) rounding: f64,
}

impl Reservoir {
    /// Those among `parts`, which no pressure is given to; `held` edges of the others have one.
    pub(super) fn among(
        parts: impl Iterator<Item = Vec<u32>>,
        (fluid, faces): (&Fluid, &[FractureFace]),
        (network, held): (&Network, usize),
    ) -> Vec<Self> {
        let mobility: Vec<f64> = faces
            .iter()
            .map(|face| fluid.conductivity(face, ContactState::Stick, 0.0)[0] / fluid.viscosity)
            .collect();
        let mut leaving = vec![0.0; faces.len()];
        let shut = WellStep {
            rate: 0.0,
            pressure: None,
            control: Control::Rate,
        };
        let driven = Driven {
            held: vec![0.0; held],
            wells: vec![shut; fluid.wells.len()],
        };
        network.visit(&mobility, &vec![0.0; faces.len()], &driven, |edge| {
            edge.by_potential(|k, m, value| {
                if k == m {
                    leaving[k] += value;
                }
            });
        });
        let of = |mut part: Vec<u32>| {
            // the pressure of a face that is hardly connected needs its own row
            let most = (0..part.len()).max_by(|a, b| {
                let [a, b] = [a, b].map(|place| leaving[part[*place] as usize]);
                a.total_cmp(&b)
            });
            part.swap(0, most.unwrap_or(0));
            let numbers = || part.iter().map(|f| *f as usize);
            let storage = numbers().map(|f| fluid.storage(&faces[f], 0.0)).sum();
            let conductance = numbers().map(|f| leaving[f]).fold(0.0, f64::max);
            Self {
                faces: part,
                conductance,
                storage,
            }
        };
        parts.filter(|part| part.len() > 1).map(of).collect()
    }
}

impl Balance<'_> {
    /// The reservoirs whose first face has the balance of the whole as its row, `Σ_f R_f`: what flows from face to face cancels in it, and
    /// a storage of which rounding leaves nothing in the rows of single faces is all that is left.
    pub(super) fn drowned<'s>(
        &'s self,
        states: &'s [ContactState],
        step: &'s FlowStep,
    ) -> impl Iterator<Item = &'s Reservoir> {
        let is_drowned = |part: &&Reservoir| {
            let mut wells = step.wells_in(&self.fluid().wells, &part.faces);
            step.dt * part.conductance > DROWNED * part.storage
                && is_closed(&part.faces, states)
                && wells.all(|(_, well)| well.control != Control::Limit)
        };
        self.reservoirs.iter().filter(is_drowned)
    }

    /// The balance of a closed part at these pressures.
    pub(super) fn whole(&self, part: &Reservoir, p: &[f64], step: &FlowStep) -> Whole {
        let mut whole = Whole {
            residual: 0.0,
            size: 0.0,
            rounding: 0.0,
        };
        let mut add = |volume: f64| {
            whole.residual += volume;
            whole.size += volume.abs();
        };
        for f in part.faces.iter().map(|f| *f as usize) {
            let [opening, compression] = self.taken(f, 0.0, p[f], step);
            let terms = [opening, compression, -step.injected[f]];
            terms.into_iter().for_each(&mut add);
        }
        let wells = step.wells_in(&self.fluid().wells, &part.faces);
        wells.for_each(|(_, well)| add(-step.dt * well.inflow()));
        let rounded = |f: usize| {
            let before = self.pressed(f, step.aperture[f], step.pressure[f].abs());
            self.pressed(f, 0.0, p[f].abs()) + before
        };
        let rounded = part.faces.iter().map(|f| rounded(*f as usize));
        whole.rounding = whole.size + rounded.sum::<f64>();
        whole
    }
}
