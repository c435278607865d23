//! Algebraic multigrid for vector elasticity on fractured bodies: `z ← M⁻¹ r` by one cycle.
//!
//! Nodes are 3×3 blocks on every level (an aggregate of nodes has two: translations and rotations), so one kernel serves
//! products, sweeps and transfers. The iteration around a hierarchy is in f64, the hierarchy itself in f32 by default.
//!
//! | step | file |
//! |---|---|
//! | unknowns → nodes, constrained components as empty slots | `node_map` |
//! | S_u = A + F Fᵀ in node blocks | `finest` |
//! | near-null space | `rigid_body` |
//! | strong connections, aggregates | `aggregation` |
//! | neighbours across flat cells, which count as far | `reach`, `extension` |
//! | `P_0`, orthonormal on every aggregate | `tentative` |
//! | `P = (I − ω D⁻¹A) P_0` | `prolongation`, `lambda` |
//! | `A_c = PᵀA P` | `galerkin`, `coarse` |
//! | what outlives a change of values | `plan`, `smoothed`, `classical` |
//! | Gauss–Seidel in coloured chunks, products | `sweeps`, `schedule` |
//! | FSAI as smoother, and where it is called for | `fsai_smoother`, `chains` |
//! | coarse nodes that are fine ones | `classical` |
//! | V, W, K | `cycle` |

mod aggregation;
mod chains;
mod classical;
mod coarse;
mod coarsest;
mod cycle;
mod extension;
mod finest;
mod fsai_smoother;
mod galerkin;
mod hierarchy;
mod inverse;
pub(crate) mod lambda;
mod node_map;
mod plan;
mod prolongation;
mod reach;
mod rigid_body;
mod rows;
mod schedule;
pub(crate) mod scratch;
mod settings;
mod smoothed;
pub(crate) mod step_length;
mod summary;
mod sweeps;
mod tentative;
mod transfer;

pub use chains::Smoothing;
pub use inverse::AmgInverse;
pub use plan::AmgPlan;
pub use settings::{Amg, Coarsening, Cycle, Precision, Smoother};
pub use summary::{LevelSummary, Summary};
