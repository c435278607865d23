//! Reduction of a dense symmetric matrix to tridiagonal form.

use super::dense::for_column_blocks;
use faer::linalg::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use fracas_operators::simd::{Kernel, Lanes, Level, MAX_WIDTH};
use fracas_operators::vector::{axpy, dot};
use rayon::prelude::*;

/// Columns reduced before the rest of the matrix is updated at once.
const PANEL: usize = 32;

/// Column ranges of one product `A v`: depends on nothing, so the bits do not depend on the number of threads.
const PARTS: usize = 4;

/// Order below which a product is not worth a second thread.
const SEQUENTIAL: usize = 400;

/// Diagonal and subdiagonal of `T = QᵀA Q`; A column by column, only its lower triangle is read, and destroyed.
///
/// In a panel of reflections `I − τ v vᵀ`: `w = τ (A v − V Wᵀv − W Vᵀv)`, `w ← w − ½ τ (wᵀv) v`; behind it
/// `A ← A − V Wᵀ − W Vᵀ`.
///
/// # Cost
/// `4/3 n³` flops, half of them in products with a matrix; every column reads what is left of the lower triangle once.
///
/// # Source
/// Dongarra, Hammarling, Sorensen, J. Comput. Appl. Math. 27 (1989).
pub(super) fn tridiagonal(a: &mut [f64], n: usize) -> (Vec<f64>, Vec<f64>) {
    assert_eq!(a.len(), n * n, "entries of a square matrix");
    let (mut diagonal, mut below) = (Vec::with_capacity(n), Vec::with_capacity(n));
    let (mut v, mut w) = (vec![0.0; n * PANEL], vec![0.0; n * PANEL]);
    let mut sums = vec![0.0; PARTS * n];
    for first in (0..n).step_by(PANEL) {
        let end = n.min(first + PANEL);
        for i in first..end {
            let (v, v_k) = v.split_at_mut((i - first) * n);
            let (w, w_k) = w.split_at_mut((i - first) * n);
            let pairs = || v.chunks_exact(n).zip(w.chunks_exact(n));
            // column i of A − V Wᵀ − W Vᵀ
            let column = &mut a[i * n + i..(i + 1) * n];
            for (v, w) in pairs() {
                axpy(-w[i], &v[i..], column);
                axpy(-v[i], &w[i..], column);
            }
            diagonal.push(column[0]);
            let (v_k, w_k) = (&mut v_k[i + 1..n], &mut w_k[i + 1..n]);
            let Some((tau, beta)) = reflection(&column[1..], v_k) else {
                break;
            };
            below.push(beta);
            product(&a[(i + 1) * (n + 1)..], n, v_k, w_k, &mut sums);
            for (v, w) in pairs() {
                let (v, w) = (&v[i + 1..], &w[i + 1..]);
                axpy(-dot(w, v_k), v, w_k);
                axpy(-dot(v, v_k), w, w_k);
            }
            let half = 0.5 * tau * dot(w_k, v_k);
            w_k.iter_mut()
                .zip(v_k)
                .for_each(|(w, v)| *w = tau * (*w - half * *v));
        }
        if end < n {
            let rest = n - end;
            let block = |m| {
                let m = MatRef::from_column_major_slice(m, n, PANEL);
                m.subrows(end, rest)
            };
            update(&mut a[end * n..], n, block(&v), block(&w));
        }
    }
    (diagonal, below)
}

/// τ and β of `(I − τ v vᵀ) x = β e_1` with `v_1 = 1`; `None` for an empty x.
fn reflection(x: &[f64], v: &mut [f64]) -> Option<(f64, f64)> {
    let (alpha, tail) = x.split_first()?;
    let square = dot(tail, tail);
    v.fill(0.0);
    v[0] = 1.0;
    if square == 0.0 {
        return Some((0.0, *alpha));
    }
    // the sign that adds
    let beta = -(alpha * alpha + square).sqrt().copysign(*alpha);
    axpy(1.0 / (alpha - beta), tail, &mut v[1..]);
    Some(((beta - alpha) / beta, beta))
}

