//! What is remarkable about an imported system, without being an error.

use crate::words::by_number;
use std::fmt;

/// A remark with its place. Rows, columns and lines count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The file.
    pub file: String,
    /// First row concerned.
    pub row: Option<usize>,
    /// First column concerned.
    pub column: Option<usize>,
    /// What was found.
    pub remark: Remark,
}

impl Finding {
    /// A remark about a file as a whole.
    pub(super) fn file(file: &str, remark: Remark) -> Self {
        Self {
            file: file.into(),
            row: None,
            column: None,
            remark,
        }
    }

    /// A remark that starts at a row, counted from 0 here.
    pub(super) fn at_row(file: &str, row: usize, remark: Remark) -> Self {
        Self {
            row: Some(row + 1),
            ..Self::file(file, remark)
        }
    }

    /// A remark that starts at a column, counted from 0 here.
    pub(super) fn at_column(file: &str, column: usize, remark: Remark) -> Self {
        Self {
            column: Some(column + 1),
            ..Self::file(file, remark)
        }
    }

    /// A remark about an entry, counted from 0 here.
    pub(super) fn at_entry(file: &str, row: usize, column: usize, remark: Remark) -> Self {
        Self {
            row: Some(row + 1),
            column: Some(column + 1),
            ..Self::file(file, remark)
        }
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(row) = self.row {
            write!(f, ", row {row}")?;
        }
        if let Some(column) = self.column {
            write!(f, ", column {column}")?;
        }
        write!(f, ": {}", self.remark)
    }
}

