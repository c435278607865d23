//! What can be wrong with a Matrix Market file, and where.

use std::path::PathBuf;

/// A file that cannot be read: which file, which line, what, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum MatrixMarketError {
    /// The operating system refuses.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// Its reason.
        source: std::io::Error,
    },
    /// The content is not a matrix that we read.
    #[error("{}, line {line}: {defect}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong.
        defect: Defect,
    },
}

impl MatrixMarketError {
    /// What is wrong with the content, if the file could be read at all.
    pub fn defect(&self) -> Option<&Defect> {
        match self {
            Self::Io { .. } => None,
            Self::Content { defect, .. } => Some(defect),
        }
    }
}

/// What is wrong in one line. Rows, columns and lines count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Defect {
    /// The first line is not a banner.
    #[error(
        "expected the banner `%%MatrixMarket matrix (coordinate|array) (real|integer) (general|symmetric|skew-symmetric)`, found `{found}`"
    )]
    Banner {
        /// The line, shortened.
        found: String,
    },
    /// A field that is not a real number.
    #[error("the field `{field}` is not supported: {advice}")]
    Field {
        /// `complex`, `pattern`, …
        field: String,
        /// What to do.
        advice: &'static str,
    },
    /// The line with the sizes.
    #[error("expected the sizes `{expected}` as whole numbers, found `{found}`")]
    Size {
        /// `rows columns entries` or `rows columns`.
        expected: &'static str,
        /// The line, shortened.
        found: String,
    },
    /// The file ends before its sizes.
    #[error("the file ends before the line with its sizes")]
    NoSize,
    /// More rows, columns or entries than an index holds.
    #[error("{count} {what} are more than this build can index ({limit})")]
    TooLarge {
        /// `rows`, `columns`, `entries`.
        what: &'static str,
        /// As the file says.
        count: u64,
        /// Largest possible.
        limit: u64,
    },
    /// A symmetric matrix must be square.
    #[error("a {symmetry} matrix must be square, this one is {rows}×{columns}")]
    NotSquare {
        /// `symmetric` or `skew-symmetric`.
        symmetry: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
    /// Fewer entries than announced.
    #[error("truncated: the sizes announce {expected} entries, the file ends after {found}")]
    Truncated {
        /// Announced.
        expected: usize,
        /// Present.
        found: usize,
    },
    /// More entries than announced.
    #[error("too many entries: the sizes announce {expected}, the file holds {found}")]
    TooMany {
        /// Announced.
        expected: usize,
        /// Present.
        found: usize,
    },
    /// A line of the wrong form.
    #[error("expected `{expected}`, found `{found}`")]
    Entry {
        /// `row column value` or `value`.
        expected: &'static str,
        /// The line, shortened.
        found: String,
    },
    /// A row or column outside the matrix.
    #[error(
        "the entry ({row}, {column}) lies outside the {rows}×{columns} matrix (indices count from 1)"
    )]
    OutOfRange {
        /// Row as written.
        row: u64,
        /// Column as written.
        column: u64,
        /// Rows of the matrix.
        rows: usize,
        /// Columns of the matrix.
        columns: usize,
    },
    /// NaN, ±inf, or a number beyond the range of `f64`.
    #[error("the value `{value}` in row {row}, column {column} is not a finite number")]
    NotFinite {
        /// As written.
        value: String,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
    },
    /// A value that is not a number of the announced field.
    #[error("the value `{value}` in row {row}, column {column} is not a {field} number")]
    Value {
        /// As written.
        value: String,
        /// `real` or `integer`.
        field: &'static str,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
    },
    /// Symmetric storage that holds an entry and its mirror image.
    #[error(
        "the {symmetry} file stores both ({row}, {column}) and ({column}, {row}); keep one triangle, or declare the file general"
    )]
    BothTriangles {
        /// `symmetric` or `skew-symmetric`.
        symmetry: &'static str,
        /// Row.
        row: usize,
        /// Column.
        column: usize,
    },
    /// A skew-symmetric matrix with a diagonal.
    #[error("a skew-symmetric matrix has no diagonal, the file stores ({row}, {row}) = {value:e}")]
    SkewDiagonal {
        /// Row and column.
        row: usize,
        /// The entry.
        value: f64,
    },
    /// A vector was expected.
    #[error("expected a vector (one column), found a {rows}×{columns} matrix")]
    NotAVector {
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
}
