//! Files for other programs, and for the same one later.

mod atomic;
mod face_table;
mod fingerprint;
mod grids;
mod pvd;
mod snapshot;
pub mod vtu;

pub use atomic::write_atomically;
pub use face_table::face_table;
pub use fingerprint::Fingerprint;
pub use pvd::{PvdEntry, read_pvd, write_pvd};
pub use snapshot::Snapshot;
