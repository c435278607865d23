//! One linear system: which method, in which unit of tractions, with which digits, in how much memory, and how well it was solved.
//!
//! | file | what it decides |
//! |---|---|
//! | `problem` | scene, body, system folder or blocks |
//! | `route` | assembled or not, which inner solver, what takes its place |
//! | `set_up` | everything before a right-hand side |
//! | `iteration` | the iteration that fits into memory, in stages |
//! | `precision` | f64 where f32 fails |
//! | `giving_way` | another inner solver where the iteration gets nowhere |
//! | `over_ranks` | the same by rows over the ranks of `mpirun`, with the feature `petsc` |
//! | `spectrum` | the same problem's eigenvalues |
//! | `solved` | outcome, residuals, errors, counts, times |
//!
//! ```
//! use fracas::prelude::*;
//!
//! let scene = named("clamped").ok_or("a scene of the gallery")?.small_scene()?;
//! let settings = Solve {
//!     method: SaddleMethod::Racp(Racp::geometric()),
//!     inner: InnerRule::Fixed,
//!     ..Solve::default()
//! };
//! let mut solver = settings.set_up(&scene.into(), &mut Silent)?;
//! let solved = solver.solve(&mut Silent)?;
//! assert_eq!(solved.inner.as_deref(), Some("geometric"));
//! // the same preconditioner, another right-hand side
//! solver.set_rhs(vec![1.0; solved.x.len()]);
//! assert!(solver.solve(&mut Silent)?.has_converged());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod assembled;
mod error;
mod finding;
mod giving_way;
mod iteration;
mod matrix_free;
#[cfg(feature = "petsc")]
mod over_ranks;
mod precision;
mod problem;
mod route;
mod set_up;
mod settings;
mod solved;
mod solver;
mod spectrum;
mod stages;

pub use error::SolveError;
pub use finding::{Finding, Rounding};
pub use problem::{Loaded, Problem, Sizes, StuckBody};
pub use route::{NotGeometric, Route, SystemKind};
pub use settings::{InnerRule, RightHandSide, Solve};
pub use solved::{End, OverRanks, Solved, Times};
pub use solver::Solver;
pub use spectrum::{inf_sup, spectrum, spectrum_method};
