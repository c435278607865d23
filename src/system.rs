//! From a body to its saddle point: `[A B; Bᵀ −H]` with every fracture face in stick.

use crate::contact::{Coupling, JumpStabilization, prescribed_jump};
use crate::elasticity::{Constraints, Elastic, ElasticityError, lift, reduced, stiffness};
use crate::mesh::{FractureMesh, HexMesh};
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
        let h = self
            .stabilization
            .map(|s| s.assemble(self.mesh, self.fractures, self.materials))
            .filter(|h| h.nnz() > 0);
        Ok(SaddleBlocks {
            a: reduced(&full, self.constraints),
            b1: Coupling::new(self.fractures, self.constraints).assemble(),
            b2: None,
            h,
            rhs_u,
            rhs_t: rhs_t.into_iter().map(|jump| -jump).collect(),
            coordinates: Some(self.coordinates()),
            flow: None,
        })
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
