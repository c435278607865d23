//! Typed tables.

use fracas_figures::{format_real, quote};
use std::fmt::Write as _;

/// A column: name and unit (empty for pure numbers).
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Column {
    /// Heading.
    pub name: String,
    /// Unit, or empty.
    pub unit: String,
}

/// One value.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A name.
    Text(String),
    /// A count.
    Integer(i64),
    /// A number; full precision in the CSV, four digits on the page.
    Real(f64),
    /// The method failed here: the "X" of the published tables.
    Failed,
    /// Nothing to report.
    Missing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}
impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}
impl From<usize> for Cell {
    fn from(n: usize) -> Self {
        i64::try_from(n).map_or(Self::Real(n as f64), Self::Integer)
    }
}
impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}
impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

impl Cell {
    /// For the page.
    pub(super) fn display(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Integer(n) => n.to_string(),
            Self::Real(value) => format_real(*value),
            Self::Failed => "✗".into(),
            Self::Missing => "–".into(),
        }
    }

    fn csv(&self) -> String {
        match self {
            Self::Text(text) => quote(text),
            Self::Integer(n) => n.to_string(),
            Self::Real(value) if value.is_finite() => value.to_string(),
            Self::Failed => "X".into(),
            Self::Real(_) | Self::Missing => String::new(),
        }
    }

    pub(super) fn is_number(&self) -> bool {
        !matches!(self, Self::Text(_))
    }
}

/// A table: a CSV file and a place in the report.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// File name without extension.
    pub id: String,
    /// One sentence above the table.
    pub caption: String,
    /// Headings.
    pub columns: Vec<Column>,
    /// Rows, each with a cell per column.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// An empty table; headings are written `name` or `name [unit]`.
    pub fn new(id: &str, caption: &str, headings: &[&str]) -> Self {
        let column =
            |heading: &&str| match heading.strip_suffix(']').and_then(|h| h.rsplit_once(" [")) {
                Some((name, unit)) => Column {
                    name: name.into(),
                    unit: unit.into(),
                },
                None => Column {
                    name: (*heading).into(),
                    unit: String::new(),
                },
            };
        Self {
            id: id.into(),
            caption: caption.into(),
            columns: headings.iter().map(column).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row, which must have a cell per column.
    pub fn push<const N: usize>(&mut self, row: [Cell; N]) {
        assert_eq!(
            N,
            self.columns.len(),
            "row of {N} cells in table {} of {} columns",
            self.id,
            self.columns.len()
        );
        self.rows.push(row.into());
    }

    /// Comma-separated values with a heading line; failures are `X`, missing values are empty.
    pub fn to_csv(&self) -> String {
        let heading = |c: &Column| {
            if c.unit.is_empty() {
                quote(&c.name)
            } else {
                quote(&format!("{} [{}]", c.name, c.unit))
            }
        };
        let mut text = self
            .columns
            .iter()
            .map(heading)
            .collect::<Vec<_>>()
            .join(",");
        text.push('\n');
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{}",
                row.iter().map(Cell::csv).collect::<Vec<_>>().join(",")
            );
        }
        text
    }
}
