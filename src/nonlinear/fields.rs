//! What fracture faces show: fields of files and of reports.

use super::{ContactProblem, Simulation, State};
use crate::contact::ContactState;
use crate::mesh::FractureFace;
use crate::scene::Body;
use fracas_operators::vector::axpy;

/// Shear that counts as none, relative to the largest traction. Unit: 1.
const NOISE: f64 = 1e-9;

/// Fields per face, in the order of the faces; vectors are (n, t1, t2).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceFields {
    /// Contact traction, three per face [Pa].
    pub traction: Vec<f64>,
    /// Jump u⁺ − u⁻ (initial gap included), three per face [m].
    pub jump: Vec<f64>,
    /// ‖γ‖: what the face did in slip and while open [m].
    pub slip: Vec<f64>,
    /// ∫ ‖dγ‖ [m]; empty where no friction follows it.
    pub path: Vec<f64>,
    /// The part of the jump that is neither slip nor opening, three per face: g_N of closed faces and g_T − γ [m].
    ///
    /// It is what H (or a spring) lets through where the continuum lets nothing: an estimate of the discretization error.
    pub stabilization_jump: Vec<f64>,
    /// g_N of open faces, 0 of closed ones [m].
    pub aperture: Vec<f64>,
    /// χ = ‖t_T‖/τ_L: 1 in slip, 0 where open and where the shear is noise.
    pub criticality: Vec<f64>,
    /// τ_L [Pa].
    pub tau_limit: Vec<f64>,
    /// Fluid pressure [Pa].
    pub pressure: Vec<f64>,
    /// C_f [m³]; empty where the scene has no fluid.
    pub conductivity: Vec<f64>,
    /// Flow per width, x y z per face [m²/s]; empty where the scene has no fluid.
    pub flux: Vec<f64>,
}

impl FaceFields {
    /// The fields at states, faces without their cohesion, tractions t, slip γ and its path, jumps and fluid pressures per face.
    pub(super) fn new(
        problem: &ContactProblem<'_>,
        (states, torn): (&[ContactState], &[bool]),
        [t, slip, path]: [&[f64]; 3],
        jump: Vec<f64>,
        pressure: Vec<f64>,
    ) -> Self {
        let largest = t.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let mut fields = Self {
            traction: t.to_vec(),
            path: path.to_vec(),
            pressure,
            ..Self::default()
        };
        for (f, state) in states.iter().enumerate() {
            let i = 3 * f;
            let gamma = [slip[2 * f], slip[2 * f + 1]];
            let so_far = problem.slipped(f, [slip, path]).slip();
            let shear = t[i + 1].hypot(t[i + 2]);
            // an open face carries no shear and has no limit
            let limit = match state {
                ContactState::Open => 0.0,
                _ if torn[f] => problem.friction(f).torn().limit(t[i], so_far).max(0.0),
                _ => problem.friction(f).limit(t[i], so_far).max(0.0),
            };
            let open = *state == ContactState::Open;
            fields.slip.push(gamma[0].hypot(gamma[1]));
            fields.stabilization_jump.extend([
                if open { 0.0 } else { jump[i] },
                jump[i + 1] - gamma[0],
                jump[i + 2] - gamma[1],
            ]);
            fields
                .aperture
                .push(if open { jump[i].max(0.0) } else { 0.0 });
            fields.tau_limit.push(limit);
            fields.criticality.push(match state {
                ContactState::Open => 0.0,
                ContactState::NewSlip | ContactState::Slip => 1.0,
                ContactState::Stick if shear <= NOISE * largest => 0.0,
                // no limit at all, and a shear that is more than noise
                ContactState::Stick if limit <= 0.0 => 1.0,
                ContactState::Stick => shear / limit,
            });
        }
        fields.jump = jump;
        fields
    }
}

