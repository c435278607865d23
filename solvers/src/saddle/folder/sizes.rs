//! What the headers of a folder announce, held against each other before anything of that size is allocated.

use super::FolderError;
use super::import::{expect, square};
use fracas_operators::Shape;
use fracas_operators::matrix_market::{Announced, read_sizes};
use std::path::PathBuf;

/// Unknowns from which on entries are counted: a header of a few bytes may then ask for memory that matters.
const MANY: usize = 1 << 20;

/// Compares the sizes in the headers of all blocks; files that are absent or have no header are left to their reader. `present` says
/// where a file is, and that what stands under its name is one: a pipe would be waited for.
///
/// # Errors
/// Those of `present`, [`FolderError::Sizes`], [`FolderError::NotSquare`], [`FolderError::CoordinateShape`], and [`FolderError::Hollow`] for
/// more than 2²⁰ unknowns most of which no entry mentions.
pub(super) fn check(
    present: &dyn Fn(&str) -> Result<Option<PathBuf>, FolderError>,
) -> Result<(), FolderError> {
    let header = |file: &'static str| -> Result<_, FolderError> {
        Ok(present(file)?.and_then(|path| read_sizes(&path).ok()))
    };
    let (Some(a), Some(b1)) = (header("A.mtx")?, header("B1.mtx")?) else {
        return Ok(());
    };
    let (n_u, n_t) = (a.shape.rows, b1.shape.cols);
    if n_u == 0 || n_t == 0 {
        // what is empty has a sentence of its own
        return Ok(());
    }
    let (from_a, from_b1) = (("A.mtx", a.shape), ("B1.mtx", b1.shape));
    square("A.mtx", a.shape)?;
    expect("B1.mtx", b1.shape, Shape::new(n_u, n_t), from_a)?;
    hollow(("A.mtx", n_u, "rows"), "it and B1.mtx list", &[a, b1])?;
    hollow(("B1.mtx", n_t, "columns"), "it lists", &[b1])?;
    for (file, shape) in [
        ("B2.mtx", Shape::new(n_t, n_u)),
        ("H.mtx", Shape::square(n_t)),
    ] {
        if let Some(found) = header(file)? {
            expect(file, found.shape, shape, from_b1)?;
        }
    }
    // more than one column is what the reader of a vector says
    let vector = |file, rows, by| match header(file)?.filter(|h| h.shape.cols == 1) {
        Some(found) => expect(file, found.shape, Shape::new(rows, 1), by),
        None => Ok(()),
    };
    vector("rhs_u.mtx", n_u, from_a)?;
    vector("rhs_t.mtx", n_t, from_b1)?;
    if let (Some(t), Some(q1), Some(q2)) = (header("T.mtx")?, header("Q1.mtx")?, header("Q2.mtx")?)
    {
        let n_p = t.shape.rows;
        let from_t = ("T.mtx", t.shape);
        square("T.mtx", t.shape)?;
        let by = |fits| if fits { from_t } else { from_a };
        let (q1_by, q2_by) = (by(q1.shape.rows == n_u), by(q2.shape.cols == n_u));
        expect("Q1.mtx", q1.shape, Shape::new(n_u, n_p), q1_by)?;
        expect("Q2.mtx", q2.shape, Shape::new(n_p, n_u), q2_by)?;
        vector("rhs_p.mtx", n_p, from_t)?;
        hollow(("T.mtx", n_p, "rows"), "it and Q1.mtx list", &[t, q1])?;
    }
    if let Some(Announced { shape, .. }) = header("coords.mtx")?
        && shape != Shape::new(n_u, 4)
        && !(shape.cols == 3 && 3 * shape.rows == n_u)
    {
        return Err(FolderError::CoordinateShape { found: shape, n_u });
    }
    Ok(())
}

/// Refuses sizes that their own entries do not bear out: an entry mentions at most two unknowns.
fn hollow(
    (file, unknowns, lines): (&'static str, usize, &'static str),
    listed: &'static str,
    blocks: &[Announced],
) -> Result<(), FolderError> {
    let entries = blocks.iter().map(|block| block.entries).sum::<usize>();
    if unknowns > MANY && unknowns > entries.saturating_mul(2) {
        return Err(FolderError::Hollow {
            file,
            lines,
            listed,
            unknowns,
            entries,
        });
    }
    Ok(())
}
