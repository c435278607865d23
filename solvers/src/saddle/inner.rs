//! The approximation of S_u⁻¹ inside RACP: the one list of all of them.

use super::scaling::ScaledInverse;
use super::{AugmentationMatrix, RelaxationSummary, SaddleBlocks, schur};
use crate::amg::Amg;
use crate::direct::DirectChoice;
use crate::fsai::{Fsai, FsaiKind};
use crate::multigrid::{Geometric, MultigridInverse, Precision, Smoother, Summary};
use crate::petsc::{Boomeramg, Gamg};
use crate::registry::{NameTaken, Named, Registered, Registry};
use crate::smoothers::{Jacobi, Ssor};
use crate::steering::Steering;
use crate::written::{self, Written};
use crate::{DofCoordinate, Prepare, SetupError};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::str::FromStr;

/// Which `S̃_u⁻¹`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(remote = "Self", rename_all = "snake_case")]
#[schemars(rename = "InnerChoice")]
pub enum InnerChoice {
    /// S_u⁻¹ by a sparse factorization.
    Exact {
        /// Who factorizes.
        #[serde(default)]
        backend: DirectChoice,
    },
    /// Damped Jacobi of S_u.
    Jacobi(Jacobi),
    /// SSOR of S_u.
    Ssor(Ssor),
    /// Factorized sparse approximate inverse of S_u.
    Fsai(Fsai),
    /// Algebraic multigrid of S_u.
    Amg(Amg),
    /// Geometric multigrid of S_u on the grid of a scene; matrices alone have none.
    Geometric(Geometric),
    /// GAMG of the system's PETSc on S_u; needs the feature `petsc`.
    Gamg(Gamg),
    /// BoomerAMG of the system's PETSc on S_u; needs the feature `petsc`.
    Boomeramg(Boomeramg),
    /// Somebody else's.
    #[serde(skip)]
    #[schemars(skip)]
    Other(Registered<dyn InnerSolver>),
}

/// An approximate inverse of S_u that somebody else brings; [`register`](InnerChoice::register) makes its name known.
pub trait InnerSolver: Named {
    /// Approximate inverse of a symmetric positive definite matrix whose unknowns live at `coordinates`, linear and symmetric unless
    /// its properties say otherwise.
    ///
    /// # Errors
    /// [`SetupError`] with `A` for the name of the block.
    fn of_matrix(
        &self,
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError>;

    /// S̃_u⁻¹ for these blocks and this C: that of the assembled `S_u = A + B C⁻¹Bᵀ`, unless one knows better.
    ///
    /// # Errors
    /// As [`of_matrix`](Self::of_matrix), with `S_u` for the name of the block.
    fn prepare(
        &self,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let s_u = schur::primal_schur(&blocks.a, &blocks.b1, c)?;
        self.of_matrix(&s_u, blocks.coordinates.as_deref())
            .map_err(|error| error.in_block("S_u"))
    }
}

static SOLVERS: Registry<dyn InnerSolver> = Registry::new("inner solver");

/// An approximate inverse that is ready, with what is known of it.
pub struct Ready {
    /// `z ← S̃⁻¹ r`.
    pub inverse: Box<dyn Preconditioner<f64>>,
    /// The levels of a multigrid hierarchy.
    pub hierarchy: Option<Summary>,
    /// What C and S̃_u cost, where both are parts of the method.
    pub parts: Option<PartCost>,
    /// How H is relaxed.
    pub relaxation: RelaxationSummary,
}

/// Time and flops of the two parts of RACP.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PartCost {
    /// Set-up of C, in seconds.
    pub c_s: f64,
    /// Set-up of S̃_u, in seconds.
    pub inner_s: f64,
    /// Flops of S̃_u⁻¹ in one application of M⁻¹.
    pub inner_flops: u64,
}

impl Ready {
    /// The same as a part of another inverse; what is known of it stays.
    pub(super) fn inside<M: Preconditioner<f64> + 'static>(
        self,
        whole: impl FnOnce(Box<dyn Preconditioner<f64>>) -> M,
    ) -> Self {
        Self {
            inverse: Box::new(whole(self.inverse)),
            ..self
        }
    }
}

impl From<Box<dyn Preconditioner<f64>>> for Ready {
    fn from(inverse: Box<dyn Preconditioner<f64>>) -> Self {
        Self {
            inverse,
            hierarchy: None,
            parts: None,
            relaxation: RelaxationSummary::default(),
        }
    }
}