/// γ at the end of a step: `γ + Δg_T` of faces that ended it in slip or open, γ of those in stick.
///
/// A face may end in slip with its shear below the limit by as much as faces are judged to; it has then gone against its traction, by no
/// more than the compliance makes of that. The part along the traction is no slip, as friction gives no energy: it stays with the rest of
/// the jump, as that of a face in stick does.
///
/// # Shape
/// γ: two per face; jumps from, and jumps to less what H lets through on the way to slip: three per face; tractions: three per face.
pub(super) fn slip_after(
    gamma: &[f64],
    [from, to, t]: [&[f64]; 3],
    (states, compliance): (&[ContactState], &[f64]),
) -> Vec<f64> {
    let moved = |(f, state): (usize, &ContactState)| {
        let moved = [1, 2].map(|k| to[3 * f + k] - from[3 * f + k]);
        let t = [1, 2].map(|k| t[3 * f + k]);
        let along = t[0] * moved[0] + t[1] * moved[1];
        match state {
            ContactState::Stick => [0.0; 2],
            // beyond ω ‖t‖ the traction is what is left of none
            ContactState::NewSlip | ContactState::Slip
                if along < 0.0 && -along <= compliance[f] * (t[0] * t[0] + t[1] * t[1]) =>
            {
                // what is left lies across t
                let across = (t[0] * moved[1] - t[1] * moved[0]) / (t[0] * t[0] + t[1] * t[1]);
                [-across * t[1], across * t[0]]
            }
            ContactState::NewSlip | ContactState::Slip | ContactState::Open => moved,
        }
    };
    let moved = states.iter().enumerate().flat_map(moved);
    gamma
        .iter()
        .zip(moved)
        .map(|(g, moved)| g + moved)
        .collect()
}

/// ∫ ‖dγ‖ at the end of a step that has changed γ; empty where it is not followed.
pub(super) fn path_after(path: &[f64], [before, after]: [&[f64]; 2]) -> Vec<f64> {
    let moved = |f: usize, k: usize| after[2 * f + k] - before[2 * f + k];
    let path = path.iter().enumerate();
    path.map(|(f, path)| path + moved(f, 0).hypot(moved(f, 1)))
        .collect()
}

/// Pressure that the scene gives in every face at a time [s], where `loaded` of the loads of time 0 is there [Pa].
pub(super) fn given_pressures(body: &Body, time: f64, loaded: f64) -> Vec<f64> {
    let given = |face: &FractureFace| {
        let history = body.pressures[usize::from(face.fracture)].1;
        loaded * body.pressure_of(face) * body.histories[history].at(time)
    };
    let mut all: Vec<f64> = body.fractures.faces.iter().map(given).collect();
    if let Some(of_sides) = body.pressures_of_sides(time) {
        axpy(loaded, &of_sides, &mut all);
    }
    all
}

impl Simulation<'_> {
    /// What the fracture faces show in a state.
    pub fn face_fields(&self, state: &State) -> FaceFields {
        let load = self.problem().loads().at(state.time, state.loaded);
        let jumps = self.problem().jumps(&state.u, &load);
        let (conductivity, flux) = self.flow_fields(state, &jumps);
        FaceFields {
            conductivity,
            flux,
            ..FaceFields::new(
                self.problem(),
                (&state.states, &state.torn),
                [&state.t, &state.slip, &state.path],
                jumps,
                self.pressures(state),
            )
        }
    }

    /// Fluid pressure per face [Pa].
    pub(super) fn pressures(&self, state: &State) -> Vec<f64> {
        if !state.p.is_empty() {
            return state.p.clone();
        }
        let body = self.problem().body();
        given_pressures(body, state.time, state.loaded)
    }

    /// Displacements of all nodes in a state, `3·node + component` [m].
    pub fn displacement(&self, state: &State) -> Vec<f64> {
        let loads = self.problem().loads();
        loads
            .prescribed_at(state.time, state.loaded)
            .expand(&state.u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ContactState::{Open, Slip, Stick};

    #[test]
    fn slip_against_its_traction_keeps_what_lies_across_it() {
        let t = [-1.0, 3.0, 4.0];
        let after = |moved: [f64; 2], state: ContactState| {
            let to = [0.0, 2.0 + moved[0], -1.0 + moved[1]];
            slip_after(
                &[0.5, 0.5],
                [&[0.0, 2.0, -1.0], &to, &t],
                (&[state], &[1.0]),
            )
        };
        assert_eq!(after([0.25, 0.5], Slip), [0.75, 1.0]);
        assert_eq!(after([-0.25, -0.5], Open), [0.25, 0.0]);
        assert_eq!(after([0.25, 0.5], Stick), [0.5, 0.5]);
        // (−3, −4)/4 + (−4, 3)/8
        let across = after([-1.25, -0.625], Slip);
        assert_eq!(across, [0.0, 0.875]);
    }
}
