//! Algebraic multigrid for vector elasticity on fractured bodies: levels for a cycle of [`multigrid`](crate::multigrid).
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
//! | `P = (I − ω D⁻¹A) P_0` | `prolongation` |
//! | `A_c = PᵀA P` | `galerkin`, `coarse` |
//! | what outlives a change of values | `plan`, `smoothed`, `classical` |
//! | what a level is made from | `matrix` |
//! | Gauss–Seidel in coloured chunks, products, by half of the matrix | `half`, `sweeps`, `sums`, `schedule` |
//! | A kept by half | `halved` |
//! | Gauss–Seidel and FSAI as smoothers, and where FSAI is called for | `gauss_seidel`, `fsai`, `chains` |
//! | coarse nodes that are fine ones | `classical` |
//!
mod aggregation;
mod build;
mod chains;
mod classical;
mod coarse;
mod extension;
mod finest;
mod fsai;
mod galerkin;
mod gauss_seidel;
mod half;
mod halved;
mod hierarchy;
mod matrix;
pub(crate) mod node_map;
mod plan;
mod prolongation;
mod reach;
mod rigid_body;
mod schedule;
mod settings;
mod smoothed;
mod sums;
mod sweeps;
mod tentative;
mod transfer;

pub use halved::HalvedMatrix;
pub use plan::AmgPlan;
pub use settings::{Amg, Coarsening};
