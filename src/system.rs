//! From a body to its saddle point: `[A B; Bᵀ −H]` with every fracture face in stick.

use crate::contact::{ContactState, Coupling, JumpStabilization, Rocks, prescribed_jump};
use crate::elasticity::{
    Constraints, Elastic, ElasticityError, FreeStiffness, Restricted, lift, loads, matrix_free,
    pore_forces, reduced, stiffness,
};
use crate::mesh::{FractureFace, FractureMesh, HexMesh};
use crate::scene::Body;
use fracas_operators::LinearOperator;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::axpy;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{DofCoordinate, SaddleBlocks};

/// A meshed body with its materials and supports: all that the blocks depend on.
#[derive(Clone, Copy, Debug)]
pub struct StickSystem<'a> {
    /// The body.
    pub mesh: &'a HexMesh,
    /// Its fractures.
    pub fractures: &'a FractureMesh,
    /// Elastic constants per region, of which A is made.
    pub materials: &'a [Elastic],
    /// Those of which H is made: the same, but where rock creeps, as H must not change with the length of a step.
    pub jump_rocks: Rocks<'a>,
    /// Prescribed displacements.
    pub constraints: &'a Constraints,
    /// Jump stabilization, or `None` for the bare pair (H = 0).
    pub stabilization: Option<JumpStabilization>,
}

impl StickSystem<'_> {
    /// Assembles the blocks for nodal forces `force` [N] over all displacements (3 · nodes).
    ///
    /// Prescribed displacements leave the unknowns: `rhs_u = f_f − A_fc u_c`, `rhs_t = −B_cᵀ u_c` (no initial gap).
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn assemble(&self, force: &[f64]) -> Result<SaddleBlocks, ElasticityError> {
        let full = stiffness(self.mesh, self.materials)?;
        let mut rhs_u: Vec<f64> = self
            .constraints
            .free()
            .iter()
            .map(|dof| force[*dof as usize])
            .collect();
        lift(&full, self.constraints, &mut rhs_u);
        let rhs_t = prescribed_jump(self.fractures, self.constraints);
        Ok(SaddleBlocks {
            a: reduced(&full, self.constraints),
            b1: Coupling::new(self.fractures, self.constraints).assemble(),
            b2: None,
            h: self.stabilization(),
            rhs_u,
            rhs_t: rhs_t.into_iter().map(|jump| -jump).collect(),
            coordinates: Some(self.coordinates()),
            flow: None,
        })
    }

    /// H, or `None` where it is absent or has no entries.
    pub fn stabilization(&self) -> Option<SparseMatrix<f64>> {
        self.stabilization_for(|_| ContactState::Stick)
    }

    /// H for faces in given states, or `None` where it is absent or has no entries.
    pub fn stabilization_for(
        &self,
        state: impl Fn(usize) -> ContactState + Sync,
    ) -> Option<SparseMatrix<f64>> {
        let h = self
            .stabilization?
            .assemble_for(self.mesh, self.fractures, self.jump_rocks, state);
        (h.nnz() > 0).then_some(h)
    }

    /// Where the free displacements live.
    fn coordinates(&self) -> Vec<DofCoordinate> {
        let place = |dof: &u32| DofCoordinate {
            position: self.mesh.nodes[*dof as usize / 3],
            component: (*dof % 3) as u8,
        };
        self.constraints.free().iter().map(place).collect()
    }
}

