//! What a step begins from, and what pushes on the body.

use super::ContactProblem;

/// What pushes on the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Load {
    /// Forces on the free displacements [N].
    pub force: Vec<f64>,
    /// Jumps of prescribed displacements and initial gaps, (n, t1, t2) per face, weighted by area [m³].
    pub jump: Vec<f64>,
}

/// Where slip and incremental tractions are counted from.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Mean jump (n, t1, t2) per face [m].
    pub jump: Vec<f64>,
    /// Slip (γ_1, γ_2) per face, what weakening follows [m].
    pub slip: Vec<f64>,
    /// Path of the slip per face, `∫ ‖dγ‖` [m]; empty where no friction follows it.
    pub path: Vec<f64>,
    /// Tractions that H does not act on [Pa]: t_T at the start of the step, and t_N of the initial stress and of what the pressure of the
    /// fluid has changed.
    pub t: Vec<f64>,
    /// Faces that opened and closed again within the step, which have lost their cohesion for the rest of it; empty where there are
    /// none.
    pub torn: Vec<bool>,
    /// Slip per face at which the limits of weakening faces stay [m]; empty where they follow it.
    pub limits_at: Vec<f64>,
}

impl ContactProblem<'_> {
    /// Where nothing has happened yet.
    pub fn at_rest(&self) -> Start {
        let faces = self.faces().len();
        Start {
            jump: vec![0.0; 3 * faces],
            slip: vec![0.0; 2 * faces],
            path: self.no_path(),
            t: vec![0.0; 3 * faces],
            torn: Vec::new(),
            limits_at: Vec::new(),
        }
    }
}

impl Start {
    /// True for a face that opened and closed again within the step.
    pub fn is_torn(&self, face: usize) -> bool {
        self.torn.get(face).copied().unwrap_or(false)
    }
}