/// What can be remarkable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Remark {
    /// Entries listed more than once.
    #[error(
        "{count} {} listed more than once (first in line {line}), and added up",
        by_number(*count, "entry is", "entries are")
    )]
    DuplicatesSummed {
        /// Surplus entries.
        count: usize,
        /// Line of the first one.
        line: usize,
    },
    /// A given in general storage, symmetric to rounding.
    #[error("stored as general; symmetric to {relative:.1e} of its diagonal")]
    SymmetricToRounding {
        /// Largest difference of mirrored entries, relative to the diagonal.
        relative: f64,
    },
    /// Rows of A without entries.
    #[error(
        "{count} zero {}: A is singular there; only B1 can hold {}",
        by_number(*count, "row", "rows"), by_number(*count, "this unknown", "these unknowns")
    )]
    ZeroRows {
        /// How many.
        count: usize,
    },
    /// A diagonal that no positive semi-definite matrix has.
    #[error(
        "{count} diagonal {} negative, or zero in a nonzero row (first: {value:e}): A is not positive semi-definite",
        by_number(*count, "entry is", "entries are")
    )]
    BadDiagonal {
        /// How many.
        count: usize,
        /// The first one.
        value: f64,
    },
    /// Rows that hold nothing but their diagonal.
    #[error(
        "{count} {} diagonal and no entry of B1: constrained unknowns left in the system? They distort condition numbers and multigrid; remove them",
        by_number(*count, "row holds only its", "rows hold only their")
    )]
    ConstrainedRows {
        /// How many.
        count: usize,
    },
    /// Tractions that touch no displacement.
    #[error(
        "{count} empty {} no displacement (every node of the face constrained?); only H can determine {}",
        by_number(*count, "column: a traction that touches", "columns: tractions that touch"),
        by_number(*count, "it", "them")
    )]
    EmptyColumns {
        /// How many.
        count: usize,
    },
    /// Tractions that act alike.
    #[error(
        "{count} {} (first: of column {of}): these tractions act alike, and without H the system is singular and tells what they bear together alone; is a face given twice?",
        by_number(*count, "column is a multiple of another", "columns are multiples of others")
    )]
    EqualColumns {
        /// How many.
        count: usize,
        /// The column that the first one is a multiple of, counted from 1.
        of: usize,
    },
    /// More tractions than displacements, without H.
    #[error(
        "{n_t} tractions on {n_u} displacements, without H: the system is singular, and some tractions are one of many answers"
    )]
    TooManyTractions {
        /// Columns.
        n_t: usize,
        /// Rows.
        n_u: usize,
    },
    /// Pressures that nothing determines.
    #[error(
        "{count} {} zero here and in Q2.mtx: nothing determines {} and the system is singular; add storage, a conductivity or a prescribed pressure",
        by_number(*count, "row is", "rows are"), by_number(*count, "this pressure", "these pressures")
    )]
    UndeterminedPressures {
        /// How many.
        count: usize,
    },
    /// Volumes that pressure makes smaller.
    #[error(
        "{count} {} column of Q1.mtx (q2_i·q1_i > 0): pressure makes the fracture thinner there; with Q1 = −B_n expected is Q2 = B_nᵀ/Δt",
        by_number(*count, "row has the sign of its", "rows have the sign of their")
    )]
    ClosingPressures {
        /// How many.
        count: usize,
    },
    /// T with a diagonal that no conductivity and no storage has.
    #[error(
        "{count} diagonal {} negative (first: {value:e}): T may be indefinite",
        by_number(*count, "entry is", "entries are")
    )]
    NegativeDiagonalOfT {
        /// How many.
        count: usize,
        /// The first one.
        value: f64,
    },
    /// B2 repeats B1.
    #[error("equal to B1ᵀ to rounding: treated as absent, symmetric methods apply")]
    EqualsTranspose,
    /// The other sign convention.
    #[error(
        "equal to −B1ᵀ: a skew convention; kept as it is (change the sign of the contact rows for a symmetric system)"
    )]
    EqualsNegativeTranspose,
    /// A slip Jacobian.
    #[error(
        "differs from B1ᵀ (largest: {b2:e} against {b1:e}): unsymmetric, as faces that slip or are open make it"
    )]
    DiffersFromTranspose {
        /// Entry of B2.
        b2: f64,
        /// Mirrored entry of B1.
        b1: f64,
    },
    /// A matrix of zeros.
    #[error("holds no nonzero entry: treated as absent")]
    Zero,
    /// H with a slip block.
    #[error(
        "unsymmetric: {value:e} here, {mirrored:e} mirrored, as faces that slip or are open make it; bounds for symmetric H do not apply"
    )]
    Unsymmetric {
        /// Entry.
        value: f64,
        /// Mirrored entry.
        mirrored: f64,
    },
    /// H with negative diagonal entries.
    #[error(
        "{count} diagonal {} negative (first: {value:e}): H is indefinite, as open and slipping faces make it; C is not built from {}",
        by_number(*count, "entry is", "entries are"), by_number(*count, "this row", "these rows")
    )]
    NegativeDiagonal {
        /// How many.
        count: usize,
        /// The first one.
        value: f64,
    },
    /// H with the sign of the (2,2) block.
    #[error(
        "{} not zero {} negative (first: {value:e}): is this −H? The system is [A B1; B2 −H] with H ⪰ 0; change the sign",
        match count { 1 => "the one diagonal entry that is".to_owned(), n => format!("all {n} diagonal entries that are") },
        by_number(*count, "is", "are")
    )]
    OppositeSign {
        /// How many.
        count: usize,
        /// The first one.
        value: f64,
    },
    /// No coordinates.
    #[error("absent: rigid-body modes and plots on the mesh are not available")]
    NoCoordinates,
    /// Rotations that are no rigid motion of A.
    #[error(
        "rotations about the axes cost force in {wrong} of the {free} rows where translations cost none (up to {worst:.1e} of the size of a row): the coordinates do not fit A, and multigrid would build on wrong rigid-body modes"
    )]
    RotationsCostForce {
        /// Rows where a rotation costs force.
        wrong: usize,
        /// Rows where translations cost none.
        free: usize,
        /// Largest force, relative to `Σ_j |a_ij| |x_j − x_i|`.
        worst: f64,
    },
    /// Translations that are no rigid motion of A anywhere.
    #[error(
        "translations along x, y, z cost force in every row of A: the components do not fit A, or every row touches a constrained unknown; multigrid would build on wrong rigid-body modes"
    )]
    TranslationsCostForce,
    /// No right-hand side at all.
    #[error("absent, and so are the other right-hand sides")]
    NoRightHandSide,
    /// Other right-hand sides are there, forces are not.
    #[error("absent: forces count as 0")]
    NoForces,
    /// Right-hand sides of zeros.
    #[error("absent, and the right-hand sides that are there hold zeros only: the solution is 0")]
    NoForcesAndZero,
    /// No entry of any right-hand side.
    #[error("it and all other right-hand sides hold zeros only: the solution is 0")]
    ZeroRightHandSide,
    /// No manifest.
    #[error("absent: sizes are taken from the matrices")]
    NoManifest,
    /// A file that plays no role.
    #[error("not read: it is none of the files of a system folder")]
    NotRead,
}
