//! Files for other programs, and for the same one later.

mod atomic;
mod checkpoint;
mod face_table;
mod fields;
mod fingerprint;
mod grids;
mod new_folder;
mod pvd;
mod snapshot;
pub mod vtu;
mod vtu_fields;

pub use crate::digest::Hash;
pub use atomic::{unfinished, write_atomically};
pub use checkpoint::{CheckpointError, Checkpoints, newest_checkpoint, read_checkpoint};
pub use face_table::face_table;
pub use fields::Fields;
pub use fingerprint::Fingerprint;
pub use new_folder::NewFolder;
pub use pvd::{PvdEntry, read_pvd, write_pvd};
pub use snapshot::Snapshot;
pub use vtu_fields::read_field;