/// The lower triangle of the last rows and columns of A − V Wᵀ − W Vᵀ; `a` starts with their first column.
fn update(a: &mut [f64], n: usize, v: MatRef<'_, f64>, w: MatRef<'_, f64>) {
    let rest = v.nrows();
    let a = MatMut::from_column_major_slice_mut(a, n, rest).subrows_mut(n - rest, rest);
    for_column_blocks(a, 0, &|column, part| {
        let (width, height) = (part.ncols(), rest - column);
        let mut part = part.subrows_mut(column, height);
        for (x, y) in [(v, w), (w, v)] {
            let (x, y) = (x.subrows(column, height), y.subrows(column, width));
            let (part, y) = (part.as_mut(), y.transpose());
            matmul::matmul(part, Accum::Add, x, y, -1.0, Par::Seq);
        }
    });
}

/// `y = A x` by the lower triangle of the A whose first diagonal entry is `a[0]`, columns n entries apart.
fn product(a: &[f64], n: usize, x: &[f64], y: &mut [f64], sums: &mut [f64]) {
    let m = x.len();
    let level = Level::best();
    // column ranges of about equal area, whole quadruples
    let start = |part: usize| {
        let left = (1.0 - part as f64 / PARTS as f64).sqrt();
        (m - (m as f64 * left) as usize) / COLUMNS * COLUMNS
    };
    let run = |(part, sum): (usize, &mut [f64])| {
        let sum = &mut sum[..m];
        sum.fill(0.0);
        let last = part + 1 == PARTS;
        level.run(Part {
            a,
            stride: n,
            x,
            y: sum,
            columns: [start(part), if last { m } else { start(part + 1) }],
        });
    };
    if m < SEQUENTIAL {
        sums.chunks_exact_mut(n).enumerate().for_each(run);
    } else {
        sums.par_chunks_exact_mut(n).enumerate().for_each(run);
    }
    y.copy_from_slice(&sums[..m]);
    for sum in sums.chunks_exact(n).skip(1) {
        axpy(1.0, &sum[..m], y);
    }
}

/// Columns that one pass over x and y handles.
const COLUMNS: usize = 4;

/// `y ← y + (columns of the lower triangle and their mirror images) x`.
struct Part<'a> {
    a: &'a [f64],
    stride: usize,
    x: &'a [f64],
    y: &'a mut [f64],
    columns: [usize; 2],
}

impl Kernel<f64> for Part<'_> {
    #[inline(always)]
    fn run<L: Lanes<f64>>(self) {
        let m = self.x.len();
        let [first, end] = self.columns;
        let (x, y) = (self.x, self.y);
        for j in (first..end).step_by(COLUMNS) {
            let width = COLUMNS.min(end - j);
            // the triangle on the diagonal, and what does not fill a register
            let whole = (m - j - width) / L::WIDTH * L::WIDTH;
            let bottom = m - whole;
            for c in j..j + width {
                let column = &self.a[c * self.stride..][..m];
                y[c] += column[c] * x[c];
                for r in (c + 1..j + width).chain(j + width..bottom) {
                    y[r] += column[r] * x[c];
                    y[c] += column[r] * x[r];
                }
            }
            if width == COLUMNS {
                let column = |c: usize| &self.a[(j + c) * self.stride + bottom..][..whole];
                let columns = [column(0), column(1), column(2), column(3)];
                let (x_r, y_r) = (&x[bottom..][..whole], &mut y[bottom..][..whole]);
                let mut sums = [L::splat(0.0); COLUMNS];
                let factors = [
                    L::splat(x[j]),
                    L::splat(x[j + 1]),
                    L::splat(x[j + 2]),
                    L::splat(x[j + 3]),
                ];
                for r in (0..whole).step_by(L::WIDTH) {
                    let x = L::load(&x_r[r..]);
                    let mut y = L::load(&y_r[r..]);
                    for c in 0..COLUMNS {
                        let a = L::load(&columns[c][r..]);
                        y = a.mul_add(factors[c], y);
                        sums[c] = a.mul_add(x, sums[c]);
                    }
                    y.store(&mut y_r[r..]);
                }
                let mut lanes = [0.0; MAX_WIDTH];
                for c in 0..COLUMNS {
                    sums[c].store(&mut lanes);
                    y[j + c] += lanes[..L::WIDTH].iter().sum::<f64>();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
