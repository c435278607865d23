//! What a step reports.

use super::{Instability, SlipOnset, State};
use crate::contact::ContactState;
use crate::flow::{FlowRecord, WellRecord};
use fracas_operators::Fields;

/// An accepted step: a line of `history.csv`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepRecord {
    /// Its number; 0 is the equilibrium at time 0.
    pub step: usize,
    /// Time at its end [s].
    pub time: f64,
    /// Its length [s]; 0 while the loads of time 0 are applied.
    pub dt: f64,
    /// Rounds of the active set, failed attempts included.
    pub active_it: usize,
    /// Newton steps, failed attempts included.
    pub newton_it: usize,
    /// Krylov iterations, failed attempts included.
    pub lin_it: usize,
    /// Largest relative residual that a linear solve of the accepted attempt was left with.
    pub lin_res: f64,
    /// Faces in stick, new-slip, slip, open.
    pub faces: [usize; 4],
    /// Area of faces in another state than at the start [m²].
    pub changed_area: f64,
    /// Largest overlap against the state of a face [m]: of open faces; with springs of all.
    pub max_pen: f64,
    /// Largest shear traction of a closed face beyond its limit [Pa].
    pub max_tau_viol: f64,
    /// Largest distance of the shear traction of a slipping face from the one that Coulomb's law gives for its slip, over the largest
    /// traction of the run, or the one that would close the largest gap: what slip against the traction is worth. At most
    /// `state_tolerance`. Unit: 1.
    pub max_slip_viol: f64,
    /// Errors of the fields at its states, each relative to the largest norm so far, as the preconditioner shows them
    /// ([`EnergyNorms`](fracas_solvers::saddle::EnergyNorms)); NaN where residuals alone are judged. Unit: 1.
    pub error: Fields<f64>,
    /// Largest slip ‖γ‖ of a face [m].
    pub slip_max: f64,
    /// Largest part of a jump that is neither slip nor opening [m].
    pub h_jump: f64,
    /// Largest overlap of closed faces, which H leaves [m].
    pub h_overlap: f64,
    /// Slip ran away in it: its state is the one in which it came to rest, without inertia.
    pub arrested: bool,
    /// Halvings that it took.
    pub cuts: usize,
    /// Preconditioners built from nothing.
    pub setups: usize,
    /// Linear systems solved with one that was there.
    pub reuses: usize,
}

/// A linear solve: a line of `solver.csv`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearRecord {
    /// Step that it belongs to.
    pub step: usize,
    /// Attempt at that step, from 0.
    pub attempt: usize,
    /// Round of the active set, from 0.
    pub active: usize,
    /// Newton step of that round, from 0.
    pub newton: usize,
    /// Faces in stick, new-slip, slip, open.
    pub faces: [usize; 4],
    /// Method.
    pub krylov: &'static str,
    /// Its iterations.
    pub iterations: usize,
    /// Asked relative residual.
    pub tolerance: f64,
    /// True relative residual reached.
    pub relative_residual: f64,
    /// Residual of the non-linear equations before, relative to loads and internal forces.
    pub residual: f64,
    /// Share of the Newton correction taken by the line search.
    pub step_length: f64,
    /// True if a preconditioner was built for it.
    pub setup: bool,
}

/// Decimal digits by which the residual of a solution is smaller than its right-hand side, no more than f64 holds.
pub fn digits_of(relative_residual: f64) -> f64 {
    -relative_residual.max(f64::EPSILON).log10()
}

/// Something worth telling.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// States returned to an earlier round.
    Cycle {
        /// Round in which they did.
        round: usize,
        /// Rounds until they repeat.
        period: usize,
        /// Faces that differ within the cycle.
        faces: Vec<usize>,
    },
    /// Newton failed at fixed states: Newton on the natural map of all faces takes over.
    Projection {
        /// Round in which it did.
        round: usize,
        /// Why it failed.
        reason: String,
    },
    /// H acts on more than the states constrain, or the stabilization of pressures on more than open faces: with that of the states
    /// themselves they do not settle.
    Stabilized {
        /// Number of faces that one acts on beyond their state.
        faces: usize,
    },
    /// H acts on less than the states constrain: with all of theirs they return, open with an overlap and closed in tension.
    Unstabilized {
        /// Number of faces whose rows of H have less.
        faces: usize,
    },
    /// Rounding leaves errors above `tolerance`, below `state_tolerance`.
    Rounding {
        /// What has the larger one: `displacements` or `tractions`.
        part: &'static str,
        /// That error, relative.
        error: f64,
    },
    /// Faces opened and closed again within the step: they have no cohesion until its end.
    Torn {
        /// Which.
        faces: Vec<usize>,
    },
    /// Pressures that are given were too far from those of the fluid at the start of the step: they were raised in parts.
    Raised {
        /// In how many.
        parts: usize,
        /// Why the step failed at once.
        reason: String,
    },
    /// Slip ran away; the step goes to where it came to rest.
    Arrested {
        /// What ran away.
        patch: Box<Instability>,
    },
    /// The step starts once more with every face in stick.
    Retry {
        /// Why the attempt before failed.
        reason: String,
    },
    /// The step is halved.
    Cut {
        /// Why the attempt before failed.
        reason: String,
        /// New increment: time [s] or share of the loads of time 0.
        next: f64,
    },
    /// It is known when slip begins on a fracture.
    Onset {
        /// The name of the fracture.
        fracture: String,
        /// When and where.
        onset: Box<SlipOnset>,
    },
    /// A preconditioner is in f64 although f32 was asked for.
    Precision {
        /// What f32 would lose.
        reason: String,
    },
    /// An inner solver that nobody asked for by name could not be set up, or got nowhere, and another took its place.
    Inner {
        /// Why it was given up.
        reason: String,
        /// The other: `geometric`, `amg` or `exact`.
        now: &'static str,
    },
    /// Whether slip runs away at the states of the step could not be computed; the step itself is solved and accepted.
    Unknown {
        /// Why it could not.
        reason: String,
    },
    /// A preconditioner was built.
    Setup {
        /// States that it was built for: stick, new-slip, slip, open.
        faces: [usize; 4],
    },
}

/// A step that is done.
#[derive(Clone, Debug)]
pub struct Accepted {
    /// The body after it.
    pub state: State,
    /// Its line of `history.csv`.
    pub record: StepRecord,
    /// Its line of `flow.csv`, where the scene has a fluid and time passed.
    pub flow: Option<FlowRecord>,
    /// What wells did, where the scene has any and time passed.
    pub wells: Vec<WellRecord>,
    /// Its linear solves, failed attempts included.
    pub linear: Vec<LinearRecord>,
    /// What happened on the way.
    pub events: Vec<Event>,
}

/// Faces in stick, new-slip, slip, open.
pub(super) fn count(states: &[ContactState]) -> [usize; 4] {
    let mut faces = [0; 4];
    for state in states {
        faces[usize::from(state.code())] += 1;
    }
    faces
}
