//! Discs that hold every eigenvalue of M⁻¹𝒜 with exact S_u, whatever the symmetry.
//!
//! `M⁻¹𝒜 = I + M⁻¹P Q`, `P = [0; I]`, `Q = [B2 − B1ᵀ, C − H]`: 1 at least n_u times, and `1 + eig(K)`, `K = Q Y`, M Y = P, of size n_t.

use super::pencil::Pencil;
use super::rounding::{
    U, above, absolute, absolute_product, column_maxima, gamma, largest, row_sums,
};
use crate::eigen::{dense, factors};
use faer::{Mat, c64};

/// A matrix with a bound of the error of each entry.
struct Enclosed {
    value: Mat<f64>,
    error: Mat<f64>,
}

/// `|λ − center| ≤ radius`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disc {
    pub(super) center: c64,
    pub(super) radius: f64,
}

impl Disc {
    /// Has a point on the real axis.
    pub(super) fn touches(&self) -> bool {
        self.center.im.abs() <= self.radius
    }

    fn meets(&self, other: &Self) -> bool {
        let distance = (self.center.re - other.center.re).hypot(self.center.im - other.center.im);
        distance * (1.0 - 4.0 * U) <= above(self.radius + other.radius, 2)
    }

    /// Of these discs it meets none, and its centre is real: it holds one real eigenvalue.
    pub(super) fn is_alone(&self, all: &[Self]) -> bool {
        self.center.im == 0.0 && all.iter().filter(|other| self.meets(other)).count() == 1
    }
}

/// Discs around all eigenvalues but those at 1; the union of m that meet holds m.
///
/// # Cost
/// 6 (n_u + n_t)³ + 60 n_t³ flops.
///
/// # Source
/// S. M. Rump, Acta Numerica 19 (2010) 287–449, §10.7 and §13; Gershgorin's theorem for `X⁻¹KX`.
pub(super) fn discs(pencil: &Pencil) -> Result<Vec<Disc>, &'static str> {
    let k = outer(pencil)?;
    let n = k.value.nrows();
    let (values, x) =
        dense::general_eigen(k.value.as_ref()).map_err(|_| "the eigenvectors were not found")?;
    let part = |f: fn(&c64) -> f64| Mat::from_fn(n, n, |i, j| f(&x[(i, j)]));
    let x = [part(|v| v.re), part(|v| v.im)];
    let w = inverse(&x).ok_or("the eigenvectors depend on each other")?;
    // Z = W (K X − X Λ)
    let images = [&x[0], &x[1]].map(|x| dense::multiply(k.value.as_ref(), x.as_ref()));
    let residual = |which: usize| {
        Mat::from_fn(n, n, |i, j| {
            let (re, im) = (x[0][(i, j)], x[1][(i, j)]);
            let scaled = match which {
                0 => re * values[j].re - im * values[j].im,
                _ => re * values[j].im + im * values[j].re,
            };
            images[which][(i, j)] - scaled
        })
    };
    let residual = [residual(0), residual(1)];
    let sizes = x.each_ref().map(|x| absolute(x.as_ref()));
    let size = &sizes[0] + &sizes[1];
    let k_size = Mat::from_fn(n, n, |i, j| {
        gamma(n + 8) * k.value[(i, j)].abs() + k.error[(i, j)]
    });
    // what each part of the residual can be off by
    let mut off = dense::multiply(k_size.as_ref(), size.as_ref());
    for j in 0..n {
        let modulus = values[j].re.abs() + values[j].im.abs();
        for i in 0..n {
            let own = gamma(8)
                * (size[(i, j)] * modulus + residual[0][(i, j)].abs() + residual[1][(i, j)].abs());
            off[(i, j)] = above(off[(i, j)] + own, n + 4);
        }
    }
    let moduli =
        |m: &[Mat<f64>; 2]| Mat::from_fn(n, n, |i, j| m[0][(i, j)].abs() + m[1][(i, j)].abs());
    let (w_size, r_size) = (moduli(&w), moduli(&residual));
    let z = product(&w, &residual);
    let e = vec![1.0; n];
    let lost = Mat::from_fn(n, n, |i, j| {
        gamma(2 * n + 8) * r_size[(i, j)] + 2.0 * off[(i, j)]
    });
    let lost = absolute_product(w_size.as_ref(), &absolute_product(lost.as_ref(), &e));
    let z_rows: Vec<f64> = (0..n)
        .map(|i| {
            let sum: f64 = (0..n)
                .map(|j| z[0][(i, j)].abs() + z[1][(i, j)].abs())
                .sum();
            above(sum + lost[i], 2 * n)
        })
        .collect();
    // ‖I − W X‖
    let unit = product(&w, &x);
    let rounding = absolute_product(w_size.as_ref(), &absolute_product(size.as_ref(), &e));
    let beta_rows: Vec<f64> = (0..n)
        .map(|i| {
            let entry = |j: usize| {
                let one = if i == j { 1.0 } else { 0.0 };
                (unit[0][(i, j)] - one).abs() + unit[1][(i, j)].abs()
            };
            let sum: f64 = (0..n).map(entry).sum();
            above(
                sum * (1.0 + 4.0 * U) + gamma(2 * n + 8) * rounding[i],
                2 * n,
            )
        })
        .collect();
    let beta = largest(&beta_rows);
    if beta > 0.5 {
        return Err("the eigenvectors are too nearly dependent for this precision");
    }
    // (W X)⁻¹ Z = Z + (I − W X)(W X)⁻¹ Z, ‖(W X)⁻¹‖ ≤ 1/(1 − β)
    let worst = largest(&z_rows);
    let of_one = |i: usize| {
        let center = c64::new(1.0 + values[i].re, values[i].im);
        let spread = beta_rows[i] / (1.0 - beta) * worst;
        let radius = above(
            z_rows[i] + spread * (1.0 + 8.0 * U) + 2.0 * U * center.re.abs(),
            4,
        );
        Disc { center, radius }
    };
    let found: Vec<Disc> = (0..n).map(of_one).collect();
    match found.iter().all(|disc| disc.radius.is_finite()) {
        true => Ok(found),
        false => Err("the numbers overflow"),
    }
}

