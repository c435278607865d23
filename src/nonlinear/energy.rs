//! Work and energy of a step.

use super::{Simulation, State};
use crate::contact::ContactState;
use fracas_operators::LinearOperator;
use fracas_operators::vector::{axpy, dot};

/// Where the work of a step went [J]:
/// ```text
/// error = W_e + W_p − ΔE − W_c − W_v        W_c − W_H − D → 0 as steps are made smaller
/// ```
/// The latter where tractions follow the loads: a face that drops its traction at once, as one that sticks under shear and
/// opens or where weakening runs away, leaves `½ A_f t·Δg` in W_c − D at any step.
///
/// W by the trapezoidal rule, exact for what is linear over the step. E counts from the unloaded body; initial stress and pore
/// pressure are loads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyRecord {
    /// W_e: of all loads and of what moves prescribed displacements, without the fluid in fractures.
    pub external_work: f64,
    /// W_p: of the fluid pressure in fractures, `Σ A_f p Δg_N`.
    pub pressure_work: f64,
    /// E at the end: `½ uᵀA u`.
    pub elastic_energy: f64,
    /// ΔE.
    pub elastic_change: f64,
    /// W_c: that the faces take, `Σ A_f t·Δg`.
    pub contact_work: f64,
    /// W_H: the share of W_c that the jumps of the stabilization take (or those of springs), `Σ A_f (t_N Δg_N + t_T·(Δg_T − Δγ))`
    /// of faces that end closed: stored, `½ ΔtᵀH Δt` while no face changes its state, and given back with the tractions.
    pub stabilization_work: f64,
    /// D: dissipated by friction, `Σ A_f t_T·Δγ` of slipping faces with t_T at the end of the step; no face's share is
    /// negative but for rounding and for tractions that count as none, as slip follows the traction.
    pub dissipation: f64,
    /// W_v: that creep takes, `∫ ½ (s̃ + s̃')·Δε_v dV` of the stresses that come with strain; 0 where nothing creeps.
    pub creep_work: f64,
    /// D_v: that creep dissipates, `∫∫ s:s/(2η) dt dV` of the whole stress on the path of the step, never negative. As steps are made
    /// smaller, `D_v − W_v → ∫ s0:Δε_v dV`, what the initial stress, which is a load, gives beyond its nodal forces.
    pub creep_dissipation: f64,
    /// What the equations were left with: `W_e + W_p − ΔE − W_c − W_v`.
    pub error: f64,
}

/// What of a state its energy depends on.
struct At {
    /// All displacements [m].
    u: Vec<f64>,
    /// A u, with creep `∫ Bᵀ(σ − σ0)` [N].
    internal: Vec<f64>,
    /// Elastic energy [J].
    elastic: f64,
    /// Forces on the free displacements, less A_fc u_c [N].
    force: Vec<f64>,
    /// Jumps of prescribed displacements, weighted by area [m³].
    prescribed: Vec<f64>,
    /// Jumps [m].
    jump: Vec<f64>,
    /// Fluid pressure per face [Pa].
    pressure: Vec<f64>,
}

