//! Files for other programs.

mod face_table;
mod snapshot;
pub mod vtu;

pub use face_table::face_table;
pub use snapshot::Snapshot;
