//! Why a checkpoint cannot be used.

use super::VERSION;
use std::io;
use std::path::PathBuf;

/// A checkpoint that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file system says no.
    #[error("cannot read the checkpoint {}: {source}", path.display())]
    Read {
        /// File or folder.
        path: PathBuf,
        /// Reason.
        source: io::Error,
    },
    /// A folder without any.
    #[error("{} holds no checkpoint", path.display())]
    None {
        /// Folder.
        path: PathBuf,
    },
    /// Another kind of file.
    #[error("{} is no checkpoint of fracas", path.display())]
    Foreign {
        /// File.
        path: PathBuf,
    },
    /// Written by another version.
    #[error("the checkpoint {} has layout {found}, this program reads layout {VERSION}", path.display())]
    Version {
        /// File.
        path: PathBuf,
        /// Its layout.
        found: u64,
    },
    /// Shorter or longer than it says.
    #[error("the checkpoint {} is damaged: it has {found} of {expected} bytes; take the one before it", path.display())]
    Length {
        /// File.
        path: PathBuf,
        /// Bytes in the file.
        found: u64,
        /// Bytes that its header announces.
        expected: u64,
    },
    /// Changed since it was written.
    #[error("the checkpoint {} is damaged: its checksum does not fit; take the one before it", path.display())]
    Checksum {
        /// File.
        path: PathBuf,
    },
    /// Of other unknowns.
    #[error("the checkpoint {} holds the fields {found}, this program reads u and t, with p, e_v, s and on where there are any", path.display())]
    OtherFields {
        /// File.
        path: PathBuf,
        /// Their letters.
        found: String,
    },
    /// Of another mesh or numbering.
    #[error("the checkpoint {} belongs to another mesh (or other fractures or held sides) than this scene", path.display())]
    OtherMesh {
        /// File.
        path: PathBuf,
    },
    /// Of the same mesh under other physics.
    #[error("the checkpoint {} belongs to a scene with the same mesh but other materials, friction or loads", path.display())]
    OtherScene {
        /// File.
        path: PathBuf,
    },
}
