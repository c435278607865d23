//! A system and its preconditioner, ready for right-hand sides.

use super::{Finding, Problem, RightHandSide, Solve, SolveError, StuckBody, precision};
use crate::elasticity::FreeStiffness;
use crate::matrix_free::{MatrixFreeSystem, RacpParts};
use crate::memory;
use fracas_solvers::multigrid::Summary;
use fracas_solvers::saddle::{
    Assembled, Cost, HalvedBlocks, Racp, Ready, SaddleBlocks, SaddleMethod, SaddleSystem,
    StrainNorm, T,
};
use fracas_solvers::{Observer, SetupError, Silent};
use std::sync::Arc;

/// `𝒜` and `M⁻¹`, ready; it owns all that it needs.
pub struct Solver {
    pub(super) settings: Solve,
    /// What takes the place of an inner solver that gets nowhere, where it `gives_way`, in turn; made from the problem.
    pub(super) otherwise: Vec<SaddleMethod>,
    pub(super) gives_way: bool,
    pub(super) problem: Problem,
    pub(super) method: SaddleMethod,
    /// The same in f64, where it may take the place of f32.
    pub(super) double: Option<SaddleMethod>,
    pub(super) equations: Equations,
    pub(super) ready: Ready,
    pub(super) names: Names,
    pub(super) rhs: RightHandSide,
    pub(super) b: Vec<f64>,
    /// Of the tractions.
    pub(super) unit: f64,
    /// What rows of tractions were multiplied by that residuals are told without: the unit for systems of other codes, 1 for ours.
    pub(super) row_unit: f64,
    pub(super) setup_s: f64,
    pub(super) findings: Vec<Finding>,
    /// Times that f32 gave way to f64.
    pub(super) fallbacks: usize,
    /// Inner solvers that could not be set up, or got nowhere.
    pub(super) replaced: usize,
}

/// What results call the parts.
#[derive(Clone)]
pub(super) struct Names {
    pub(super) method: String,
    pub(super) augmentation: Option<String>,
    pub(super) inner: Option<String>,
}

impl Names {
    pub(super) fn of(method: &SaddleMethod) -> Self {
        Self {
            method: method.to_string(),
            augmentation: method.augmentation().map(|c| c.to_string()),
            inner: method.inner().map(|inner| inner.to_string()),
        }
    }

    /// Of a method that is ready, be it in f64 in place of f32.
    pub(super) fn of_ready(method: &SaddleMethod, in_f64: bool) -> Self {
        match in_f64 {
            true => Self {
                inner: precision::name_in_double(method),
                ..Self::of(method)
            },
            false => Self::of(method),
        }
    }
}

/// 𝒜 in either form.
pub(super) enum Equations {
    Assembled {
        blocks: Arc<SaddleBlocks>,
        /// Where displacements are prescribed: their part of the strain counts, too.
        stiffness: Option<FreeStiffness<f64>>,
    },
    /// Blocks of a folder with half of A in memory.
    Halved {
        blocks: Box<HalvedBlocks>,
        /// Read again where all of A is needed.
        problem: Problem,
    },
    /// The rows of this rank.
    #[cfg(feature = "petsc")]
    Spread(Box<fracas_solvers::distributed::SpreadSaddle>),
    MatrixFree {
        system: Box<MatrixFreeSystem>,
        /// Meshed again where f32 fails.
        stuck: StuckBody,
        racp: Racp,
    },
}

