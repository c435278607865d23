//! Loads as sums of cases, one per history.

use super::Load;
use crate::contact::{ContactState, prescribed_jump};
use crate::elasticity::{Constraints, ElasticityError, lift, loads};
use crate::mesh::FractureFace;
use crate::scene::{Body, Latest};
use fracas_operators::LinearOperator;
use fracas_operators::vector::axpy;

/// What follows one history, at its factor 1.
struct Case {
    history: usize,
    /// `f_f − A_fc u_c` [N].
    force: Vec<f64>,
    /// `B_cᵀ u_c`, weighted by area, where displacements are prescribed [m³].
    jump: Option<Vec<f64>>,
}

/// `load(time) = Σ_k h_k(time) case_k`: the body is linear in its loads, so A_fc is multiplied once per history. What pore pressures do that
/// differ from element to element, and pressures of fractures that follow them, is added at each time.
pub struct Loads<'a> {
    body: &'a Body,
    cases: Vec<Case>,
    /// Initial opening of the faces, weighted by area [m³].
    gap: Vec<f64>,
    /// Faces that the initial stress pulls beyond its mean on them, and [what it pulls](loads::pull_beyond_mean) [N].
    pulled: Vec<(usize, [[f64; 3]; 4])>,
    /// Forces of what is no case at the ends of a step [N], which asks for the same ones again.
    drained: Latest,
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
        let mut gap = vec![0.0; 3 * body.fractures.faces.len()];
        for (g, face) in gap.chunks_exact_mut(3).zip(&body.fractures.faces) {
            g[0] = face.area * body.gaps[usize::from(face.fracture)];
        }
        let drained = Latest::default();
        if Self::has_drained(body) {
            // an inverted element is found here
            let at_first = drained_forces(body, 0.0)?;
            drained.at(0.0, || at_first);
        }
        let faces = body.fractures.faces.iter().enumerate();
        let faces = faces.filter(|_| body.initial_stress.is_some());
        let pulled = faces
            .map(|(f, face)| (f, body.pull_beyond_mean(face)))
            .filter(|(_, corners)| corners.iter().flatten().any(|f| *f != 0.0))
            .collect();
        Ok(Self {
            body,
            cases: cases(body, full)?,
            gap,
            pulled,
            drained,
        })
    }

    /// The same where the stiffness over all displacements is another one.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub(super) fn follow(&mut self, full: &dyn LinearOperator<f64>) -> Result<(), ElasticityError> {
        self.cases = cases(self.body, full)?;
        Ok(())
    }

    /// Whether there is anything that is no case.
    fn has_drained(body: &Body) -> bool {
        !body.pore_fields.is_empty() || body.pressures_from.iter().any(Option::is_some)
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
        if Self::has_drained(self.body) {
            let drained = self.drained.at(time, || {
                let all = drained_forces(self.body, time);
                all.unwrap_or_else(|_| unreachable!("looked at by `new`"))
            });
            axpy(share, &drained, &mut force);
        }
        Load { force, jump }
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

/// What follows the histories of a body; `full` is its stiffness over all displacements.
fn cases(body: &Body, full: &dyn LinearOperator<f64>) -> Result<Vec<Case>, ElasticityError> {
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
    Ok(cases)
}

/// Forces at a time [s] of what is no case, on the free displacements [N].
fn drained_forces(body: &Body, time: f64) -> Result<Vec<f64>, ElasticityError> {
    let all = body.drained_forces(time)?.unwrap_or_default();
    let free = body.constraints.free();
    Ok(free.iter().map(|dof| all[*dof as usize]).collect())
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
