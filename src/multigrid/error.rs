//! Why there is no geometric hierarchy.

use super::smoothing::MOST_DEGREE;
use crate::elasticity::ElasticityError;
use crate::mesh::{Hold, bodies};
use crate::system::StickSystem;
use fracas_solvers::SetupError;
use fracas_solvers::steering::OutOfRange;
use fracas_solvers::words::by_number;

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
    /// A setting beyond its range.
    #[error("geometric multigrid: {0}")]
    Setting(#[from] OutOfRange),
    /// The mesh follows no structured numbering.
    #[error("the mesh has no grid to coarsen; take inner = \"amg\"")]
    NoGrid,
    /// C⁻¹ couples faces with each other.
    #[error("C couples faces, and so does B C⁻¹Bᵀ; take a diagonal C or one block per face")]
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
    /// A body that boundary conditions and fractures leave free to move.
    #[error(
        "nothing holds the body of {elements} elements around ({:.6e}, {:.6e}, {:.6e}) m: {free} rigid {} free", center[0], center[1], center[2], by_number(*free, "motion is", "motions are")
    )]
    Loose {
        /// Its elements.
        elements: usize,
        /// Its centre [m].
        center: [f64; 3],
        /// Rigid motions left, together with the bodies that it touches.
        free: usize,
    },
    /// A diagonal block that is not positive definite, of a body that is held.
    #[error(
        "level {level} of the hierarchy is not positive definite near ({:.6e}, {:.6e}, {:.6e}) m, though every body is held: f64 cannot \
         tell what holds the rock there, so much softer is it than the rest; take another inner solver", place[0], place[1], place[2]
    )]
    Indefinite {
        /// Level, 0 the finest.
        level: usize,
        /// The node [m].
        place: [f64; 3],
    },
    /// Rock that resists a change of volume so much that smoothing it takes too long.
    #[error(
        "rock of ν = {poisson} hardly changes its volume: a polynomial of degree {degree} would smooth it, {MOST_DEGREE} are taken at most; \
         f64 has few digits left there: take ν further from ½, or inner = \"exact\""
    )]
    Incompressible {
        /// Poisson's ratio. Unit: 1.
        poisson: f64,
        /// Degree of the polynomial.
        degree: usize,
    },
    /// A motion of a body that is held whose stiffness is rounding.
    #[error(
        "the coarsest level has lost a motion that costs {cost:.0e} of the stiffness of its nodes, though every body is held: f64 cannot tell \
         what holds it, so much softer is it than the rest; take another inner solver"
    )]
    Soft {
        /// `‖D⁻¹S_u x‖/‖x‖` of that motion x. Unit: 1.
        cost: f64,
    },
    /// A mesh without a stiffness.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// The solver below the coarsest grid.
    #[error("below the coarsest grid: {0}")]
    Bottom(#[from] SetupError),
}

impl GeometricError {
    /// The same error, or the body that nothing holds where there is one: boundary conditions and fractures are asked, not pivots.
    pub(super) fn judged(self, system: &StickSystem<'_>) -> Self {
        if !matches!(
            self,
            Self::Indefinite { .. } | Self::Soft { .. } | Self::Bottom(_)
        ) {
            return self;
        }
        let mut prescribed = vec![true; system.constraints.full_len()];
        let free = system.constraints.free();
        free.iter().for_each(|i| prescribed[*i as usize] = false);
        let parts = bodies(system.mesh, system.fractures, &prescribed);
        let loose = parts.into_iter().find_map(|part| match part.hold {
            Hold::Nothing { free } => Some(Self::Loose {
                elements: part.elements,
                center: part.center,
                free,
            }),
            _ => None,
        });
        loose.unwrap_or(self)
    }
}
