//! What fracture faces show: fields of files and of reports.

use super::{ContactProblem, Load};
use crate::contact::ContactState;

/// Shear that counts as none, relative to the largest traction. Unit: 1.
const NOISE: f64 = 1e-9;

/// Fields per face, in the order of the faces; vectors are (n, t1, t2).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceFields {
    /// Contact traction, three per face [Pa].
    pub traction: Vec<f64>,
    /// Jump u⁺ − u⁻ (initial gap included), three per face [m].
    pub jump: Vec<f64>,
    /// ‖g_T‖ [m].
    pub slip: Vec<f64>,
    /// g_N of open faces, 0 of closed ones [m].
    pub aperture: Vec<f64>,
    /// χ = ‖t_T‖/τ_L: 1 in slip, 0 where open and where the shear is noise.
    pub criticality: Vec<f64>,
    /// τ_L [Pa].
    pub tau_limit: Vec<f64>,
    /// Fluid pressure [Pa].
    pub pressure: Vec<f64>,
}

impl FaceFields {
    /// The fields at displacements u, tractions t and fluid pressures p per face.
    pub(super) fn new(
        problem: &ContactProblem<'_>,
        states: &[ContactState],
        [u, t]: [&[f64]; 2],
        load: &Load,
        pressure: Vec<f64>,
    ) -> Self {
        let jump = problem.jumps(u, load);
        let largest = t.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let mut fields = Self {
            traction: t.to_vec(),
            pressure,
            ..Self::default()
        };
        for (f, state) in states.iter().enumerate() {
            let i = 3 * f;
            let slip = jump[i + 1].hypot(jump[i + 2]);
            let shear = t[i + 1].hypot(t[i + 2]);
            // an open face carries no shear and has no limit
            let limit = match state {
                ContactState::Open => 0.0,
                _ => problem.friction(f).limit(t[i], slip).max(0.0),
            };
            let open = *state == ContactState::Open;
            fields.slip.push(slip);
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