/// K with its error.
fn outer(pencil: &Pencil) -> Result<Enclosed, &'static str> {
    let (n_u, n_t) = pencil.sizes();
    let n = n_u + n_t;
    let m = pencil.m();
    let r = factors::inverse(m.as_ref()).ok_or("M is singular to this precision")?;
    let unit = dense::multiply(r.as_ref(), m.as_ref());
    let deviation = Mat::from_fn(n, n, |i, j| unit[(i, j)] - if i == j { 1.0 } else { 0.0 });
    let e = vec![1.0; n];
    let rounding = absolute_product(r.as_ref(), &row_sums(m.as_ref()));
    let rows = row_sums(deviation.as_ref());
    let alpha: Vec<f64> = (rows.iter().zip(&rounding))
        .map(|(found, rounding)| above(found * (1.0 + 2.0 * U) + gamma(n + 4) * rounding, 4))
        .collect();
    let alpha = largest(&alpha);
    if alpha > 0.5 {
        return Err("M is too nearly singular for this precision");
    }
    let y = Mat::from_fn(n, n_t, |i, j| r[(i, n_u + j)]);
    // per column max |Y − Ỹ| ≤ ‖R (P − M Ỹ)‖/(1 − α)
    let image = dense::multiply(m.as_ref(), y.as_ref());
    let size = dense::multiply(absolute(m.as_ref()).as_ref(), absolute(y.as_ref()).as_ref());
    let residual = Mat::from_fn(n, n_t, |i, j| {
        let one = if i == n_u + j { 1.0 } else { 0.0 };
        let off = above((one - image[(i, j)]).abs() * (1.0 + 2.0 * U), 2);
        above(off + gamma(n + 4) * above(size[(i, j)], n), 4)
    });
    let spread = dense::multiply(absolute(r.as_ref()).as_ref(), residual.as_ref());
    let errors: Vec<f64> = (column_maxima(spread.as_ref()).iter())
        .map(|worst| above(above(*worst, n) / (1.0 - alpha) * (1.0 + 4.0 * U), 4))
        .collect();
    let q = Mat::from_fn(n_t, n, |k, j| match j < n_u {
        true => match &pencil.b2 {
            Some(b2) => b2[(k, j)] - pencil.b[(j, k)],
            None => 0.0,
        },
        false => pencil.c[(k, j - n_u)] - pencil.h[(k, j - n_u)],
    });
    let q_rows = absolute_product(q.as_ref(), &e);
    let q_size = dense::multiply(absolute(q.as_ref()).as_ref(), absolute(y.as_ref()).as_ref());
    Ok(Enclosed {
        value: dense::multiply(q.as_ref(), y.as_ref()),
        error: Mat::from_fn(n_t, n_t, |i, j| {
            let rounding = gamma(n + 8) * above(q_size[(i, j)], n);
            above(rounding + q_rows[i] * errors[j] * (1.0 + 4.0 * U), 4)
        }),
    })
}

/// (A + iB)(C + iD).
fn product(left: &[Mat<f64>; 2], right: &[Mat<f64>; 2]) -> [Mat<f64>; 2] {
    let of = |i: usize, j: usize| dense::multiply(left[i].as_ref(), right[j].as_ref());
    [of(0, 0) - of(1, 1), of(0, 1) + of(1, 0)]
}

/// (X + iY)⁻¹ by that of `[X −Y; Y X]`.
fn inverse(x: &[Mat<f64>; 2]) -> Option<[Mat<f64>; 2]> {
    let n = x[0].nrows();
    if x[1].norm_max() == 0.0 {
        return Some([factors::inverse(x[0].as_ref())?, Mat::zeros(n, n)]);
    }
    let whole = Mat::from_fn(2 * n, 2 * n, |i, j| {
        let entry = |part: usize| x[part][(i % n, j % n)];
        match (i < n, j < n) {
            (true, true) | (false, false) => entry(0),
            (true, false) => -entry(1),
            (false, true) => entry(1),
        }
    });
    let whole = factors::inverse(whole.as_ref())?;
    let block = |first: usize| Mat::from_fn(n, n, |i, j| whole[(first + i, j)]);
    Some([block(0), block(n)])
}
