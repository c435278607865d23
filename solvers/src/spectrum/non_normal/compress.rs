//! T without the space on which it is the identity.

use faer::Mat;
use fracas_operators::vector::{axpy, dot, norm2, scale};
use rayon::prelude::*;

/// Columns of T − I that are this small beside the largest are what rounding has left of none. Unit: 1.
const NONE: f64 = 1e-10;

/// `(VᵀTV ⊕ 1, (Vᵀr, ‖r − VVᵀr‖))`, V an orthonormal basis of the ranges of T − I and (T − I)ᵀ: the same resolvent norms, field of values and
/// residuals of GMRES as T and r have. `None` where V has more than half the columns of T.
///
/// With exact S_u, T − I has the rank n_t.
///
/// # Cost
/// 8 n² d flops for d columns.
pub(super) fn compressed(t: &Mat<f64>, r: &[f64]) -> Option<(Mat<f64>, Vec<f64>)> {
    let n = t.nrows();
    let entry = |i: usize, j: usize| t[(i, j)] - if i == j { 1.0 } else { 0.0 };
    let columns = (0..n).map(|j| (0..n).map(|i| entry(i, j)).collect());
    let rows = (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect());
    // what of them V does not hold
    let mut rest: Vec<Vec<f64>> = columns.chain(rows).collect();
    let mut squares: Vec<f64> = rest.iter().map(|c| dot(c, c)).collect();
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let mut basis: Vec<Vec<f64>> = Vec::new();
    loop {
        let pivot = (0..2 * n).max_by(|a, b| squares[*a].total_cmp(&squares[*b]))?;
        if squares[pivot] <= NONE * NONE * largest {
            break;
        }
        if 2 * (basis.len() + 1) >= n {
            return None;
        }
        let mut v = rest[pivot].clone();
        for _ in 0..2 {
            for old in &basis {
                axpy(-dot(old, &v), old, &mut v);
            }
        }
        let norm = norm2(&v);
        // rounding of columns that V holds already
        if norm <= NONE * largest.sqrt() {
            squares[pivot] = 0.0;
            continue;
        }
        scale(1.0 / norm, &mut v);
        (rest.par_iter_mut().zip(&mut squares)).for_each(|(column, square)| {
            axpy(-dot(&v, column), &v, column);
            *square = dot(column, column);
        });
        basis.push(v);
    }
    let d = basis.len();
    let images: Vec<Vec<f64>> = (basis.par_iter())
        .map(|v| {
            let mut image = vec![0.0; n];
            for (j, v_j) in v.iter().enumerate() {
                for (y, t) in image.iter_mut().zip(t.col(j).iter()) {
                    *y += t * v_j;
                }
            }
            image
        })
        .collect();
    let small = Mat::from_fn(d + 1, d + 1, |i, j| match (i < d, j < d) {
        (true, true) => dot(&basis[i], &images[j]),
        (false, false) => 1.0,
        _ => 0.0,
    });
    let mut outside = r.to_vec();
    let mut inside: Vec<f64> = basis.iter().map(|v| dot(v, r)).collect();
    for (c, v) in inside.iter().zip(&basis) {
        axpy(-c, v, &mut outside);
    }
    inside.push(norm2(&outside));
    Some((small, inside))
}