impl Equations {
    /// Runs `work` on 𝒜.
    pub(super) fn with<T>(&self, work: impl FnOnce(&dyn SaddleSystem) -> T) -> T {
        match self {
            Self::MatrixFree { system, .. } => work(&**system),
            Self::Halved { blocks, .. } => work(&blocks.system()),
            #[cfg(feature = "petsc")]
            Self::Spread(system) => work(&**system),
            Self::Assembled { blocks, stiffness } => {
                let strain = (stiffness.as_ref())
                    .map(|a| -> StrainNorm<'_> { Box::new(move |u| a.strain_norm(u)) });
                work(&Assembled::new(blocks, strain))
            }
        }
    }

    /// False where they are spread over ranks.
    pub(super) fn is_here(&self) -> bool {
        match self {
            #[cfg(feature = "petsc")]
            Self::Spread(_) => false,
            _ => true,
        }
    }

    pub(super) fn blocks(&self) -> Option<&Arc<SaddleBlocks>> {
        match self {
            Self::Assembled { blocks, .. } => Some(blocks),
            _ => None,
        }
    }

    /// A method made from matrices.
    pub(super) fn ready(&self, method: &SaddleMethod) -> Result<Ready, SetupError> {
        match self {
            Self::Assembled { blocks, .. } => method.ready(blocks),
            Self::Halved { blocks, .. } => blocks.ready(method),
            _ => unreachable!("{} without matrices", method.name()),
        }
    }
}

/// A preconditioner in f64 that takes the place of one in f32.
pub(super) struct Double {
    pub(super) ready: Ready,
    /// What results call the inner solver.
    pub(super) inner: String,
}

impl Solver {
    /// What runs, with its parts.
    pub fn method(&self) -> &SaddleMethod {
        &self.method
    }

    /// Levels of its multigrid.
    pub fn hierarchy(&self) -> Option<&Summary> {
        self.ready.hierarchy.as_ref()
    }

    /// Flops of 𝒜 and of M⁻¹.
    pub fn cost(&self) -> Cost {
        self.equations
            .with(|system| Cost::new(system.operator(), &*self.ready.inverse))
    }

    /// Wall time of the set-up [s].
    pub fn setup_s(&self) -> f64 {
        self.setup_s
    }

    /// Entries of b and x.
    pub fn unknowns(&self) -> usize {
        self.b.len()
    }

    /// Stops after so many iterations from here on.
    pub fn set_max_iterations(&mut self, most: usize) {
        self.settings.max_iterations = most;
    }

    /// Another right-hand side from here on, in the units of the system.
    ///
    /// # Panics
    /// With another number of entries than there are unknowns.
    pub fn set_rhs(&mut self, mut b: Vec<f64>) {
        assert_eq!(b.len(), self.b.len(), "entries of b, unknowns");
        let layout = self.equations.with(|system| system.layout());
        let [b_t] = layout.split_mut([T], &mut b);
        b_t.iter_mut().for_each(|b| *b *= self.unit);
        (self.rhs, self.b) = (RightHandSide::Given, b);
    }

    /// The preconditioner in f64, where f32 is inside.
    pub(super) fn in_double(&self, observer: &mut dyn Observer) -> Result<Double, SolveError> {
        memory::room_in_double(self.hierarchy())?;
        match &self.equations {
            Equations::Assembled { .. } | Equations::Halved { .. } => {
                let double = self.double.unwrap_or(self.method);
                Ok(Double {
                    ready: self.equations.ready(&double)?,
                    inner: precision::name_in_double(&double).unwrap_or_default(),
                })
            }
            Equations::MatrixFree {
                system,
                stuck,
                racp,
            } => {
                let racp = racp.in_double();
                // the body was given back: it is made again
                let body = stuck.mesh(memory::MATRIX_FREE, observer)?;
                let stick = body.stick_system(stuck.stabilization(&body));
                let parts = RacpParts::new(&racp, &system.saddle, &stick, observer)?;
                Ok(Double {
                    ready: parts.into(),
                    inner: racp.inner.to_string(),
                })
            }
            #[cfg(feature = "petsc")]
            Equations::Spread(_) => unreachable!("PETSc works in f64"),
        }
    }

    /// The blocks, where they are not there; `None` where they are.
    pub(super) fn in_entries(
        &self,
        observer: &mut dyn Observer,
    ) -> Option<Result<SaddleBlocks, SolveError>> {
        let blocks = match &self.equations {
            Equations::Assembled { .. } => return None,
            // no rank has all entries
            #[cfg(feature = "petsc")]
            Equations::Spread(_) => return None,
            Equations::Halved { problem, .. } => {
                let loaded = problem.load(&mut Silent);
                loaded.map(|loaded| Arc::unwrap_or_clone(loaded.blocks))
            }
            Equations::MatrixFree { stuck, .. } => {
                stuck.assemble(observer).map(|(_, blocks)| blocks)
            }
        };
        Some(blocks.map(|blocks| blocks.into_traction_unit(self.unit)))
    }
}
