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

/// `max_ij |m_ij − m_ji| / √(|m_ii m_jj|)` of a matrix by rows, at the first place (i, j) in the order of rows that reaches
/// it; a zero diagonal is replaced by the largest entry of the matrix. `None` for a symmetric matrix.
///
/// # Cost
/// One walk over the entries, 16 bytes per row: the transpose is not formed.
pub(super) fn asymmetry(m: &SparseMatrix<f64>) -> Option<Difference> {
    let largest = m.data().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let diagonal: Vec<f64> = (0..m.rows())
        .map(|i| m.get(i, i).map_or(0.0, |d| d.abs()))
        .map(|d| if d > 0.0 { d } else { largest })
        .collect();
    let mut worst: Option<Difference> = None;
    let mut see = |row: usize, column: usize, x: f64, y: f64| {
        if x == y {
            return;
        }
        let relative = (x - y).abs() / (diagonal[row] * diagonal[column]).sqrt();
        let first = |w: Difference| {
            relative > w.relative || relative == w.relative && (row, column) < (w.row, w.column)
        };
        if worst.is_none_or(first) {
            worst = Some(Difference {
                row,
                column,
                x,
                y,
                relative,
            });
        }
    };
    let (columns, values) = (m.indices(), m.data());
    let range = |i: usize| m.indptr().outer_inds_sz(i);
    // what row j holds left of its diagonal, in the order in which the rows above ask for it
    let mut next: Vec<usize> = (0..m.rows()).map(|j| range(j).start).collect();
    for i in 0..m.rows() {
        // nobody above asked for the rest
        for k in next[i]..range(i).end {
            let j = columns[k] as usize;
            if j < i {
                see(j, i, 0.0, values[k]);
            } else if j > i {
                let end = range(j).end;
                let k_ji = &mut next[j];
                while *k_ji < end && (columns[*k_ji] as usize) < i {
                    see(columns[*k_ji] as usize, j, 0.0, values[*k_ji]);
                    *k_ji += 1;
                }
                if *k_ji < end && columns[*k_ji] as usize == i {
                    see(i, j, values[k], values[*k_ji]);
                    *k_ji += 1;
                } else {
                    see(i, j, values[k], 0.0);
                }
            }
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::sparse::Triplets;

    /// Through the transpose.
    fn oracle(m: &SparseMatrix<f64>) -> Option<Difference> {
        let largest = m.data().iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let d: Vec<f64> = (0..m.rows())
            .map(|i| m.get(i, i).map_or(0.0, |d| d.abs()))
            .map(|d| if d > 0.0 { d } else { largest })
            .collect();
        largest_difference(m, &m.transpose_view().to_csr(), |i, j| (d[i] * d[j]).sqrt())
    }

    #[test]
    fn asymmetry_is_that_of_the_transpose_at_the_same_place() {
        let mut unsymmetric = 0;
        for seed in 0..300_usize {
            let n = 7;
            let mut triplets = Triplets::new((n, n));
            let random = |k: usize| {
                let x = (k * 7919 + seed * 104_729 + 13).wrapping_mul(2_654_435_761) >> 7;
                (x % 97) as f64
            };
            for i in 0..n {
                for j in 0..=i {
                    let value = random(i * n + j);
                    if value > 40.0 {
                        continue;
                    }
                    // few values, so that the largest difference is found at several places
                    let value = (value % 4.0) - 1.0;
                    let other = random(1000 + i * n + j);
                    if i == j || other > 12.0 {
                        triplets.add_triplet(i, j, value);
                    }
                    if i != j && other > 6.0 {
                        let change = if seed % 3 > 0 && other > 80.0 {
                            1.0
                        } else {
                            0.0
                        };
                        triplets.add_triplet(j, i, value + change);
                    }
                }
            }
            let m = triplets.to_csr();
            let (found, expected) = (asymmetry(&m), oracle(&m));
            let parts = |d: Option<Difference>| d.map(|d| (d.row, d.column, d.x, d.y, d.relative));
            assert_eq!(parts(found), parts(expected), "seed {seed}");
            unsymmetric += usize::from(found.is_some());
        }
        assert!(unsymmetric > 100 && unsymmetric < 300);
    }
}
