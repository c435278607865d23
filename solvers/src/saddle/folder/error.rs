//! Why a folder is not a system.

use fracas_operators::Shape;
use fracas_operators::matrix_market::MatrixMarketError;
use std::path::PathBuf;

/// What to do about a name of the folder that cannot be read.
const MEND: &str = "mend it, or remove it if the system has no such block: only what is not there counts as absent";

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
    /// A name of the folder that leads nowhere.
    #[error("{} is a link to {}, which leads to no file; {}", file.display(), target.display(), MEND)]
    BrokenLink {
        /// The link.
        file: PathBuf,
        /// Where it points.
        target: PathBuf,
    },
    /// Something else under the name of a file.
    #[error("{} is {what} and no file; {}", file.display(), MEND)]
    NotAFile {
        /// The name.
        file: PathBuf,
        /// What is there.
        what: &'static str,
    },
    /// A file that is there and does not open.
    #[error("{} is there and cannot be opened: {source}; {}", file.display(), MEND)]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// The reason of the operating system.
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
    /// No factor of a stabilization.
    #[error("manifest.json says `{says}`: that is true, false or the factor of H, 0 or larger")]
    Stabilization {
        /// Key and value.
        says: String,
    },
    /// No norm.
    #[error("manifest.json says {key} = {says}: a norm is a number, 0 or larger")]
    NormValue {
        /// `norms`, or the norm of one block or right-hand side.
        key: String,
        /// As written.
        says: String,
    },
    /// Numbers that were not written beside the manifest.
    #[error(
        "manifest.json says that {file} has the Frobenius norm {says:e}, but it has {found:e}: it is not the file that was written{}; put that file back, or take its norm out of the manifest", scene.as_ref().map_or(String::new(), |scene| format!(" for scene \"{scene}\""))
    )]
    Norm {
        /// The file.
        file: String,
        /// In the manifest.
        says: f64,
        /// In the file.
        found: f64,
        /// Of the manifest.
        scene: Option<String>,
    },
    /// A diagonal block must be square.
    #[error("{file} is {found}; it must be square")]
    NotSquare {
        /// The file.
        file: &'static str,
        /// Its size.
        found: Shape,
    },
    /// Sizes far beyond the entries.
    #[error(
        "{file} says {unknowns} {lines}, but {listed} only {entries} entries, so that most {lines} would be empty: the sizes in its header are wrong"
    )]
    Hollow {
        /// The file with the size.
        file: &'static str,
        /// Rows, or columns.
        lines: &'static str,
        /// The files with entries there, as a subject with its verb.
        listed: &'static str,
        /// Rows or columns.
        unknowns: usize,
        /// Entries of these files.
        entries: usize,
    },
    /// The manifest announces another size.
    #[error(
        "manifest.json says {key} = {announced}, but {file} gives {found}; one of them is of another system"
    )]
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
    /// The manifest announces a block that is not there.
    #[error(
        "manifest.json says {says}, but the folder holds no {file}: without it this is another system; put the file back, or correct the manifest"
    )]
    Lost {
        /// What the manifest says.
        says: String,
        /// The file.
        file: String,
    },
    /// The manifest excludes a block that is there.
    #[error(
        "manifest.json says {says}, but {file} holds {entries} nonzero entries: with them this is another system; remove the file, or correct the manifest"
    )]
    Unannounced {
        /// What the manifest says.
        says: String,
        /// The file.
        file: String,
        /// Its entries.
        entries: usize,
    },
    /// The manifest has an empty list beside files that belong into it.
    #[error(
        "{}/manifest.json says {key} = [], but {file} is there: name what the folder holds, or leave {key} out", folder.display()
    )]
    EmptyList {
        /// The folder.
        folder: PathBuf,
        /// `blocks` or `right_hand_sides`.
        key: &'static str,
        /// The first file that belongs into the list.
        file: &'static str,
    },
    /// States that are not those of the faces.
    #[error(
        "manifest.json gives {states} states of faces, but B1.mtx has {n_t} columns: {expected}"
    )]
    States {
        /// States in the manifest.
        states: usize,
        /// Columns of B1.
        n_t: usize,
        /// How many there must be.
        expected: &'static str,
    },
    /// A state that does not exist.
    #[error(
        "manifest.json gives face {face} the state {state}, expected 0 (stick), 1 (new-slip), 2 (slip) or 3 (open)"
    )]
    State {
        /// Face, counted from 1.
        face: usize,
        /// As written.
        state: u8,
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
    /// An entry of which products leave the range of f64.
    #[error(
        "{file}, row {row}, column {column}: the entry {value:e} is out of range; choose units in which entries are 0 or from {:e} to {:e} in size",
        super::entries::LEAST,
        super::entries::MOST
    )]
    Extreme {
        /// The file.
        file: String,
        /// Row, counted from 1.
        row: usize,
        /// Column, counted from 1.
        column: usize,
        /// Its value.
        value: f64,
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
    /// Components that are counted from 1.
    #[error(
        "{file}: the components are 1, 2 and 3; they count from 0 (x is 0, y is 1, z is 2): subtract 1 from the last column"
    )]
    ComponentsFromOne {
        /// The file.
        file: &'static str,
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
