//! Multigrid: one hierarchy and one cycle over levels that algebraic multigrid ([`amg`](crate::amg)) or the grids of a model make.
//!
//! A level is an operator on nodes of three components with what smooths it, and a transfer to the next level; what the nodes are is
//! not known here. Below the last level stands a solver in f64.
//!
//! | step | file |
//! |---|---|
//! | `x ← S b`, `b − A x`; `x ← x + Sᵀ(b − A x)` | `smooth` |
//! | `d ← c₁ d + c₂ D⁻¹ r, x ← x + d` in one pass | `block_jacobi` |
//! | one block for nodes that hardly differ | `groups` |
//! | polynomials in D⁻¹A, λ_max | `chebyshev`, `lambda` |
//! | a level, P and Pᵀ | `level` |
//! | V, W and K | `cycle`, `step_length` |
//! | digits that a cycle in f32 loses | `noise` |
//! | the coarsest level, functions that depend on each other left out | `bottom`, `direct` |
//! | f64 outside, f32 or f64 inside, unknowns in their places | `inverse`, `places`, `scratch` |
//! | what a hierarchy costs | `summary` |
//! | plain settings | `choices`, `settings`, `grid_lines` |

mod block_jacobi;
mod bottom;
mod chebyshev;
mod choices;
mod cycle;
mod direct;
mod grid_lines;
mod groups;
mod inverse;
pub(crate) mod lambda;
mod level;
mod noise;
mod places;
mod settings;
mod smooth;
mod step_length;
mod summary;

pub use block_jacobi::{BlockJacobi, NoInverse};
pub use bottom::Bottom;
pub use chebyshev::{BlockChebyshev, Chebyshev, Scaled};
pub use choices::{Precision, Smoother};
pub use cycle::{About, Cycle, Hierarchy};
pub use direct::Direct;
pub use grid_lines::GridLines;
pub use inverse::{MultigridInverse, SomeHierarchy};
pub use level::{Correction, Level, Transfer};
pub use places::Places;
pub(crate) use places::{NONE, Slots};
pub use settings::Geometric;
pub use smooth::{Hand, Smooth};
pub use summary::{LevelSummary, Smoothing, Summary};
