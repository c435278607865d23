//! What one needs to solve a system, to run a scene, and to see where eigenvalues lie: `use fracas::prelude::*`.

pub use crate::nonlinear::{Simulation, State};
pub use crate::run::{Outcome, Run, RunFolder, Running, Stop, Taken};
pub use crate::scene::{Body, Scene, gallery, named};
pub use crate::solve::{InnerRule, Problem, RightHandSide, Solve, Solved, Solver};
pub use fracas_solvers::krylov::KrylovChoice;
pub use fracas_solvers::saddle::{
    AugmentationChoice, InnerChoice, Measure, Racp, SaddleBlocks, SaddleMethod,
};
pub use fracas_solvers::spectrum::{SpectrumReport, SpectrumRequest, analyse_method};
pub use fracas_solvers::{Observer, Silent, Step};
