//! Everything that a step starts from.

use super::{CreepState, Onsets, Simulation};
use crate::contact::ContactState;
use fracas_operators::Fields;
use fracas_solvers::saddle::Block;

/// What a preconditioner was built for; all that building it again needs beside the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// State per face.
    pub states: Vec<ContactState>,
    /// C per face, tractions in the balanced unit.
    pub c: Vec<Block>,
}

/// A body between two steps; with the scene it is all that a restart needs.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Accepted steps: 0 before the equilibrium at time 0, 1 after it.
    pub step: usize,
    /// Time reached [s].
    pub time: f64,
    /// Share of the loads of time 0 that is applied: 0 at the very start, 1 from the equilibrium at time 0 on.
    pub loaded: f64,
    /// Increment that the next step tries: time [s], or a share of the loads of time 0 while `loaded < 1`.
    pub next: f64,
    /// Largest force that loads or tractions had so far, ‖·‖₂ [N]; residuals are relative to it.
    pub force: f64,
    /// Largest traction that a face had so far, rounds of the active set included [Pa]; states are judged relative to it.
    pub traction: f64,
    /// Largest norm of every field so far, in which errors are judged
    /// ([`EnergyNorms::solution`](fracas_solvers::saddle::EnergyNorms::solution)) [√J].
    pub size: Fields<f64>,
    /// Krylov iterations per digit of the first linear system of the run, 0 before it; others are judged against it.
    pub krylov: f64,
    /// What the preconditioner beside the all-stick one was built for, if there is one to keep.
    pub prepared: Option<Prepared>,
    /// Free displacements [m].
    pub u: Vec<f64>,
    /// Tractions (t_N, t_1, t_2) per face [Pa].
    pub t: Vec<f64>,
    /// Fluid pressure per face [Pa]; empty where the scene has no fluid.
    pub p: Vec<f64>,
    /// State per face.
    pub states: Vec<ContactState>,
    /// Slip (γ_1, γ_2) per face: `Σ Δg_T` over the steps that it ended in slip or open [m].
    ///
    /// In stick γ stays as it is, whatever H lets through; the rest of the jump, g_T − γ, is no slip.
    pub slip: Vec<f64>,
    /// Path of the slip per face, the sum of ‖Δg_T‖ over these steps [m]; empty where no friction follows it.
    pub path: Vec<f64>,
    /// What rock that creeps remembers, where any does.
    pub creep: Option<Box<CreepState>>,
    /// Faces at whose sides the initial stress pulls nothing beyond its mean on them: those that are open, but for such that would close
    /// without the pull.
    pub released: Vec<bool>,
    /// Faces whose cohesion was lost to the end of the step: no states were found with it.
    pub torn: Vec<bool>,
    /// How often a face has ended a step in another state than the step before.
    pub flips: Vec<u32>,
    /// When slip began, where the scene looks for it.
    pub onsets: Option<Box<Onsets>>,
}

impl Simulation<'_> {
    /// The unloaded body: closed faces in stick, those with a gap open.
    pub fn initial_state(&self) -> State {
        let faces = self.problem.faces();
        let gaps = &self.problem.body().gaps;
        let open = |f: &crate::mesh::FractureFace| match gaps[usize::from(f.fracture)] > 0.0 {
            true => ContactState::Open,
            false => ContactState::Stick,
        };
        State {
            step: 0,
            time: 0.0,
            loaded: 0.0,
            next: 1.0,
            force: 0.0,
            traction: 0.0,
            size: self.problem.nothing(),
            krylov: 0.0,
            prepared: None,
            u: vec![0.0; self.problem.body().constraints.free_len()],
            t: vec![0.0; 3 * faces.len()],
            p: self.problem.initial_pressures(0.0),
            states: faces.iter().map(open).collect(),
            slip: vec![0.0; 2 * faces.len()],
            path: self.problem.no_path(),
            creep: self.problem.uncrept(),
            released: vec![false; faces.len()],
            torn: vec![false; faces.len()],
            flips: vec![0; faces.len()],
            onsets: None,
        }
    }
}
