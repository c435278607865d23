//! Multigrid over levels that somebody else made: operators without a matrix, transfers without stored weights.
//!
//! A level is an operator on nodes of three components, its 3×3 diagonal blocks and a transfer to the next level; what
//! the nodes are is not known here. Below the last level stands a solver in f64.
//!
//! | step | file |
//! |---|---|
//! | `d ← c₁ d + c₂ D⁻¹ r, x ← x + d` in one pass | `block_jacobi` |
//! | one block for nodes that hardly differ | `groups` |
//! | a level, λ_max, smoothing | `level` |
//! | V, W and K | `cycle` |
//! | digits that a cycle in f32 loses | `noise` |
//! | the coarsest level, functions that depend on each other left out | `semidefinite` |
//! | f64 outside, f32 or f64 inside, free unknowns outside, all of them inside | `inverse` |
//! | what a model builds a hierarchy from | `settings` |

mod block_jacobi;
mod bottom;
mod cycle;
mod groups;
mod inverse;
mod level;
mod noise;
mod semidefinite;
mod settings;

pub use block_jacobi::{BlockJacobi, NoInverse};
pub use bottom::Bottom;
pub use cycle::{Cycle, Hierarchy};
pub use inverse::{MultigridInverse, SomeHierarchy};
pub use level::{Chebyshev, Level, Transfer};
pub use semidefinite::Semidefinite;
pub use settings::Geometric;
