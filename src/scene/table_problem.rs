//! What can be wrong with a table of pressures.

/// A table of pressures that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableProblem {
    /// The file cannot be read.
    #[error("cannot read {file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// A heading that names no unit, or no time.
    #[error(
        "{file}, row 1: the heading must be `{expected}`, {order}; column {column} is `{found}`"
    )]
    Heading {
        /// The file.
        file: String,
        /// What it must be.
        expected: &'static str,
        /// That in words.
        order: &'static str,
        /// Number of the column, from 1.
        column: usize,
        /// What stands there.
        found: String,
    },
    /// A column that is not there.
    #[error("{file} has no column `{column}`; it has: {}", known.join(", "))]
    NoColumn {
        /// The file.
        file: String,
        /// As asked for.
        column: String,
        /// Its columns.
        known: Vec<String>,
    },
    /// A hole, or a word.
    #[error(
        "{file}, row {row}: column `{column}` is `{found}`, which is no number; fill it, or leave the row out"
    )]
    NoNumber {
        /// The file.
        file: String,
        /// Its row, from 1.
        row: usize,
        /// The column.
        column: String,
        /// What stands there.
        found: String,
    },
    /// More cells than the heading has columns: a decimal comma, say.
    #[error(
        "{file}, row {row} has {found} cells and the heading {columns}: cell {found} is `{surplus}`; write decimals with a point, and one cell per column"
    )]
    Surplus {
        /// The file.
        file: String,
        /// Its row, from 1.
        row: usize,
        /// Cells of the row.
        found: usize,
        /// Columns of the heading.
        columns: usize,
        /// The last cell.
        surplus: String,
    },
    /// Two columns of one name.
    #[error(
        "{file}, row 1: columns {first} and {second} are both named `{column}`; give each a name of its own"
    )]
    TwoColumns {
        /// The file.
        file: String,
        /// Their name.
        column: String,
        /// Number of the first, from 1.
        first: usize,
        /// That of the other.
        second: usize,
    },
    /// A number that makes no sense with its unit.
    #[error("{file}, row {row}, column `{column}`: {reason}")]
    Senseless {
        /// The file.
        file: String,
        /// Its row, from 1.
        row: usize,
        /// The column.
        column: String,
        /// Why.
        reason: String,
    },
    /// Times that go back.
    #[error(
        "{place}, {line} {row}: time {time} s does not come after {before} s; sort the {line}s by time"
    )]
    Unsorted {
        /// File or table.
        place: String,
        /// `row` or `column`.
        line: &'static str,
        /// Its row or column, from 1.
        row: usize,
        /// Its time [s].
        time: f64,
        /// That of the row before [s].
        before: f64,
    },
    /// No row at all.
    #[error("{place} has no row; give one at least")]
    Empty {
        /// File or table.
        place: String,
    },
}
