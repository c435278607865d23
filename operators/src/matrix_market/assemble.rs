//! Entries in file order → rows, with mirrored triangles and summed duplicates.

use super::error::Defect;
use super::header::{Header, Symmetry};
use crate::sparse::SparseMatrix;
use rayon::prelude::*;

/// One line of a coordinate file, counted from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) row: u32,
    pub(super) column: u32,
    pub(super) value: f64,
}

/// Surplus entries, and the place in the file of the first one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surplus {
    pub(super) count: usize,
    pub(super) first: usize,
}

/// One stored or mirrored entry of a row; `from` is its place in the file.
#[derive(Clone, Copy)]
struct Item {
    column: u32,
    from: u32,
    mirrored: bool,
    value: f64,
}

/// Counting sort by rows (both triangles), then by column within each row; equal places are added in file order.
pub(super) fn rows(
    header: &Header,
    entries: &[Entry],
) -> Result<(SparseMatrix<f64>, Option<Surplus>), (usize, Defect)> {
    let sign = match header.symmetry {
        Symmetry::General => None,
        Symmetry::Symmetric => Some(1.0),
        Symmetry::Skew => Some(-1.0),
    };
    if entries.len() >= u32::MAX as usize {
        let (count, limit) = (entries.len() as u64, u64::from(u32::MAX) - 1);
        return Err((
            0,
            Defect::TooLarge {
                what: "entries",
                count,
                limit,
            },
        ));
    }
    let mut offsets = vec![0_usize; header.rows + 1];
    for (k, e) in entries.iter().enumerate() {
        if sign == Some(-1.0) && e.row == e.column && e.value != 0.0 {
            return Err((
                k,
                Defect::SkewDiagonal {
                    row: e.row as usize + 1,
                    value: e.value,
                },
            ));
        }
        offsets[e.row as usize + 1] += 1;
        if sign.is_some() && e.row != e.column {
            offsets[e.column as usize + 1] += 1;
        }
    }
    for i in 0..header.rows {
        offsets[i + 1] += offsets[i];
    }
    let blank = Item {
        column: 0,
        from: 0,
        mirrored: false,
        value: 0.0,
    };
    let mut items = vec![blank; offsets[header.rows]];
    let mut next = offsets.clone();
    let mut place = |row: u32, item: Item| {
        let slot = &mut next[row as usize];
        items[*slot] = item;
        *slot += 1;
    };
    for (k, e) in entries.iter().enumerate() {
        let from = k as u32;
        place(
            e.row,
            Item {
                column: e.column,
                from,
                mirrored: false,
                value: e.value,
            },
        );
        if let Some(sign) = sign
            && e.row != e.column
        {
            place(
                e.column,
                Item {
                    column: e.row,
                    from,
                    mirrored: true,
                    value: sign * e.value,
                },
            );
        }
    }
    compress(header, offsets, items)
}

/// Sorts each row, adds equal columns, and packs.
fn compress(
    header: &Header,
    offsets: Vec<usize>,
    mut items: Vec<Item>,
) -> Result<(SparseMatrix<f64>, Option<Surplus>), (usize, Defect)> {
    let mut parts: Vec<&mut [Item]> = Vec::with_capacity(header.rows);
    let mut rest = &mut items[..];
    for i in 0..header.rows {
        let (part, tail) = rest.split_at_mut(offsets[i + 1] - offsets[i]);
        parts.push(part);
        rest = tail;
    }
    parts
        .par_iter_mut()
        .with_min_len(1024)
        .for_each(|row| row.sort_unstable_by_key(|t| (t.column, t.from)));

    let mut surplus: Option<Surplus> = None;
    let mut starts = Vec::with_capacity(header.rows + 1);
    let (mut columns, mut values) = (
        Vec::with_capacity(offsets[header.rows]),
        Vec::with_capacity(offsets[header.rows]),
    );
    starts.push(0);
    for (i, row) in parts.iter().enumerate() {
        for same in row.chunk_by(|a, b| a.column == b.column) {
            if let Some(other) = same.iter().find(|t| t.mirrored != same[0].mirrored) {
                let symmetry = header.symmetry.word();
                let defect = Defect::BothTriangles {
                    symmetry,
                    row: i + 1,
                    column: other.column as usize + 1,
                };
                return Err((same[0].from.max(other.from) as usize, defect));
            }
            if same.len() > 1 && !same[0].mirrored {
                let first = same[1].from as usize;
                let s = surplus.get_or_insert(Surplus { count: 0, first });
                s.count += same.len() - 1;
                s.first = s.first.min(first);
            }
            let value: f64 = same[1..].iter().fold(same[0].value, |sum, t| sum + t.value);
            columns.push(same[0].column);
            values.push(value);
        }
        starts.push(columns.len());
    }
    Ok((
        SparseMatrix::new((header.rows, header.columns), starts, columns, values),
        surplus,
    ))
}