impl Default for InnerChoice {
    fn default() -> Self {
        Self::Exact {
            backend: DirectChoice::default(),
        }
    }
}

impl From<MultigridInverse> for Ready {
    fn from(inverse: MultigridInverse) -> Self {
        Self {
            hierarchy: Some(inverse.summary()),
            inverse: Box::new(inverse),
            parts: None,
            relaxation: RelaxationSummary::default(),
        }
    }
}

impl InnerChoice {
    /// Plain name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact {
                backend: DirectChoice::Mumps,
            } => "mumps",
            Self::Exact { .. } => "exact",
            Self::Jacobi(_) => "jacobi",
            Self::Ssor(_) => "ssor",
            Self::Fsai(fsai) => match fsai.kind {
                FsaiKind::Adaptive(_) => "fsai",
                FsaiKind::Static(_) => "fsai:static",
            },
            Self::Amg(amg) => match amg.smoother {
                Smoother::Auto => "amg",
                Smoother::GaussSeidel => "amg:gauss_seidel",
                Smoother::Chebyshev => "amg:chebyshev",
                Smoother::Fsai => "amg:fsai",
            },
            Self::Geometric(_) => "geometric",
            Self::Gamg(_) => "gamg",
            Self::Boomeramg(_) => "boomeramg",
            Self::Other(solver) => solver.0.name(),
        }
    }

    /// Who factorizes what the method has to factorize beside S_u.
    pub fn backend(self) -> DirectChoice {
        match self {
            Self::Exact { backend } => backend,
            _ => DirectChoice::default(),
        }
    }

    /// The same in f64, where it is multigrid in f32.
    pub fn in_double(self) -> Option<Self> {
        match self {
            Self::Amg(amg) => amg.in_double().map(Self::Amg),
            Self::Geometric(geometric) => geometric.in_double().map(Self::Geometric),
            _ => None,
        }
    }

    /// Makes a solver known by its name.
    ///
    /// # Errors
    /// [`NameTaken`] where another solver has it.
    pub fn register(solver: &'static dyn InnerSolver) -> Result<Self, NameTaken> {
        match solver.name() {
            // what command lines call a choice of theirs
            name @ "auto" => Err(SOLVERS.taken(name)),
            _ => SOLVERS.register::<Self>(solver).map(Self::Other),
        }
    }

    /// `S̃_u⁻¹` for these blocks and this C.
    ///
    /// # Errors
    /// As the chosen method, with `S_u` for the name of the block.
    pub fn prepare(
        self,
        blocks: &SaddleBlocks,
        c: &AugmentationMatrix,
    ) -> Result<Ready, SetupError> {
        if let Self::Exact { backend } = self {
            let inverse = schur::exact_inverse(blocks, c, backend.solver()?.as_ref())?;
            return Ok(inverse.into());
        }
        match self {
            Self::Other(solver) => return Ok(solver.0.prepare(blocks, c)?.into()),
            Self::Geometric(_) => return Err(no_grid()),
            _ => {}
        }
        if let (Self::Amg(settings), true) = (self, c.is_sparse()) {
            // S_u = A + F Fᵀ is never assembled entry by entry
            let f = &blocks.b1 * &c.inverse_root()?;
            let inverse = settings
                .build_augmented(&blocks.a, &f, blocks.coordinates.as_deref())
                .map_err(|error| error.in_block("S_u"))?;
            return Ok(inverse.into());
        }
        let s_u = schur::primal_schur(&blocks.a, &blocks.b1, c)?;
        self.of_matrix(&s_u, blocks.coordinates.as_deref())
            .map_err(|error| error.in_block("S_u"))
    }

    /// Approximate inverse of a symmetric positive definite matrix whose unknowns live at `coordinates`.
    ///
    /// # Errors
    /// As the chosen method, with `A` for the name of the block.
    pub fn of_matrix(
        self,
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<Ready, SetupError> {
        let plain =
            |settings: &dyn Prepare<SparseMatrix<f64>, f64>| Ok(settings.prepare(a)?.into());
        match self {
            Self::Exact { backend } => {
                let inverse = ScaledInverse::new(a, backend.solver()?.as_ref(), "A")?;
                Ok((Box::new(inverse) as Box<dyn Preconditioner<f64>>).into())
            }
            Self::Jacobi(settings) => plain(&settings),
            Self::Ssor(settings) => plain(&settings),
            Self::Fsai(settings) => plain(&settings),
            Self::Amg(settings) => Ok(settings.build(a, coordinates)?.into()),
            Self::Geometric(_) => Err(no_grid()),
            Self::Gamg(settings) => Ok(settings.build(a, coordinates)?.into()),
            Self::Boomeramg(settings) => Ok(settings.build(a, coordinates)?.into()),
            Self::Other(solver) => Ok(solver.0.of_matrix(a, coordinates)?.into()),
        }
    }
}

