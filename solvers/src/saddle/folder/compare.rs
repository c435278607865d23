//! Largest scaled difference of two sparse matrices.

use fracas_operators::sparse::SparseMatrix;

/// Where two matrices differ most. Counted from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Difference {
    pub(super) row: usize,
    pub(super) column: usize,
    pub(super) x: f64,
    pub(super) y: f64,
    /// `|x − y| / scale(row, column)`.
    pub(super) relative: f64,
}

/// `max |x_ij − y_ij| / scale(i, j)` over two matrices of one shape, both by rows; `None` when they are equal.
pub(super) fn largest_difference(
    x: &SparseMatrix<f64>,
    y: &SparseMatrix<f64>,
    scale: impl Fn(usize, usize) -> f64,
) -> Option<Difference> {
    let mut worst: Option<Difference> = None;
    for (i, (x_row, y_row)) in x.outer_iterator().zip(y.outer_iterator()).enumerate() {
        let (mut xs, mut ys) = (x_row.iter().peekable(), y_row.iter().peekable());
        loop {
            let j = match (xs.peek(), ys.peek()) {
                (None, None) => break,
                (Some((a, _)), None) => *a,
                (None, Some((b, _))) => *b,
                (Some((a, _)), Some((b, _))) => *a.min(b),
            };
            let x_ij = xs.next_if(|(a, _)| *a == j).map_or(0.0, |(_, v)| *v);
            let y_ij = ys.next_if(|(b, _)| *b == j).map_or(0.0, |(_, v)| *v);
            if x_ij == y_ij {
                continue;
            }
            let relative = (x_ij - y_ij).abs() / scale(i, j);
            if worst.is_none_or(|w| relative > w.relative) {
                worst = Some(Difference {
                    row: i,
                    column: j,
                    x: x_ij,
                    y: y_ij,
                    relative,
                });
            }
        }
    }
    worst
}

/// `max_ij |m_ij − m_ji| / √(|m_ii m_jj|)`; a zero diagonal is replaced by the largest entry of the matrix.
pub(super) fn asymmetry(m: &SparseMatrix<f64>) -> Option<Difference> {
    let largest = m.data().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let diagonal: Vec<f64> = (0..m.rows())
        .map(|i| m.get(i, i).map_or(0.0, |d| d.abs()))
        .map(|d| if d > 0.0 { d } else { largest })
        .collect();
    let transposed = m.transpose_view().to_csr();
    largest_difference(m, &transposed, |i, j| (diagonal[i] * diagonal[j]).sqrt())
}
