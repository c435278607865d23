//! Loads as sums of cases, one per history.

use super::Load;
use crate::contact::{ContactState, prescribed_jump};
use crate::elasticity::{Constraints, ElasticityError, lift, loads};
use crate::mesh::FractureFace;
use crate::scene::Body;
use fracas_operators::LinearOperator;
use fracas_operators::vector::axpy;
use std::sync::{Mutex, PoisonError};

/// What follows one history, at its factor 1.
struct Case {
    history: usize,
    /// `f_f − A_fc u_c` [N].
    force: Vec<f64>,
    /// `B_cᵀ u_c`, weighted by area, where displacements are prescribed [m³].
    jump: Option<Vec<f64>>,
}

/// `load(time) = Σ_k h_k(time) case_k`: the body is linear in its loads, so A_fc is multiplied once per history. What pore pressures do that
/// differ from element to element is added at each time.
pub struct Loads<'a> {
    body: &'a Body,
    cases: Vec<Case>,
    /// Initial opening of the faces, weighted by area [m³].
    gap: Vec<f64>,
    /// Faces that the initial stress pulls beyond its mean on them, and [what it pulls](loads::pull_beyond_mean) [N].
    pulled: Vec<(usize, [[f64; 3]; 4])>,
    /// The last time, and the forces of pore pressures that differ from element to element then [N]: a step asks for the same ones again.
    drained: Mutex<Option<(f64, Vec<f64>)>>,
}

/// Which of the faces that the initial stress pulls beyond its mean are taken as open: nothing pulls at their sides.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Opened(Vec<bool>);

/// Times that a face opens or closes within a step, from which on the initial stress pulls at it whether it is open or not: with the pull
/// it would open, and without it close. Unit: 1.
const TURNS: u8 = 2;

impl Opened {
    /// Becomes those that are open `now`; true where that changes any. `turned` counts how often each has.
    pub(super) fn follow(&mut self, now: &Self, turned: &mut Vec<u8>) -> bool {
        turned.resize(self.0.len(), 0);
        let mut changed = false;
        for ((own, now), turned) in self.0.iter_mut().zip(&now.0).zip(turned) {
            if own == now || *turned >= TURNS {
                continue;
            }
            *turned += 1;
            let next = *now && *turned < TURNS;
            changed |= next != *own;
            *own = next;
        }
        changed
    }
}

