//! System folders: saddle-point systems exchanged with other codes as Matrix Market files.
//!
//! | file | content | if absent |
//! |---|---|---|
//! | `A.mtx` | n_u × n_u, symmetric | error |
//! | `B1.mtx` | n_u × n_t | error |
//! | `B2.mtx` | n_t × n_u | B1ᵀ |
//! | `H.mtx` | n_t × n_t, the (2,2) block is −H | 0 |
//! | `Q1.mtx` `Q2.mtx` `T.mtx` | n_u × n_p, n_p × n_u, n_p × n_p | no flow |
//! | `rhs_u.mtx` `rhs_t.mtx` `rhs_p.mtx` | vectors | 0 |
//! | `coords.mtx` | n_u rows `x y z component`, or n_u/3 rows `x y z` | unknown |
//! | `faces.mtx` | n_t/3 rows `fracture, centre, area, n, t1, t2`: for readers of the tractions, not needed here | – |
//! | `manifest.json` | sizes, blocks, stabilization, scene, step, Newton iteration, states, units, version | sizes from the matrices |
//!
//! Constrained rows and columns are removed. An imported folder may come from any code: what makes a system impossible
//! is a [`FolderError`]; what is merely remarkable is a [`Finding`]. Absent is what the folder has no entry for: a link that leads
//! nowhere, a folder in the place of a file and a file that does not open are errors, and so is a manifest that contradicts the files.

mod announced;
mod compare;
mod coordinates;
mod entries;
mod error;
mod export;
mod finding;
mod import;
mod inspect;
mod manifest;
mod rigid_body;
mod sizes;

#[cfg(test)]
mod tests;

pub use error::FolderError;
pub use export::write_folder;
pub use finding::{Finding, Remark};
pub use import::{Imported, inspect_blocks, read_folder};
pub use manifest::Manifest;
pub(crate) use rigid_body::rigid_motions;

/// Largest difference of mirrored entries that counts as rounding, relative to the scale of their row and column.
pub const SYMMETRY_TOLERANCE: f64 = 1e-12;