/// Of geometric multigrid where there are matrices alone.
fn no_grid() -> SetupError {
    SetupError::NotApplicable {
        method: "geometric",
        reason: "it needs the grid of a scene and assembles no A; matrices take amg".to_owned(),
    }
}

impl fmt::Display for InnerChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Geometric(geometric) => geometric.fmt(f),
            Self::Amg(amg) if amg.precision == Precision::F64 => write!(f, "{}:f64", self.name()),
            _ => f.write_str(self.name()),
        }
    }
}

/// A name that is none of [`InnerChoice`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown inner solver {found:?}: expected exact, amg, amg:gauss_seidel, amg:fsai, amg:chebyshev (behind each :f64), fsai, fsai:static, jacobi, ssor, geometric (behind it :v, :w or :k and :f64: geometric:k:f64), or gamg, boomeramg or mumps of PETSc{}",
    SOLVERS.names()
)]
pub struct UnknownInner {
    /// What was given.
    pub found: String,
}

impl FromStr for InnerChoice {
    type Err = UnknownInner;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "exact" => Ok(Self::default()),
            "mumps" => Ok(Self::Exact {
                backend: DirectChoice::Mumps,
            }),
            "gamg" => Ok(Self::Gamg(Gamg::default())),
            "boomeramg" => Ok(Self::Boomeramg(Boomeramg::default())),
            "jacobi" => Ok(Self::Jacobi(Jacobi::default())),
            "ssor" => Ok(Self::Ssor(Ssor::default())),
            "fsai" => Ok(Self::Fsai(Fsai::default())),
            "fsai:static" => Ok(Self::Fsai(Fsai::of_power(1))),
            "amg" => Ok(Self::Amg(Amg::default())),
            "amg:gauss_seidel" => Ok(Self::Amg(Amg::with(Smoother::GaussSeidel))),
            "amg:fsai" => Ok(Self::Amg(Amg::with(Smoother::Fsai))),
            "amg:chebyshev" => Ok(Self::Amg(Amg::with(Smoother::Chebyshev))),
            _ if name.starts_with("amg") && name.ends_with(":f64") => {
                let single = name.strip_suffix(":f64").map(str::parse::<Self>);
                let double = single.and_then(Result::ok).and_then(Self::in_double);
                double.ok_or_else(|| UnknownInner {
                    found: name.to_owned(),
                })
            }
            _ => {
                let geometric = Geometric::of_name(name).map(Self::Geometric);
                let other = || SOLVERS.find(name).map(Self::Other);
                geometric.or_else(other).ok_or_else(|| UnknownInner {
                    found: name.to_owned(),
                })
            }
        }
    }
}

impl Serialize for InnerChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Other(solver) => solver.serialize(serializer),
            own => Self::serialize(own, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for InnerChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        written::read(deserializer)
    }
}

impl Written for InnerChoice {
    const EXPECTED: &'static str = "an inner solver such as \"ssor\" or { ssor = { omega = 1.2 } }";

    fn from_table<'de, D: Deserializer<'de>>(table: D) -> Result<Self, D::Error> {
        let inner = Self::deserialize(table)?;
        // counts beyond these ranges end in no lifetime, and nothing stops an application
        match &inner {
            Self::Amg(settings) => settings.checked().err(),
            Self::Geometric(settings) => settings.checked().err(),
            Self::Gamg(settings) => settings.checked().err(),
            Self::Boomeramg(settings) => settings.checked().err(),
            Self::Fsai(Fsai { kind }) => match kind {
                FsaiKind::Adaptive(settings) => settings.checked().err(),
                FsaiKind::Static(settings) => settings.checked().err(),
            },
            _ => None,
        }
        .map_or(Ok(inner), |refused| Err(D::Error::custom(refused)))
    }
}

/// `"ssor"` or `{ ssor = { omega = 1.2 } }`.
#[derive(JsonSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "what it describes is read as an InnerChoice")]
pub(crate) enum NameOrSettings {
    /// Plain name, default settings.
    Name(String),
    /// Name with settings.
    Settings(InnerChoice),
}
