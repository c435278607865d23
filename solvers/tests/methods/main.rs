//! Claims about preconditioners of saddle points, algebraic multigrid and spectra.
#![allow(clippy::unwrap_used)]

#[path = "../../src/spectrum/certify/cases.rs"]
#[allow(dead_code, reason = "other claims need more of it")]
mod cases;
#[path = "../../src/elastic_sample.rs"]
mod elastic_sample;
#[path = "../../src/krylov/oracle.rs"]
#[allow(dead_code, reason = "other claims need more of it")]
mod iterations;
mod oracle;
#[path = "../../src/saddle/samples.rs"]
mod samples;

mod augmented_lagrangian;
mod block_diagonal;
mod block_triangular;
mod certified;
mod chains;
mod classical;
mod coarse;
mod custom;
mod elimination;
mod explained;
mod fields;
mod inner_by_name;
mod iterations_by_name;
mod laboratory;
mod mcp;
mod method;
#[cfg(not(feature = "petsc"))]
mod petsc;
mod probe;
mod racp;
mod relaxation;
mod simple;
mod three_fields;
mod with_flow;

use fracas_solvers::krylov::{
    Breakdown, Cg, Criteria, KrylovMethod, Outcome, Report, System, Watch,
};
use fracas_solvers::saddle::SaddleBlocks;
use fracas_solvers::{DofCoordinate, Silent, saddle};
