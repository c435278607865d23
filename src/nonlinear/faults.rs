//! What every fracture did in a step: rows of `fault.csv`.

use super::{Simulation, State};
use crate::contact::ContactState;
use crate::mesh::FractureFace;

/// A fracture at the end of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultRecord {
    /// Its name.
    pub name: String,
    /// Area of faces in slip [m²].
    pub slipping_area: f64,
    /// Mean of ‖γ‖ over its area [m].
    pub slip_mean: f64,
    /// Largest ‖γ‖ [m].
    pub slip_max: f64,
    /// ∫ t_N [N].
    pub normal_force: f64,
    /// ‖∫ t_T‖, summed as vectors [N].
    pub shear_force: f64,
    /// Seismic moment so far, ∫ G ‖γ‖ with the mean of G on both sides [N m].
    pub moment: f64,
    /// Largest χ of its faces. Unit: 1.
    pub chi_max: f64,
    /// Area of open faces [m²].
    pub open_area: f64,
    /// Largest g_N of open faces [m].
    pub aperture_max: f64,
    /// Moment of the step, ∫ G ‖Δγ‖: slip that goes back counts, too [N m].
    pub moment_step: f64,
    /// What the rock releases to it in the step, `Σ A_f t·Δg` by the trapezoidal rule [J].
    pub released: f64,
    /// What friction dissipates of that, `Σ A_f t_T·Δγ` [J].
    pub dissipated: f64,
    /// Mean of the path of its slip, ∫ ‖dγ‖, over its area [m]; 0 where no friction follows it.
    pub path_mean: f64,
    /// Longest path of the slip of a face [m].
    pub path_max: f64,
}

impl Simulation<'_> {
    /// Every fracture over the step from `before` to `after`.
    pub fn faults(&self, before: &State, after: &State) -> Vec<FaultRecord> {
        let problem = self.problem();
        let body = problem.body();
        let fields = self.face_fields(after);
        let load = problem.loads().at(before.time, before.loaded);
        let from = problem.jumps(&before.u, &load);
        let names = body.fractures.names.iter().cloned();
        let mut records: Vec<FaultRecord> = names
            .map(|name| FaultRecord {
                name,
                ..FaultRecord::default()
            })
            .collect();
        let mut sums = vec![([0.0; 3], 0.0); records.len()];
        let shear = |face: &FractureFace| {
            let of = |e: u32| body.materials[usize::from(body.mesh.regions[e as usize])].shear();
            0.5 * (of(face.minus.element) + of(face.plus.element))
        };
        let dissipated = self.slip_work(before, after);
        for ((f, face), dissipated) in problem.faces().iter().enumerate().zip(dissipated) {
            let fracture = usize::from(face.fracture);
            let (record, (force, area)) = (&mut records[fracture], &mut sums[fracture]);
            let slip = |s: &State, k: usize| s.slip[2 * f + k];
            let moved = [0, 1].map(|k| slip(after, k) - slip(before, k));
            *area += face.area;
            match after.states[f] {
                ContactState::NewSlip | ContactState::Slip => record.slipping_area += face.area,
                ContactState::Open => {
                    record.open_area += face.area;
                    record.aperture_max = record.aperture_max.max(fields.aperture[f]);
                }
                ContactState::Stick => {}
            }
            record.slip_mean += face.area * fields.slip[f];
            record.slip_max = record.slip_max.max(fields.slip[f]);
            let path = fields.path.get(f).copied().unwrap_or(0.0);
            record.path_mean += face.area * path;
            record.path_max = record.path_max.max(path);
            record.chi_max = record.chi_max.max(fields.criticality[f]);
            record.moment += face.area * shear(face) * fields.slip[f];
            record.moment_step += face.area * shear(face) * moved[0].hypot(moved[1]);
            record.normal_force += face.area * after.t[3 * f];
            for (i, total) in force.iter_mut().enumerate() {
                let along = |k: usize| after.t[3 * f + k] * face.frame[k][i];
                *total += face.area * (along(1) + along(2));
            }
            for k in 0..3 {
                let mean = 0.5 * (before.t[3 * f + k] + after.t[3 * f + k]);
                record.released += face.area * mean * (fields.jump[3 * f + k] - from[3 * f + k]);
            }
            record.dissipated += dissipated;
        }
        for (record, (force, area)) in records.iter_mut().zip(sums) {
            record.shear_force = force[0].hypot(force[1]).hypot(force[2]);
            let area = if area > 0.0 { area } else { 1.0 };
            record.slip_mean /= area;
            record.path_mean /= area;
        }
        records
    }
}
