//! Banner and sizes.

use super::error::Defect;
use super::lines::{Lines, shorten};

/// Which entries a file stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// All of them.
    General,
    /// One triangle and the diagonal; `a_ji = a_ij`.
    Symmetric,
    /// One strict triangle; `a_ji = −a_ij`.
    Skew,
}

impl Symmetry {
    /// The word in the banner.
    pub const fn word(self) -> &'static str {
        match self {
            Self::General => "general",
            Self::Symmetric => "symmetric",
            Self::Skew => "skew-symmetric",
        }
    }
}

/// How values are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Layout {
    /// `row column value`, this many entries.
    Coordinate { entries: usize },
    /// Values column after column.
    Array,
}

/// The kind of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Field {
    Real,
    Integer,
}

impl Field {
    pub(super) const fn word(self) -> &'static str {
        match self {
            Self::Real => "real",
            Self::Integer => "integer",
        }
    }
}

/// What the first lines say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Header {
    pub(super) layout: Layout,
    pub(super) field: Field,
    pub(super) symmetry: Symmetry,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Line of the sizes, counted from 1.
    pub(super) size_line: usize,
}

impl Header {
    /// First row of column j that an array lists.
    pub(super) fn first_row(&self, j: usize) -> usize {
        match self.symmetry {
            Symmetry::General => 0,
            Symmetry::Symmetric => j,
            Symmetry::Skew => j + 1,
        }
    }

    /// Values that the body must hold.
    pub(super) fn expected(&self) -> usize {
        let n = self.rows;
        match (self.layout, self.symmetry) {
            (Layout::Coordinate { entries }, _) => entries,
            (Layout::Array, Symmetry::General) => n.saturating_mul(self.columns),
            (Layout::Array, Symmetry::Symmetric) => n * (n + 1) / 2,
            (Layout::Array, Symmetry::Skew) => n * n.saturating_sub(1) / 2,
        }
    }
}

/// Reads banner, comments and sizes; `lines` then stands at the first line of the body.
pub(super) fn parse_header(lines: &mut Lines<'_>) -> Result<Header, (usize, Defect)> {
    let banner = lines.next().unwrap_or_default();
    let (coordinate, field, symmetry) = parse_banner(banner).map_err(|d| (1, d))?;
    loop {
        let Some(line) = lines.next() else {
            return Err((lines.number().max(1), Defect::NoSize));
        };
        if line.starts_with(b"%") || line.trim_ascii().is_empty() {
            continue;
        }
        let at = lines.number();
        return parse_sizes(line, coordinate)
            .and_then(|(rows, columns, layout)| {
                if symmetry != Symmetry::General && rows != columns {
                    let symmetry = symmetry.word();
                    return Err(Defect::NotSquare {
                        symmetry,
                        rows,
                        columns,
                    });
                }
                Ok(Header {
                    layout,
                    field,
                    symmetry,
                    rows,
                    columns,
                    size_line: at,
                })
            })
            .map_err(|d| (at, d));
    }
}

fn parse_banner(line: &[u8]) -> Result<(bool, Field, Symmetry), Defect> {
    let text = String::from_utf8_lossy(line).to_ascii_lowercase();
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let bad = || Defect::Banner {
        found: shorten(line),
    };
    let ["%%matrixmarket", "matrix", layout, field, symmetry] = words[..] else {
        return Err(bad());
    };
    let coordinate = match layout {
        "coordinate" => true,
        "array" => false,
        _ => return Err(bad()),
    };
    let unsupported = |advice| {
        Err(Defect::Field {
            field: field.into(),
            advice,
        })
    };
    let field = match field {
        "real" | "double" => Field::Real,
        "integer" => Field::Integer,
        "complex" => {
            return unsupported(
                "only real systems are solved; write real and imaginary parts as a real system of twice the size",
            );
        }
        "pattern" => {
            return unsupported("a pattern has no values; write the matrix with the field `real`");
        }
        _ => return Err(bad()),
    };
    let symmetry = match symmetry {
        "general" => Symmetry::General,
        "symmetric" => Symmetry::Symmetric,
        "skew-symmetric" => Symmetry::Skew,
        "hermitian" => {
            return Err(Defect::Field {
                field: "hermitian".into(),
                advice: "a real Hermitian matrix is `symmetric`",
            });
        }
        _ => return Err(bad()),
    };
    Ok((coordinate, field, symmetry))
}

fn parse_sizes(line: &[u8], coordinate: bool) -> Result<(usize, usize, Layout), Defect> {
    let expected = if coordinate {
        "rows columns entries"
    } else {
        "rows columns"
    };
    let bad = || Defect::Size {
        expected,
        found: shorten(line),
    };
    let text = std::str::from_utf8(line).map_err(|_| bad())?;
    let sizes: Vec<u64> = text
        .split_ascii_whitespace()
        .map(|word| word.parse().map_err(|_| bad()))
        .collect::<Result<_, _>>()?;
    // 32-bit indices (`SparseMatrix`)
    let limited = |count: u64, what, limit: u64| match usize::try_from(count) {
        Ok(n) if count <= limit => Ok(n),
        _ => Err(Defect::TooLarge { what, count, limit }),
    };
    let index_limit = u64::from(u32::MAX);
    match (&sizes[..], coordinate) {
        ([rows, columns, entries], true) => Ok((
            limited(*rows, "rows", index_limit)?,
            limited(*columns, "columns", index_limit)?,
            Layout::Coordinate {
                entries: limited(*entries, "entries", 1 << 40)?,
            },
        )),
        ([rows, columns], false) => Ok((
            limited(*rows, "rows", index_limit)?,
            limited(*columns, "columns", index_limit)?,
            Layout::Array,
        )),
        _ => Err(bad()),
    }
}
