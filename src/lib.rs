//! The model: from a fractured scene to the blocks of its saddle point.
//!
//! Rooms, each importing only those before it: `units` ◄ `mesh` ◄ {`elasticity`, `contact`} ◄ `scene` ◄ `system` ◄ {`multigrid` ◄ `matrix_free` ◄ `nonlinear`, `jacobian`}; `io` writes; `analytic` knows the answers and imports nothing.

pub mod analytic;
pub mod contact;
pub mod elasticity;
pub mod io;
pub mod jacobian;
pub mod matrix_free;
pub mod memory;
pub mod mesh;
pub mod multigrid;
mod nearest;
pub mod nonlinear;
pub mod scene;
pub mod solve;
pub mod system;
pub mod undetermined;
pub mod units;
