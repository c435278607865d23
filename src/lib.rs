//! The model: from a fractured scene to the blocks of its saddle point, to their solution, and through its load steps.
//!
//! Rooms, each importing only those before it: `units` ◄ `digest` ◄ `mesh` ◄ `elasticity` ◄ {`creep`, `contact` ◄ `flow`} ◄ `scene` ◄ `system` ◄ {`undetermined`,
//! `memory` ◄ `inner`, `jacobian`, `multigrid` ◄ `matrix_free`} ◄ `nonlinear` ◄ `io` ◄ {`solve`, `run`} ◄ `prelude`; `analytic` knows the
//! answers and imports nothing.
//!
//! ```
//! use fracas::prelude::*;
//!
//! let scene = named("patch").ok_or("a scene of the gallery")?.scene()?;
//! let solved = Solve::default().solve(&scene.into(), &mut Silent)?;
//! assert!(solved.has_converged() && solved.error_u.is_some_and(|e| e < 1e-8));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod analytic;
pub mod contact;
pub mod creep;
mod digest;
pub mod elasticity;
pub mod flow;
mod inner;
pub mod io;
pub mod jacobian;
pub mod matrix_free;
pub mod memory;
pub mod mesh;
pub mod multigrid;
mod nearest;
pub mod nonlinear;
pub mod prelude;
pub mod run;
pub mod scene;
pub mod solve;
pub mod system;
pub mod undetermined;
pub mod units;
