//! Why there is no geometric hierarchy.

use crate::elasticity::ElasticityError;
use fracas_solvers::SetupError;

/// Why a hierarchy is in f64 although f32 was asked for.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Lost {
    /// Numbers beyond its range.
    #[error("level {level} of the hierarchy leaves the range of f32")]
    Range {
        /// Level, 0 the finest.
        level: usize,
    },
    /// Digits below its roundoff.
    #[error("rounding to f32 would leave {rounding:.0e} of a uniform force as a residual")]
    Digits {
        /// [`Hierarchy::rounding`](fracas_solvers::multigrid::Hierarchy::rounding).
        rounding: f64,
    },
}

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
    #[error("level {level} of the hierarchy leaves the range of {precision}")]
    Overflow {
        /// Level, 0 the finest.
        level: usize,
        /// `f32` or `f64`.
        precision: &'static str,
    },
    /// A diagonal block that is not positive definite.
    #[error(
        "level {level} of the hierarchy is not positive definite near ({:.6e}, {:.6e}, {:.6e}) m: a block of rock is held \
         neither by boundary conditions nor by a fracture, or is so much softer than the rest that f64 cannot tell", place[0], place[1], place[2]
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
