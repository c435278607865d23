//! Why a folder is not a system.

use fracas_operators::Shape;
use fracas_operators::matrix_market::MatrixMarketError;
use std::path::PathBuf;

/// A folder that cannot be read as a system: which file, which row, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum FolderError {
    /// Not a folder.
    #[error("{} is not a folder; a system folder holds at least A.mtx and B1.mtx", folder.display())]
    NotAFolder {
        /// As given.
        folder: PathBuf,
    },
    /// A file without which there is no system.
    #[error("{} holds no {file}; a system folder needs A.mtx and B1.mtx{}", folder.display(), near.as_ref().map_or(String::new(), |n| format!(" (found {n}: file names are case-sensitive)")))]
    Missing {
        /// The folder.
        folder: PathBuf,
        /// The file.
        file: &'static str,
        /// A file whose name differs in case only.
        near: Option<String>,
    },
    /// Flow needs Q1, Q2 and T together.
    #[error("{} holds {present} but no {missing}; flow needs Q1.mtx, Q2.mtx and T.mtx", folder.display())]
    IncompleteFlow {
        /// The folder.
        folder: PathBuf,
        /// A file that is there.
        present: &'static str,
        /// One that is not.
        missing: &'static str,
    },
    /// A matrix file with a defect.
    #[error(transparent)]
    File(#[from] MatrixMarketError),
    /// The operating system refuses.
    #[error("{}: {source}", file.display())]
    Io {
        /// File or folder.
        file: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// The manifest is not the JSON that we read.
    #[error("{}: {source}", file.display())]
    Manifest {
        /// The file.
        file: PathBuf,
        /// What and where (line and column).
        source: serde_json::Error,
    },
    /// Sizes of two files contradict each other.
    #[error("{file} is {found}, expected {expected} because {other} is {other_shape}")]
    Sizes {
        /// The file that does not fit.
        file: &'static str,
        /// Its size.
        found: Shape,
        /// What it must be.
        expected: Shape,
        /// The file that says so.
        other: &'static str,
        /// Its size.
        other_shape: Shape,
    },
    /// A matrix without rows or columns.
    #[error("{file} is {found}: a saddle point needs at least one displacement and one traction")]
    Empty {
        /// The file.
        file: &'static str,
        /// Its shape.
        found: Shape,
    },
    /// A diagonal block must be square.
    #[error("{file} is {found}; it must be square")]
    NotSquare {
        /// The file.
        file: &'static str,
        /// Its size.
        found: Shape,
    },
    /// The manifest announces another size.
    #[error("manifest.json says {key} = {announced}, but {file} gives {found}")]
    Announced {
        /// `n_u`, `n_t`, `n_p`.
        key: &'static str,
        /// In the manifest.
        announced: usize,
        /// In the file.
        found: usize,
        /// The file.
        file: &'static str,
    },
    /// A must be symmetric.
    #[error(
        "{file} is not symmetric: entry ({row}, {column}) is {value:e}, entry ({column}, {row}) is {mirrored:e}; the stiffness must be symmetric to {:e} of its diagonal (an unsymmetric Jacobian belongs to B1, B2 and H)",
        super::SYMMETRY_TOLERANCE
    )]
    Asymmetric {
        /// The file.
        file: &'static str,
        /// Row of the worst pair, counted from 1.
        row: usize,
        /// Column of the worst pair, counted from 1.
        column: usize,
        /// Its value.
        value: f64,
        /// The value on the other side of the diagonal.
        mirrored: f64,
    },
    /// A row of the coordinates that is not `x y z component`.
    #[error("{file}, row {row}: the component is {value}, expected 0, 1 or 2 (x, y, z)")]
    Component {
        /// The file.
        file: &'static str,
        /// Row, counted from 1.
        row: usize,
        /// As written.
        value: f64,
    },
    /// Coordinates of the wrong size.
    #[error(
        "coords.mtx is {found}, expected {n_u}×4 (x y z component per unknown){} because A.mtx has {n_u} rows", if n_u % 3 == 0 { format!(" or {}×3 (x y z per node)", n_u / 3) } else { String::new() }
    )]
    CoordinateShape {
        /// Its size.
        found: Shape,
        /// Displacement unknowns.
        n_u: usize,
    },
}
