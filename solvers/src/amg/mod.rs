//! Algebraic multigrid for vector elasticity.

mod classical;
mod settings;
mod summary;

pub use settings::{Amg, Coarsening, Cycle, Precision, Smoother};
pub use summary::{LevelSummary, Summary};

use crate::{DofCoordinate, SetupError};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;

impl Amg {
    /// The hierarchy of a symmetric positive definite `a` whose unknowns live at `coordinates`.
    pub fn build(
        &self,
        _a: &SparseMatrix<f64>,
        _coordinates: Option<&[DofCoordinate]>,
    ) -> Result<AmgInverse, SetupError> {
        Err(SetupError::NotApplicable {
            method: "amg",
            reason: "in work".into(),
        })
    }
}

/// One cycle per solve.
pub struct AmgInverse {}

impl AmgInverse {
    /// Levels, complexities, bytes.
    pub fn summary(&self) -> Summary {
        unimplemented!()
    }
}

impl Preconditioner<f64> for AmgInverse {
    fn size(&self) -> usize {
        unimplemented!()
    }
    fn solve(&self, _r: &[f64], _z: &mut [f64], _work: &mut [f64]) {
        unimplemented!()
    }
    fn flops(&self) -> u64 {
        unimplemented!()
    }
}
