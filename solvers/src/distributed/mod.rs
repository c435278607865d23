//! A saddle point by rows over the ranks of `mpirun`, and RACP around it; needs the feature `petsc`.
//!
//! Nodes are divided by METIS, and numbered rank by rank; a face is where its first node is, with its tractions. Every rank has its rows
//! of A, B, Bᵀ and H, whose columns are its own entries and ghosts behind them. A product fetches the ghosts, inner products add the
//! ranks' sums ([`sum_over_parts`](fracas_operators::LinearOperator::sum_over_parts)), and everything else (Krylov methods, RACP, norms, the
//! judge of errors) is that of one memory. `S_u⁻¹` is PETSc's over all ranks.
//!
//! | step | file |
//! |---|---|
//! | nodes, their graph | `nodes` |
//! | who has what, where | `numbering` |
//! | rows with ghosts, A, B, H as operators | `parts` |
//! | 𝒜, its norms and residuals | `saddle` |
//! | rows of `S_u = A + B C⁻¹Bᵀ` in PETSc | `schur` |
//! | C, W and S_u⁻¹ made RACP | `racp` |

mod nodes;
mod numbering;
mod parts;
mod racp;
mod saddle;
mod schur;

pub use crate::petsc::{OnRank, Ranks};
pub use nodes::Nodes;
pub use numbering::Numbering;
pub use racp::{Contact, prepare, takes};
pub use saddle::{PartStrain, SpreadSaddle};
