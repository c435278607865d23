//! Which backend: the one list of all of them.

use super::{DirectSolver, Faer, Kind, Symbolic};
use crate::SetupError;
use crate::registry::{NameTaken, Named, Registered, Registry};
use fracas_operators::sparse::SparseMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::str::FromStr;

/// A backend by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DirectChoice {
    /// The fastest one of this build: CHOLMOD for LLᵀ, UMFPACK for LU, faer for LDLᵀ and wherever those are missing.
    #[default]
    Auto,
    /// faer with METIS: every kind, always there.
    Faer,
    /// CHOLMOD with METIS: LLᵀ; needs the feature `suitesparse`.
    Cholmod,
    /// UMFPACK: LU; needs the feature `suitesparse`.
    Umfpack,
    /// MUMPS of the system's PETSc: every kind, one call at a time; needs the feature `petsc`.
    Mumps,
    /// Somebody else's.
    #[serde(untagged)]
    #[schemars(skip)]
    Other(Registered<dyn DirectSolver>),
}

impl Named for dyn DirectSolver {
    fn name(&self) -> &'static str {
        DirectSolver::name(self)
    }
}

static SOLVERS: Registry<dyn DirectSolver> = Registry::new("direct solver");

impl DirectChoice {
    /// Every backend that has a name of its own.
    pub const BACKENDS: [Self; 4] = [Self::Faer, Self::Cholmod, Self::Umfpack, Self::Mumps];

    /// Makes a solver known by its name.
    ///
    /// # Errors
    /// [`NameTaken`] where another solver has it.
    pub fn register(solver: &'static dyn DirectSolver) -> Result<Self, NameTaken> {
        SOLVERS.register::<Self>(solver).map(Self::Other)
    }

    /// The backend.
    ///
    /// # Errors
    /// [`SetupError::NotBuilt`] for a backend that this build does not contain.
    pub fn solver(self) -> Result<Box<dyn DirectSolver>, SetupError> {
        match self {
            Self::Auto => Ok(Box::new(Auto)),
            Self::Faer => Ok(Box::new(Faer)),
            Self::Other(solver) => Ok(Box::new(Borrowed(solver.0))),
            #[cfg(feature = "suitesparse")]
            Self::Cholmod => Ok(Box::new(super::Cholmod)),
            #[cfg(feature = "suitesparse")]
            Self::Umfpack => Ok(Box::new(super::Umfpack)),
            #[cfg(feature = "petsc")]
            Self::Mumps => Ok(Box::new(super::Mumps)),
            #[cfg(not(feature = "suitesparse"))]
            Self::Cholmod => not_built("CHOLMOD", "suitesparse"),
            #[cfg(not(feature = "suitesparse"))]
            Self::Umfpack => not_built("UMFPACK", "suitesparse"),
            #[cfg(not(feature = "petsc"))]
            Self::Mumps => not_built("MUMPS", "petsc"),
        }
    }

    /// The backend that `self` stands for when the matrix is of this kind.
    fn resolved(self, kind: Kind) -> Self {
        let built = cfg!(feature = "suitesparse");
        match (self, kind) {
            (Self::Auto, Kind::Spd) if built => Self::Cholmod,
            (Self::Auto, Kind::General) if built => Self::Umfpack,
            (Self::Auto, _) => Self::Faer,
            (named, _) => named,
        }
    }
}

impl fmt::Display for DirectChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Faer => "faer",
            Self::Cholmod => "cholmod",
            Self::Umfpack => "umfpack",
            Self::Mumps => "mumps",
            Self::Other(solver) => solver.0.name(),
        })
    }
}

/// A name that is none of [`DirectChoice`]'s.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown direct solver {found:?}: expected auto, faer, cholmod, umfpack or mumps{}", SOLVERS.names())]
pub struct UnknownDirect {
    /// What was given.
    pub found: String,
}

impl FromStr for DirectChoice {
    type Err = UnknownDirect;

    fn from_str(name: &str) -> Result<Self, UnknownDirect> {
        [Self::Auto]
            .into_iter()
            .chain(Self::BACKENDS)
            .find(|choice| choice.to_string() == name)
            .or_else(|| SOLVERS.find(name).map(Self::Other))
            .ok_or_else(|| UnknownDirect { found: name.into() })
    }
}

/// A backend that was left out.
#[cfg(not(all(feature = "suitesparse", feature = "petsc")))]
fn not_built(
    backend: &'static str,
    feature: &'static str,
) -> Result<Box<dyn DirectSolver>, SetupError> {
    Err(SetupError::NotBuilt { backend, feature })
}

impl<'de> Deserialize<'de> for DirectChoice {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        name.parse().map_err(serde::de::Error::custom)
    }
}

/// A solver that somebody else keeps.
#[derive(Clone, Copy, Debug)]
struct Borrowed(&'static dyn DirectSolver);

impl DirectSolver for Borrowed {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError> {
        self.0.analyze(a, kind)
    }
}

/// Chooses by kind.
#[derive(Clone, Copy, Debug)]
struct Auto;

impl DirectSolver for Auto {
    fn name(&self) -> &'static str {
        "auto"
    }

    fn analyze(&self, a: &SparseMatrix<f64>, kind: Kind) -> Result<Box<dyn Symbolic>, SetupError> {
        DirectChoice::Auto.resolved(kind).solver()?.analyze(a, kind)
    }
}
