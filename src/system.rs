//! From a body to its saddle point: `[A B; Bᵀ −H]` with every fracture face in stick.

use crate::contact::{ContactState, Coupling, JumpStabilization, prescribed_jump};
use crate::elasticity::{Constraints, Elastic, ElasticityError, lift, loads, reduced, stiffness};
use crate::mesh::{FractureMesh, HexMesh};
use crate::scene::{Body, SurfaceTraction};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::axpy;
use fracas_solvers::saddle::{DofCoordinate, SaddleBlocks};

/// A meshed body with its materials and supports: all that the blocks depend on.
#[derive(Clone, Copy, Debug)]
pub struct StickSystem<'a> {
    /// The body.
    pub mesh: &'a HexMesh,
    /// Its fractures.
    pub fractures: &'a FractureMesh,
    /// Elastic constants per region.
    pub materials: &'a [Elastic],
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
            .assemble_for(self.mesh, self.fractures, self.materials, state);
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
    /// Nodal forces of body force, surface tractions and initial stress over all displacements [N], `3·node + component`.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element.
    pub fn forces(&self) -> Result<Vec<f64>, ElasticityError> {
        let mut force = vec![0.0; self.constraints.full_len()];
        if self.body_force.iter().flatten().any(|b| *b != 0.0) {
            axpy(
                1.0,
                &loads::body_force(&self.mesh, &self.body_force)?,
                &mut force,
            );
        }
        for SurfaceTraction { faces, value } in &self.tractions {
            axpy(
                1.0,
                &loads::surface_traction(&self.mesh.nodes, faces, *value),
                &mut force,
            );
        }
        if let Some(stress) = self.initial_stress {
            axpy(
                1.0,
                &loads::initial_stress(&self.mesh, |_, x| stress.at(x))?,
                &mut force,
            );
        }
        Ok(force)
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

    /// The body with every face in stick.
    pub fn stick_system(&self, stabilization: Option<JumpStabilization>) -> StickSystem<'_> {
        StickSystem {
            mesh: &self.mesh,
            fractures: &self.fractures,
            materials: &self.materials,
            constraints: &self.constraints,
            stabilization,
        }
    }
}
