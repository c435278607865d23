//! What is wrong with a file, line by line, and which entries it lists more than once. Only files that are not as they
//! should be are read this slowly.

use super::blocks::{Failure, each_block};
use super::error::Defect;
use super::header::{Header, Layout, Symmetry};
use super::lines::{Lines, is_blank};
use super::parse::{Entry, entry, value};
use super::read::Duplicates;
use crate::sparse::SparseMatrix;
use std::io::{self, Read, Seek};

/// Calls `see(k, line number, line)` for the k-th line that holds data, from k = 0; gives their count and the number of
/// the last line.
fn each_line(
    source: &mut (impl Read + Seek),
    (header, body): (&Header, u64),
    mut see: impl FnMut(usize, usize, &[u8]) -> Result<(), Defect>,
) -> Result<(usize, usize), Failure> {
    let (mut count, mut above) = (0, header.size_line);
    each_block(source, body, |block| {
        let mut lines = Lines::new(block);
        while let Some(line) = lines.next() {
            let number = above + lines.number();
            if !is_blank(line) {
                see(count, number, line).map_err(|defect| Failure::Content(number, defect))?;
                count += 1;
            }
        }
        above += lines.number();
        Ok(())
    })?;
    Ok((count, above))
}

/// The first defect of a file whose parts did not fit.
pub(super) fn diagnose(source: &mut (impl Read + Seek), header: &Header, body: u64) -> Failure {
    let expected = header.expected();
    let (mut surplus, mut first, mut on_diagonal) = (None, header.size_line, None);
    let mut next = ArrayPlace::new(header);
    let read = each_line(source, (header, body), |k, number, line| {
        if k == 0 {
            first = number;
        }
        if k == expected {
            surplus = Some(number);
        }
        if header.layout == Layout::Array {
            return value(header, line, next.take(header)).map(drop);
        }
        let Entry { row, column, value } = entry(header, line)?;
        if header.symmetry == Symmetry::Skew && row == column && value != 0.0 {
            let row = row as usize + 1;
            on_diagonal.get_or_insert((number, Defect::SkewDiagonal { row, value }));
        }
        Ok(())
    });
    let (found, last) = match read {
        Ok(found) => found,
        Err(failure) => return failure,
    };
    if found < expected {
        return Failure::Content(last, Defect::Truncated { expected, found });
    }
    if let Some(line) = surplus {
        return Failure::Content(line, Defect::TooMany { expected, found });
    }
    if found >= MOST_ENTRIES {
        let defect = Defect::TooLarge {
            what: "entries",
            count: found as u64,
            limit: MOST_ENTRIES as u64 - 1,
        };
        return Failure::Content(first, defect);
    }
    match on_diagonal {
        Some((line, defect)) => Failure::Content(line, defect),
        None => changed(),
    }
}

/// Entries that a file may not reach: places within a row are counted in 32 bits.
pub(super) const MOST_ENTRIES: usize = u32::MAX as usize;

/// Two passes saw two different files.
pub(super) fn changed() -> Failure {
    Failure::Io(io::Error::other("the file changed while it was read"))
}

/// Row and column of the next value of an array: column after column, all rows, or from the diagonal (symmetric) or below
/// it (skew) downwards.
struct ArrayPlace {
    i: usize,
    j: usize,
}

impl ArrayPlace {
    fn new(header: &Header) -> Self {
        let i = header.first_row(0);
        Self { i, j: 0 }
    }

    /// From 1.
    fn take(&mut self, header: &Header) -> [usize; 2] {
        while self.i >= header.rows && self.j < header.columns {
            self.j += 1;
            self.i = header.first_row(self.j);
        }
        self.i += 1;
        [self.i, self.j + 1]
    }
}

/// Which entries of a coordinate file repeat an earlier one.
///
/// # Errors
/// [`Defect::BothTriangles`] for symmetric storage that holds an entry and its mirror image: the uppermost one.
pub(super) fn repeated(
    source: &mut (impl Read + Seek),
    header: &Header,
    body: u64,
    matrix: &SparseMatrix<f64>,
) -> Result<Option<Duplicates>, Failure> {
    // one bit for every place and triangle
    let mut seen = vec![0_u8; matrix.nnz().div_ceil(4)];
    let mut duplicates: Option<Duplicates> = None;
    let mut both: Option<([usize; 2], usize)> = None;
    let mut gone = false;
    each_line(source, (header, body), |_, line, text| {
        let e = entry(header, text)?;
        let (row, column) = (e.row as usize, e.column as usize);
        let general = header.symmetry == Symmetry::General;
        let upper = !general && row < column;
        let place = if general || upper {
            [row, column]
        } else {
            [column, row]
        };
        let Some(k) = matrix.nnz_index(place[0], place[1]) else {
            gone = true;
            return Ok(());
        };
        let (byte, shift) = (&mut seen[k.0 / 4], 2 * (k.0 % 4));
        let (own, other) = if upper { (2, 1) } else { (1, 2) };
        if *byte >> shift & own != 0 {
            let d = duplicates.get_or_insert(Duplicates {
                count: 0,
                line,
                row: row + 1,
                column: column + 1,
            });
            d.count += 1;
        } else if *byte >> shift & other != 0 && both.is_none_or(|(above, _)| place < above) {
            both = Some((place, line));
        }
        *byte |= own << shift;
        Ok(())
    })?;
    match both {
        _ if gone => Err(changed()),
        Some(([row, column], line)) => {
            let symmetry = header.symmetry.word();
            let (row, column) = (row + 1, column + 1);
            let defect = Defect::BothTriangles {
                symmetry,
                row,
                column,
            };
            Err(Failure::Content(line, defect))
        }
        None => Ok(duplicates),
    }
}
