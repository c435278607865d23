//! Lines of the body: quickly where all is well, in words where it is not.

use super::error::Defect;
use super::header::{Field, Header};
use super::lines::{Lines, is_blank, shorten, word};

/// One line of a coordinate file, counted from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) row: u32,
    pub(super) column: u32,
    pub(super) value: f64,
}

/// Rows and columns of a piece of a coordinate file, values unseen; `None` when anything is wrong with them.
pub(super) fn places(header: &Header, piece: &[u8]) -> Option<Vec<[u32; 2]>> {
    let mut places = Vec::with_capacity(piece.len() / 24);
    let mut rest = piece;
    loop {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        rest = &rest[start.unwrap_or(rest.len())..];
        if rest.is_empty() {
            return Some(places);
        }
        if rest[0] != b'%' {
            let row = place(&mut rest, header.rows)?;
            let column = place(&mut rest, header.columns)?;
            places.push([row, column]);
        }
        let end = rest.iter().position(|b| *b == b'\n');
        rest = &rest[end.unwrap_or(rest.len())..];
    }
}

/// Takes a row or column, counted from 1, and the blanks behind it, up to a third word on the same line.
fn place(rest: &mut &[u8], limit: usize) -> Option<u32> {
    let start = usize::from(rest.first() == Some(&b'+'));
    let mut number = 0_u64;
    let mut end = start;
    while let Some(b) = rest.get(end).filter(|b| b.is_ascii_digit()) {
        number = number
            .saturating_mul(10)
            .saturating_add(u64::from(b - b'0'));
        end += 1;
    }
    let blank = |b: &u8| b.is_ascii_whitespace() && *b != b'\n';
    let next = end + rest[end..].iter().position(|b| !blank(b))?;
    let fits = end > start && next > end && number >= 1 && number <= limit as u64;
    *rest = &rest[next..];
    // sizes are limited to 32 bits
    (fits && rest[0] != b'\n').then(|| (number - 1) as u32)
}

/// Entries of a piece of a coordinate file; `None` when anything is wrong.
pub(super) fn entries(header: &Header, piece: &[u8]) -> Option<Vec<Entry>> {
    let mut entries = Vec::with_capacity(piece.len() / 24);
    for line in Lines::new(piece).filter(|line| !is_blank(line)) {
        entries.push(entry(header, line).ok()?);
    }
    Some(entries)
}

/// Values of a piece of an array file; `None` when anything is wrong.
pub(super) fn values(header: &Header, piece: &[u8]) -> Option<Vec<f64>> {
    let mut values = Vec::with_capacity(piece.len() / 16);
    for line in Lines::new(piece).filter(|line| !is_blank(line)) {
        values.push(value(header, line, [0, 0]).ok()?);
    }
    Some(values)
}

/// `row column value`.
pub(super) fn entry(header: &Header, line: &[u8]) -> Result<Entry, Defect> {
    let mut rest = line;
    let (row, column, value) = (word(&mut rest), word(&mut rest), word(&mut rest));
    let bad = || Defect::Entry {
        expected: "row column value",
        found: shorten(line),
    };
    if value.is_empty() || !word(&mut rest).is_empty() {
        return Err(bad());
    }
    let row = index(row).ok_or_else(bad)?;
    let column = index(column).ok_or_else(bad)?;
    let (rows, columns) = (header.rows, header.columns);
    if row == 0 || column == 0 || row > rows as u64 || column > columns as u64 {
        return Err(Defect::OutOfRange {
            row,
            column,
            rows,
            columns,
        });
    }
    // Both fit: sizes are limited to 32 bits.
    let value = number(header.field, value, [row as usize, column as usize])?;
    Ok(Entry {
        row: (row - 1) as u32,
        column: (column - 1) as u32,
        value,
    })
}

/// The one value of a line; `place` counts from 1.
pub(super) fn value(header: &Header, line: &[u8], place: [usize; 2]) -> Result<f64, Defect> {
    let mut rest = line;
    let value = word(&mut rest);
    if !word(&mut rest).is_empty() {
        return Err(Defect::Entry {
            expected: "value",
            found: shorten(line),
        });
    }
    number(header.field, value, place)
}

/// A row or column as written; digits only.
fn index(word: &[u8]) -> Option<u64> {
    let digits = word.strip_prefix(b"+").unwrap_or(word);
    if digits.is_empty() {
        return None;
    }
    digits.iter().try_fold(0_u64, |n, b| {
        b.is_ascii_digit()
            .then(|| n.saturating_mul(10).saturating_add(u64::from(b - b'0')))
    })
}

fn number(field: Field, word: &[u8], [row, column]: [usize; 2]) -> Result<f64, Defect> {
    let text = std::str::from_utf8(word).unwrap_or("");
    let parsed = match field {
        Field::Integer => text.parse::<i64>().ok().map(|n| n as f64),
        // Fortran writes 1.5D+03.
        Field::Real => text
            .parse()
            .ok()
            .or_else(|| text.replace(['d', 'D'], "e").parse().ok()),
    };
    match parsed {
        Some(value) if f64::is_finite(value) => Ok(value),
        Some(_) => Err(Defect::NotFinite {
            value: shorten(word),
            row,
            column,
        }),
        None => Err(Defect::Value {
            value: shorten(word),
            field: field.word(),
            row,
            column,
        }),
    }
}