impl Body {
    /// Nodal forces of body force, surface tractions, fluid in fractures and pores and initial stress over all displacements [N],
    /// `3·node + component`, every load at the factor 1 of its history and every face closed.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub fn forces(&self) -> Result<Vec<f64>, ElasticityError> {
        let mut force = vec![0.0; self.constraints.full_len()];
        for history in 0..self.histories.len() {
            axpy(1.0, &self.forces_of(history)?, &mut force);
        }
        if let Some(pressures) = self.pressures_of_sides_at_once() {
            self.add_pressures(&pressures, &mut force);
        }
        Ok(force)
    }

    /// The part of [`forces`](Self::forces) that follows one history, at its factor 1.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub fn forces_of(&self, history: usize) -> Result<Vec<f64>, ElasticityError> {
        let mut force = vec![0.0; self.constraints.full_len()];
        if history == Self::ALWAYS {
            if self.body_force.iter().flatten().any(|b| *b != 0.0) {
                let weight = loads::body_force(&self.mesh, &self.body_force)?;
                axpy(1.0, &weight, &mut force);
            }
            if self.initial_stress.is_some() {
                let stress = |region: usize, x: [f64; 3]| self.initial_stress_at(region, x);
                let stressed = loads::initial_stress(&self.mesh, stress)?;
                axpy(1.0, &stressed, &mut force);
                for face in &self.fractures.faces {
                    let beyond = self.pull_beyond_mean(face);
                    loads::between_sides(face, &beyond, |dof, f| force[dof] += f);
                }
            }
        }
        let change = |region: usize| match &self.pore_changes[region] {
            own if own.history == history => own.drained(),
            _ => 0.0,
        };
        if (0..self.pore_changes.len()).any(|region| change(region) != 0.0) {
            // σ = C ε − α Δp I
            let drained = loads::initial_stress(&self.mesh, |region, _| {
                let p = change(region);
                [-p, -p, -p, 0.0, 0.0, 0.0]
            })?;
            axpy(1.0, &drained, &mut force);
        }
        for load in self.tractions.iter().filter(|l| l.history == history) {
            axpy(1.0, &load.forces(&self.mesh.nodes), &mut force);
        }
        if let Some(pressures) = self.pressures_of(history) {
            self.add_pressures(&pressures, &mut force);
        }
        Ok(force)
    }

    /// Adds the forces of a pressure per face [Pa], in full numbering [N].
    fn add_pressures(&self, pressures: &[f64], force: &mut [f64]) {
        // −Q1 p = B (p, 0, 0)
        let normal: Vec<f64> = pressures.iter().flat_map(|p| [*p, 0.0, 0.0]).collect();
        let coupling = Coupling::<f64>::in_full_numbering(&self.fractures, self.mesh.nodes.len());
        let mut work = vec![0.0; coupling.work_len()];
        coupling.apply_add(1.0, &normal, force, &mut work);
    }

    /// Forces that are no sum of histories times cases, at a time [s], in full numbering [N]: of pore pressures that differ from element to
    /// element, and of pressures in fractures that follow the rock. `None` where there are none.
    ///
    /// Those of fields are no part of [`forces`](Self::forces): at time 0 nothing has changed.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub fn drained_forces(&self, time: f64) -> Result<Option<Vec<f64>>, ElasticityError> {
        let mut force = None;
        let none = || vec![0.0; self.constraints.full_len()];
        for field in &self.pore_fields {
            let force = force.get_or_insert_with(none);
            pore_forces(&self.mesh, &field.elements, &field.drained(time), force)?;
        }
        if let Some(pressures) = self.pressures_of_sides(time) {
            self.add_pressures(&pressures, force.get_or_insert_with(none));
        }
        Ok(force)
    }

    /// What the initial stress pulls on the corners of a closed face beyond its mean on it, at the side that its normal leaves [N].
    pub(crate) fn pull_beyond_mean(&self, face: &FractureFace) -> [[f64; 3]; 4] {
        loads::pull_beyond_mean(&self.mesh, face, |x, n| self.initial_pull_at(face, x, n))
    }

    /// p of every face whose fracture has a pressure of that history, the initial one of a fluid included [Pa]; `None` where there is
    /// none.
    fn pressures_of(&self, history: usize) -> Option<Vec<f64>> {
        let value = |f: &FractureFace| match self.pressures.get(usize::from(f.fracture)) {
            Some((_, of)) if *of == history => self.pressure_of(f),
            _ => 0.0,
        };
        let fluid = self.fluid.as_ref().filter(|_| history == Self::ALWAYS);
        let initial = |f: &FractureFace| fluid.map_or(0.0, |fluid| fluid.initial_pressure(f));
        let both = |f: &FractureFace| value(f) + initial(f);
        let all: Vec<f64> = self.fractures.faces.iter().map(both).collect();
        all.iter().any(|p| *p != 0.0).then_some(all)
    }

    /// The blocks `[A B; Bᵀ −H]` with every face in stick under the body's loads; `stabilization = None` gives H = 0.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn saddle_blocks(
        &self,
        stabilization: Option<JumpStabilization>,
    ) -> Result<SaddleBlocks, ElasticityError> {
        self.stick_system(stabilization).assemble(&self.forces()?)
    }

    /// A without its entries, for the norm of strain of solutions; `None` where no displacement is prescribed but 0.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn displaced_stiffness(&self) -> Result<Option<FreeStiffness<f64>>, ElasticityError> {
        if !self.constraints.is_displaced() {
            return Ok(None);
        }
        let full = matrix_free::<f64>(&self.mesh, &self.materials)?;
        Ok(Some(Restricted::new(full, self.constraints.clone())))
    }

    /// H with factor 1 and the lengths that the scene asks for.
    pub fn jump_stabilization(&self) -> JumpStabilization {
        JumpStabilization {
            lengths: self.solver.stabilization,
            junctions: self.solver.junctions,
            interfaces: self.solver.interfaces,
            ..JumpStabilization::default()
        }
    }

    /// The body with every face in stick.
    pub fn stick_system(&self, stabilization: Option<JumpStabilization>) -> StickSystem<'_> {
        StickSystem {
            mesh: &self.mesh,
            fractures: &self.fractures,
            materials: &self.materials,
            jump_rocks: Rocks {
                elastic: &self.materials,
                first_alike: &self.first_alike,
            },
            constraints: &self.constraints,
            stabilization,
        }
    }
}

/// The failure of a set-up for bodies that are all held: where S_u is not positive definite in f64 it is rounding, and no support is
/// missing.
pub fn of_held_bodies(mut error: SetupError) -> SetupError {
    if let SetupError::Singular { block, advice, .. }
    | SetupError::NotPositiveDefinite { block, advice, .. } = &mut error
        && *block == "S_u"
    {
        "every body is held, so that it is rounding: bodies this slender, cells this flat or contrasts this large leave f64 no digits; take less of them"
            .clone_into(advice);
    }
    error
}
