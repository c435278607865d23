//! `‖(zI − T)⁻¹‖` of a real dense matrix, point by point.

use crate::SetupError;
use crate::eigen::{Ends, LanczosSettings, extreme_eigenvalues, factors};
use faer::{Mat, c64};
use std::cell::RefCell;

/// T as an upper Hessenberg matrix that is orthogonally similar to it.
///
/// A QR factorization of `zI − H` by n − 1 rotations has `σ_min(R) = σ_min(zI − T)`, and Lanczos on `R⁻¹R⁻ᴴ` finds `1/σ_min²`.
///
/// # Cost
/// 10 n³/3 flops once; per point some 8 n² for R and as many per step of Lanczos, of which there are about a dozen.
///
/// # Source
/// S. H. Lui, SIAM J. Sci. Comput. 18 (1997) 565–573; L. N. Trefethen & M. Embree, *Spectra and Pseudospectra* (2005), chapter 39, with a
/// Hessenberg matrix in place of the complex Schur form.
pub struct Resolvent {
    n: usize,
    /// By rows, zero below the subdiagonal.
    rows: Vec<f64>,
}

impl Resolvent {
    /// Of a square matrix.
    ///
    /// # Errors
    /// NaN or infinity in T.
    pub fn new(t: &Mat<f64>) -> Result<Self, SetupError> {
        let n = t.nrows();
        let h = factors::hessenberg(t.clone())?;
        let rows = (0..n * n).map(|k| h[(k / n, k % n)]).collect();
        Ok(Self { n, rows })
    }

    /// `σ_min(zI − T) = 1/‖(zI − T)⁻¹‖`, from below by the error bar of Lanczos, to this relative accuracy; 0 at an eigenvalue.
    ///
    /// # Errors
    /// Those of [`extreme_eigenvalues`].
    pub fn smallest(&self, z: c64, accuracy: f64) -> Result<f64, SetupError> {
        thread_local! {
            static TRIANGLE: RefCell<Triangle> = const { RefCell::new(Triangle { n: 0, re: Vec::new(), im: Vec::new() }) };
        }
        TRIANGLE.with_borrow_mut(|triangle| {
            triangle.factorize(self, z);
            triangle.smallest(accuracy)
        })
    }
}

/// R of `zI − H = Q R`, by rows, zero below the diagonal.
struct Triangle {
    n: usize,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Triangle {
    fn factorize(&mut self, resolvent: &Resolvent, z: c64) {
        let n = resolvent.n;
        self.n = n;
        self.re.resize(n * n, 0.0);
        self.im.resize(n * n, 0.0);
        let h = |i: usize| &resolvent.rows[i * n..(i + 1) * n];
        // the row that is rotated with the next one
        let mut c_re: Vec<f64> = h(0).iter().map(|v| -v).collect();
        let mut c_im = vec![0.0; n];
        (c_re[0], c_im[0]) = (c_re[0] + z.re, z.im);
        for k in 0..n - 1 {
            let d = &h(k + 1)[k..];
            let (a_re, a_im, b) = (c_re[k], c_im[k], -d[0]);
            let r = a_re.hypot(a_im).hypot(b);
            let (a_re, a_im, b) = match r == 0.0 {
                true => (1.0, 0.0, 0.0),
                false => (a_re / r, a_im / r, b / r),
            };
            let out_re = &mut self.re[k * n + k..(k + 1) * n];
            let out_im = &mut self.im[k * n + k..(k + 1) * n];
            let rows = out_re.iter_mut().zip(out_im).zip(d);
            let current = c_re[k..].iter_mut().zip(&mut c_im[k..]);
            // [ā b; −b a] of the row c and the real row −d of −H
            for (((out_re, out_im), d), (c_re, c_im)) in rows.zip(current) {
                let (re, im) = (*c_re, *c_im);
                *out_re = a_re * re + a_im * im - b * d;
                *out_im = a_re * im - a_im * re;
                *c_re = -b * re - a_re * d;
                *c_im = -b * im - a_im * d;
            }
            // z on the diagonal of the next row
            self.re[k * n + k + 1] += b * z.re;
            self.im[k * n + k + 1] += b * z.im;
            c_re[k + 1] += a_re * z.re - a_im * z.im;
            c_im[k + 1] += a_re * z.im + a_im * z.re;
        }
        (self.re[n * n - 1], self.im[n * n - 1]) = (c_re[n - 1], c_im[n - 1]);
    }

    fn smallest(&self, accuracy: f64) -> Result<f64, SetupError> {
        let n = self.n;
        if (0..n).any(|i| self.re[i * n + i] == 0.0 && self.im[i * n + i] == 0.0) {
            return Ok(0.0);
        }
        let mut apply = |x: &[f64], y: &mut [f64]| {
            y.copy_from_slice(x);
            let (re, im) = y.split_at_mut(n);
            self.solve_adjoint(re, im);
            self.solve(re, im);
        };
        let settings = LanczosSettings {
            tolerance: accuracy,
            max_steps: 200,
            ends: Ends::Largest,
        };
        let (_, high) = extreme_eigenvalues(2 * n, &mut apply, None, settings)?;
        Ok((high.value + high.error).sqrt().recip())
    }

    /// `x ← R⁻ᴴ x`.
    fn solve_adjoint(&self, re: &mut [f64], im: &mut [f64]) {
        let n = self.n;
        for i in 0..n {
            let (row_re, row_im) = (
                &self.re[i * n + i..(i + 1) * n],
                &self.im[i * n + i..(i + 1) * n],
            );
            let (y_re, y_im) = divided(re[i], im[i], row_re[0], -row_im[0]);
            (re[i], im[i]) = (y_re, y_im);
            let x = re[i + 1..].iter_mut().zip(&mut im[i + 1..]);
            for ((x_re, x_im), (r_re, r_im)) in x.zip(row_re[1..].iter().zip(&row_im[1..])) {
                *x_re -= r_re * y_re + r_im * y_im;
                *x_im -= r_re * y_im - r_im * y_re;
            }
        }
    }

    /// `x ← R⁻¹ x`.
    fn solve(&self, re: &mut [f64], im: &mut [f64]) {
        let n = self.n;
        for i in (0..n).rev() {
            let (row_re, row_im) = (
                &self.re[i * n + i..(i + 1) * n],
                &self.im[i * n + i..(i + 1) * n],
            );
            let (x_re, x_im) = (&re[i + 1..], &im[i + 1..]);
            let sum_re = dot(&row_re[1..], x_re) - dot(&row_im[1..], x_im);
            let sum_im = dot(&row_re[1..], x_im) + dot(&row_im[1..], x_re);
            (re[i], im[i]) = divided(re[i] - sum_re, im[i] - sum_im, row_re[0], row_im[0]);
        }
    }
}

/// (a + ib) / (c + id).
fn divided(a: f64, b: f64, c: f64, d: f64) -> (f64, f64) {
    let quotient = c64::new(a, b) / c64::new(c, d);
    (quotient.re, quotient.im)
}

/// Eight sums beside each other, as SIMD wants them.
fn dot(x: &[f64], y: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut sums = [0.0; LANES];
    let (x_blocks, y_blocks) = (x.chunks_exact(LANES), y.chunks_exact(LANES));
    let rest: f64 = (x_blocks.remainder().iter().zip(y_blocks.remainder()))
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in x_blocks.zip(y_blocks) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}
