//! The ready preconditioner.

use super::{Geometric, GeometricError};
use crate::system::StickSystem;
use fracas_operators::Preconditioner;
use fracas_solvers::amg::{Amg, AmgInverse, Summary};
use fracas_solvers::saddle::{AugmentationMatrix, DofCoordinate};

/// One multigrid cycle per solve: `z ≈ S_u⁻¹ r` over the free displacements.
#[derive(Debug)]
pub struct GeometricInverse {
    bottom: AmgInverse,
}

impl Geometric {
    /// The hierarchy of `S_u = A + B C⁻¹Bᵀ` for `system`; C belongs to B in m² (tractions in Pa), diagonal or one block per
    /// face.
    ///
    /// # Errors
    /// [`GeometricError`].
    pub fn build(
        &self,
        system: &StickSystem<'_>,
        c: &AugmentationMatrix,
    ) -> Result<GeometricInverse, GeometricError> {
        let faces = system.fractures.faces.len();
        if c.size() != 3 * faces {
            return Err(GeometricError::SizeOfC {
                expected: 3 * faces,
                found: c.size(),
            });
        }
        if !c.is_sparse() {
            return Err(GeometricError::DenseC);
        }
        let blocks = system.assemble(&vec![0.0; system.constraints.full_len()])?;
        let f = &blocks.b1 * &c.inverse_root()?;
        let coordinates: Option<&[DofCoordinate]> = blocks.coordinates.as_deref();
        let bottom = Amg::default().build_augmented(&blocks.a, &f, coordinates)?;
        Ok(GeometricInverse { bottom })
    }
}

impl GeometricInverse {
    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        self.bottom.summary()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.summary().levels.iter().map(|level| level.bytes).sum()
    }
}

impl Preconditioner<f64> for GeometricInverse {
    fn size(&self) -> usize {
        self.bottom.size()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.bottom.solve(r, z, work);
    }

    fn work_len(&self) -> usize {
        self.bottom.work_len()
    }

    fn flops(&self) -> u64 {
        self.bottom.flops()
    }

    fn is_linear(&self) -> bool {
        self.bottom.is_linear()
    }

    fn is_single(&self) -> bool {
        self.bottom.is_single()
    }
}
