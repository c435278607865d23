//! The equilibrium of a body with a crack.

use fracas::contact::ContactState;
use fracas::nonlinear::{FaceFields, Simulation};
use fracas::scene::Body;
use fracas_solvers::Observer;

/// A body in equilibrium under its loads.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Displacement unknowns.
    pub n_u: usize,
    /// What the faces show.
    pub fields: FaceFields,
    /// Faces in stick, new-slip, slip, open.
    pub faces: [usize; 4],
    /// Rounds of the active set, Newton steps, Krylov iterations.
    pub iterations: [usize; 3],
}

impl Answer {
    /// All three cycles, from the unloaded body to the loads of time 0.
    ///
    /// # Errors
    /// A fracture without friction, or a step that fails.
    pub fn of(body: &Body, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let mut simulation = Simulation::new(body)?;
        let mut iterations = [0; 3];
        let mut faces = [0; 4];
        let state = simulation.run(observer, |_, _, accepted| {
            let record = &accepted.record;
            let more = [record.active_it, record.newton_it, record.lin_it];
            iterations.iter_mut().zip(more).for_each(|(n, m)| *n += m);
            faces = record.faces;
        })?;
        Ok(Self {
            n_u: state.u.len(),
            fields: simulation.face_fields(&state),
            faces,
            iterations,
        })
    }

    /// Faces in one state.
    pub fn count(&self, state: ContactState) -> usize {
        self.faces[usize::from(state.code())]
    }
}
