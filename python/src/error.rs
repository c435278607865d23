//! Exceptions: the classes of `fracas._errors` with the sentences of the library.

use fracas::nonlinear::SimulationError;
use fracas::run::RunError;
use fracas::scene::SceneError;
use fracas::solve::SolveError;
use fracas_experiments::sentence::in_full;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::folder::FolderError;
use pyo3::prelude::*;
use pyo3::types::PyType;

/// Which class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Something else.
    Plain,
    /// An argument that cannot be.
    Input,
    /// A scene.
    Scene,
    /// A system, from a folder or from matrices.
    System,
    /// A preconditioner that cannot be set up.
    Setup,
    /// Too little memory.
    Memory,
    /// The folder of a run.
    Run,
    /// A study.
    Study,
    /// A step that does not converge.
    NotConverged,
}

impl Kind {
    fn class(self) -> &'static str {
        match self {
            Self::Plain => "Error",
            Self::Input => "InputError",
            Self::Scene => "SceneError",
            Self::System => "SystemInputError",
            Self::Setup => "SetupError",
            Self::Memory => "OutOfMemory",
            Self::Run => "RunError",
            Self::Study => "StudyError",
            Self::NotConverged => "NotConverged",
        }
    }
}

/// The exception of a kind with a sentence.
pub(crate) fn raise(kind: Kind, sentence: impl Into<String>) -> PyErr {
    let sentence = sentence.into();
    Python::attach(|py| {
        let module = py.import("fracas._errors");
        let class =
            module.and_then(|module| Ok(module.getattr(kind.class())?.cast_into::<PyType>()?));
        match class {
            Ok(class) => PyErr::from_type(class, (sentence,)),
            Err(error) => error,
        }
    })
}

/// An error of the library as an exception.
pub(crate) trait Raised {
    /// Its class.
    fn kind(&self) -> Kind;
}

impl Raised for SolveError {
    fn kind(&self) -> Kind {
        match self {
            Self::Tolerance { .. }
            | Self::Unit { .. }
            | Self::Part(_)
            | Self::NotGeometric(_)
            | Self::Nonlinear { .. } => Kind::Input,
            Self::Scene(_) => Kind::Scene,
            Self::TooLarge(_) | Self::NoRoom(_) | Self::NoRoomInDouble(_) => Kind::Memory,
            Self::Folder(_) => Kind::System,
            _ => Kind::Setup,
        }
    }
}

impl Raised for SceneError {
    fn kind(&self) -> Kind {
        Kind::Scene
    }
}

impl Raised for FolderError {
    fn kind(&self) -> Kind {
        Kind::System
    }
}

impl Raised for SetupError {
    fn kind(&self) -> Kind {
        match self {
            Self::OutOfMemory { .. } => Kind::Memory,
            _ => Kind::Setup,
        }
    }
}

impl Raised for SimulationError {
    fn kind(&self) -> Kind {
        Kind::Run
    }
}

impl Raised for RunError {
    fn kind(&self) -> Kind {
        match self {
            Self::Scene(_) => Kind::Scene,
            Self::TooLarge(_) => Kind::Memory,
            _ => Kind::Run,
        }
    }
}

/// `result.raised()?` in functions that Python calls.
pub(crate) trait Raise<T> {
    /// The same with an exception.
    fn raised(self) -> PyResult<T>;
}

impl<T, E: Raised + std::error::Error + Send + Sync + 'static> Raise<T> for Result<T, E> {
    fn raised(self) -> PyResult<T> {
        self.map_err(|error| {
            let kind = error.kind();
            raise(kind, in_full(&anyhow::Error::new(error)))
        })
    }
}

/// The same for errors of the command line's rooms.
pub(crate) fn of_any(kind: Kind, error: &anyhow::Error) -> PyErr {
    let known = error.downcast_ref::<SceneError>().map(Raised::kind);
    raise(known.unwrap_or(kind), in_full(error))
}
