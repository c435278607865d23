//! Products and precisions.

use crate::Real;

/// A 3×3 matrix by rows.
pub type Matrix3<R> = [[R; 3]; 3];

/// diag(d).
pub fn diagonal<R: Real, const N: usize>(d: [R; N]) -> [[R; N]; N] {
    let mut m = [[R::zero(); N]; N];
    (0..N).for_each(|i| m[i][i] = d[i]);
    m
}

/// The same matrix in another precision.
#[inline(always)]
pub fn cast<S: Real, R: Real, const N: usize, const K: usize>(m: &[[S; K]; N]) -> [[R; K]; N] {
    let mut cast = [[R::zero(); K]; N];
    for i in 0..N {
        for j in 0..K {
            cast[i][j] = R::of(m[i][j].to_f64_exact());
        }
    }
    cast
}

/// Mᵀ.
#[inline(always)]
pub fn transposed<R: Real, const N: usize, const K: usize>(m: &[[R; K]; N]) -> [[R; N]; K] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// `‖M‖_F²` in f64.
#[inline(always)]
pub fn norm_squared<R: Real, const N: usize, const K: usize>(m: &[[R; K]; N]) -> f64 {
    let values = m.as_flattened().iter().map(|v| v.to_f64_exact());
    values.map(|v| v * v).sum()
}

/// `M v`.
#[inline(always)]
pub fn times<R: Real, const N: usize, const K: usize>(m: &[[R; K]; N], v: &[R; K]) -> [R; N] {
    let mut image = [R::zero(); N];
    for i in 0..N {
        let mut sum = m[i][0] * v[0];
        for k in 1..K {
            sum += m[i][k] * v[k];
        }
        image[i] = sum;
    }
    image
}

/// `Y ← Y + α X`.
#[inline(always)]
pub fn add<R: Real, const N: usize, const K: usize>(
    y: &mut [[R; K]; N],
    alpha: R,
    x: &[[R; K]; N],
) {
    let values = x.as_flattened().iter();
    y.as_flattened_mut()
        .iter_mut()
        .zip(values)
        .for_each(|(y, x)| *y += alpha * *x);
}

/// `Y ← Y + A X` in f64.
#[inline(always)]
pub fn add_product<S: Real, R: Real, const N: usize, const K: usize>(
    y: &mut [[f64; K]; N],
    a: &[[S; N]; N],
    x: &[[R; K]; N],
) {
    let rows: [[f64; K]; N] = cast(x);
    for r in 0..N {
        for k in 0..N {
            let a_rk = a[r][k].to_f64_exact();
            for c in 0..K {
                y[r][c] += a_rk * rows[k][c];
            }
        }
    }
}

/// `C ← C + PᵀX` in f64.
#[inline(always)]
pub fn add_transposed_product<R: Real, const N: usize, const K: usize>(
    c: &mut [[f64; K]; K],
    p: &[[R; K]; N],
    x: &[[f64; K]; N],
) {
    for r in 0..K {
        for k in 0..N {
            let p_kr = p[k][r].to_f64_exact();
            for j in 0..K {
                c[r][j] += p_kr * x[k][j];
            }
        }
    }
}
