//! Why there is no geometric hierarchy.

use crate::elasticity::ElasticityError;
use fracas_solvers::SetupError;

/// A body or a C that geometric multigrid cannot take.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeometricError {
    /// The mesh follows no structured numbering.
    #[error("the mesh has no grid to coarsen; take --inner amg")]
    NoGrid,
    /// C⁻¹ couples faces with each other.
    #[error("C is dense: B C⁻¹Bᵀ couples all faces; take a diagonal C or one block per face")]
    DenseC,
    /// C of other fractures.
    #[error("C has {found} rows, the fractures have {expected} tractions")]
    SizeOfC {
        /// Tractions.
        expected: usize,
        /// Rows of C.
        found: usize,
    },
    /// Numbers beyond the range of the hierarchy's precision.
    #[error("level {level} of the hierarchy overflows in {precision}; take precision f64")]
    Overflow {
        /// Level, 0 the finest.
        level: usize,
        /// `f32` or `f64`.
        precision: &'static str,
    },
    /// A diagonal block that is not positive definite.
    #[error(
        "level {level} of the hierarchy is not positive definite near ({:.6e}, {:.6e}, {:.6e}) m: a block of rock is held \
         neither by boundary conditions nor by a fracture, or its stiffness is lost in the digits of the hierarchy (then \
         take precision f64)", place[0], place[1], place[2]
    )]
    Indefinite {
        /// Level, 0 the finest.
        level: usize,
        /// The node [m].
        place: [f64; 3],
    },
    /// A mesh without a stiffness.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// The solver below the coarsest grid.
    #[error("below the coarsest grid: {0}")]
    Bottom(#[from] SetupError),
}
