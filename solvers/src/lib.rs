//! How to *invert*: Krylov methods, smoothers, direct solvers, saddle-point preconditioners, and the spectra that say
//! how good they are. Knows blocks, never a mesh or physics.

pub mod amg;
mod coordinates;
pub mod direct;
#[cfg(feature = "petsc")]
pub mod distributed;
pub mod eigen;
#[cfg(test)]
mod elastic_sample;
pub mod error;
pub mod fsai;
pub mod krylov;
pub mod multigrid;
pub mod observer;
pub mod petsc;
pub mod prepare;
pub mod registry;
pub mod saddle;
mod scratch;
pub mod smoothers;
pub mod spectrum;
pub mod steering;
pub mod words;
mod written;

pub use coordinates::DofCoordinate;
pub use error::SetupError;
pub use observer::{Observer, Silent, Step};
pub use prepare::Prepare;
pub use registry::{NameTaken, Named, Registered};