impl<'a> Loads<'a> {
    /// The cases of a body; `full` is its stiffness over all displacements.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub fn new(body: &'a Body, full: &dyn LinearOperator<f64>) -> Result<Self, ElasticityError> {
        let mut cases = Vec::new();
        for history in 0..body.histories.len() {
            let force = body.forces_of(history)?;
            let constraints = prescribed(body, |h| f64::from(u8::from(h == history)));
            let mut free: Vec<f64> = constraints
                .free()
                .iter()
                .map(|dof| force[*dof as usize])
                .collect();
            let moved = constraints.is_displaced();
            if moved {
                lift(full, &constraints, &mut free);
            }
            if moved || free.iter().any(|f| *f != 0.0) {
                cases.push(Case {
                    history,
                    force: free,
                    jump: moved.then(|| prescribed_jump(&body.fractures, &constraints)),
                });
            }
        }
        let mut gap = vec![0.0; 3 * body.fractures.faces.len()];
        for (g, face) in gap.chunks_exact_mut(3).zip(&body.fractures.faces) {
            g[0] = face.area * body.gaps[usize::from(face.fracture)];
        }
        // an inverted element is found here
        body.drained_forces(0.0)?;
        let faces = body.fractures.faces.iter().enumerate();
        let faces = faces.filter(|_| body.initial_stress.is_some());
        let pulled = faces
            .map(|(f, face)| (f, body.pull_beyond_mean(face)))
            .filter(|(_, corners)| corners.iter().flatten().any(|f| *f != 0.0))
            .collect();
        Ok(Self {
            body,
            cases,
            gap,
            pulled,
            drained: Mutex::default(),
        })
    }

    /// Those that are open in these states.
    pub(super) fn opened(&self, states: &[ContactState]) -> Opened {
        let is_open = |(f, _): &(usize, _)| states[*f] == ContactState::Open;
        Opened(self.pulled.iter().map(is_open).collect())
    }

    /// Those of [`State::released`](super::State::released).
    pub(super) fn released(&self, released: &[bool]) -> Opened {
        Opened(self.pulled.iter().map(|(f, _)| released[*f]).collect())
    }

    /// The same for every face.
    pub(super) fn by_face(&self, opened: &Opened) -> Vec<bool> {
        let mut released = vec![false; self.body.fractures.faces.len()];
        for ((f, _), open) in self.pulled.iter().zip(&opened.0) {
            released[*f] = *open;
        }
        released
    }

    /// [`at`](Self::at), without what the initial stress pulls at the sides of open faces.
    pub(super) fn beside(&self, opened: &Opened, time: f64, share: f64) -> Load {
        let mut load = self.at(time, share);
        let constraints = &self.body.constraints;
        let open = self.pulled.iter().zip(&opened.0).filter(|(_, open)| **open);
        for ((f, corners), _) in open {
            loads::between_sides(&self.body.fractures.faces[*f], corners, |dof, f| {
                if let Some(i) = constraints.free_index(dof) {
                    load.force[i] -= share * f;
                }
            });
        }
        load
    }

    /// The load at a time [s] of which a share is applied, every face closed.
    pub fn at(&self, time: f64, share: f64) -> Load {
        let mut force = vec![0.0; self.body.constraints.free_len()];
        let mut jump = self.gap.clone();
        for case in &self.cases {
            let factor = share * self.body.histories[case.history].at(time);
            axpy(factor, &case.force, &mut force);
            if let Some(moved) = &case.jump {
                axpy(factor, moved, &mut jump);
            }
        }
        if !self.body.pore_fields.is_empty() {
            self.add_drained(time, share, &mut force);
        }
        Load { force, jump }
    }

    /// Adds a share of the forces of pore pressures that differ from element to element at a time [s].
    fn add_drained(&self, time: f64, share: f64, force: &mut [f64]) {
        let mut known = self.drained.lock().unwrap_or_else(PoisonError::into_inner);
        if known.as_ref().is_none_or(|(of, _)| *of != time) {
            let Ok(all) = self.body.drained_forces(time) else {
                unreachable!("looked at by `new`");
            };
            let free = self.body.constraints.free();
            let all = all.unwrap_or_default();
            *known = Some((time, free.iter().map(|dof| all[*dof as usize]).collect()));
        }
        if let Some((_, drained)) = &*known {
            axpy(share, drained, force);
        }
    }

    /// The same where one of them is not 0.
    pub(super) fn held_at(&self, time: f64, share: f64) -> Option<Constraints> {
        // most bodies have none: nothing is copied
        let moved = self.cases.iter().any(|case| case.jump.is_some());
        let held = moved.then(|| self.prescribed_at(time, share));
        held.filter(Constraints::is_displaced)
    }

    /// Prescribed displacements at a time [s] of which a share is applied.
    pub fn prescribed_at(&self, time: f64, share: f64) -> Constraints {
        prescribed(self.body, |h| share * self.body.histories[h].at(time))
    }
}

/// The constraints with every prescribed displacement times the factor of its history.
fn prescribed(body: &Body, factor: impl Fn(usize) -> f64) -> Constraints {
    let histories = &body.prescribed_histories;
    body.constraints
        .with_values(|i, u| u * factor(histories[i]))
}

/// `R σ0 n` at the centre of every face, R the frame (n, t1, t2), and in t_N the pressure of the fluid before anything flows: what a closed
/// face carries where rock stands still [Pa].
pub(super) fn initial_traction(body: &Body) -> Vec<f64> {
    let of_face = |face: &FractureFace| -> [f64; 3] {
        let pull = body.initial_pull_at(face, face.center, face.frame[0]);
        let mut t = face.frame.map(|e| (0..3).map(|k| e[k] * pull[k]).sum());
        let fluid = body.fluid.as_ref();
        t[0] += fluid.map_or(0.0, |fluid| fluid.initial_pressure(face));
        t
    };
    body.fractures.faces.iter().flat_map(of_face).collect()
}