impl Simulation<'_> {
    /// Work and energy of the step from `before` to `after`.
    ///
    /// # Cost
    /// Three products with A.
    pub fn energy(&self, before: &State, after: &State) -> EnergyRecord {
        let problem = self.problem();
        let (body, a) = (problem.body(), problem.saddle().stiffness().full());
        let mut work = vec![0.0; a.work_len()];
        let mut product = |x: &[f64]| {
            let mut y = vec![0.0; x.len()];
            a.apply_add(1.0, x, &mut y, &mut work);
            y
        };
        let mut at = |state: &State| {
            let u = self.displacement(state);
            let loads = problem.loads();
            let load = loads.beside(&loads.released(&state.released), state.time, state.loaded);
            At {
                internal: product(&u),
                elastic: 0.0,
                jump: problem.jumps(&state.u, &load),
                pressure: self.pressures(state),
                force: match state.p.is_empty() {
                    true => load.force,
                    false => {
                        let mut force = problem.pressure_forces(&state.p, state.loaded);
                        axpy(1.0, &load.force, &mut force);
                        force
                    }
                },
                prescribed: load.jump,
                u,
            }
        };
        let (mut x, mut y) = (at(before), at(after));
        let creep = self.creep_energy([before, after], [&x.u, &y.u]);
        for (at, beyond) in [&mut x, &mut y].into_iter().zip(&creep.force) {
            at.elastic += 0.5 * dot(&at.u, &at.internal);
            if let Some(beyond) = beyond {
                axpy(1.0, beyond, &mut at.internal);
            }
        }
        (x.elastic, y.elastic) = (x.elastic + creep.elastic[0], y.elastic + creep.elastic[1]);
        let moved: Vec<f64> = y.u.iter().zip(&x.u).map(|(y, x)| y - x).collect();
        let trapezoid = |x: &[f64], y: &[f64], by: &[f64]| 0.5 * (dot(x, by) + dot(y, by));

        // W on the free displacements: ½ (f + f') Δu_f, where f = force + A_fc u_c
        let mut held = vec![0.0; moved.len()];
        let mut held_moved = vec![0.0; moved.len()];
        for (dof, _) in body.constraints.prescribed() {
            let i = *dof as usize;
            held[i] = x.u[i] + y.u[i];
            held_moved[i] = moved[i];
        }
        let free = |v: &[f64]| -> Vec<f64> {
            body.constraints
                .free()
                .iter()
                .map(|i| v[*i as usize])
                .collect()
        };
        let moved_free = free(&moved);
        let on_free = trapezoid(&x.force, &y.force, &moved_free)
            + 0.5 * dot(&free(&product(&held)), &moved_free);
        // W on the prescribed ones: ½ (A u + B t)_c Δu_c, twice
        let jumped: Vec<f64> = y
            .prescribed
            .iter()
            .zip(&x.prescribed)
            .map(|(y, x)| y - x)
            .collect();
        let on_held = trapezoid(&x.internal, &y.internal, &held_moved)
            + trapezoid(&before.t, &after.t, &jumped);

        let faces = problem.faces();
        let (mut pressure_work, mut contact_work, mut stabilization_work) = (0.0, 0.0, 0.0);
        for (f, face) in faces.iter().enumerate() {
            let slipped = |k: usize| y.jump[3 * f + k] - x.jump[3 * f + k];
            pressure_work += 0.5 * face.area * (x.pressure[f] + y.pressure[f]) * slipped(0);
            let taken = |k: usize| {
                0.5 * face.area * (before.t[3 * f + k] + after.t[3 * f + k]) * slipped(k)
            };
            let [normal, shear] = [taken(0), taken(1) + taken(2)];
            contact_work += normal + shear;
            stabilization_work += match after.states[f] {
                ContactState::Stick => normal + shear,
                ContactState::NewSlip | ContactState::Slip => normal,
                ContactState::Open => 0.0,
            };
        }
        let (energy, old) = (y.elastic, x.elastic);
        let [creep_work, creep_dissipation] = creep.work;
        let total = on_free + on_held;
        EnergyRecord {
            external_work: total - pressure_work,
            pressure_work,
            elastic_energy: energy,
            elastic_change: energy - old,
            contact_work,
            stabilization_work,
            dissipation: self.slip_work(before, after).sum(),
            creep_work,
            creep_dissipation,
            error: total - (energy - old) - contact_work - creep_work,
        }
    }

    /// What friction dissipates from `before` to `after`, face by face: `A_f t_T·Δγ` of slipping faces, 0 of others [J].
    pub fn slip_work<'s>(
        &'s self,
        before: &'s State,
        after: &'s State,
    ) -> impl Iterator<Item = f64> + 's {
        let faces = self.problem().faces().iter().zip(&after.states).enumerate();
        faces.map(move |(f, (face, state))| match state {
            ContactState::NewSlip | ContactState::Slip => {
                let along = |k: usize| {
                    after.t[3 * f + 1 + k] * (after.slip[2 * f + k] - before.slip[2 * f + k])
                };
                face.area * (along(0) + along(1))
            }
            ContactState::Stick | ContactState::Open => 0.0,
        })
    }
}
