//! Solutions to the last digit: a factorization refined with residuals in twice the digits.

use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::saddle::{SaddleBlocks, SaddleMethod};

/// a + b = s + e exactly.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let t = s - a;
    (s, (a - (s - t)) + (b - t))
}

/// A number of twice the digits: s ← s + a·b.
fn add_product(s: &mut (f64, f64), a: f64, b: f64) {
    let p = a * b;
    let low = a.mul_add(b, -p);
    let (high, error) = two_sum(s.0, p);
    *s = two_sum(high, s.1 + error + low);
}

/// r ← r + α M (x_high + x_low)
fn add_rows(
    r: &mut [(f64, f64)],
    alpha: f64,
    m: &SparseMatrix<f64>,
    x: [&[f64]; 2],
    transposed: bool,
) {
    for (value, (i, j)) in m {
        let (to, from) = if transposed {
            (j as usize, i as usize)
        } else {
            (i as usize, j as usize)
        };
        for x in x {
            add_product(&mut r[to], alpha * value, x[from]);
        }
    }
}

/// `𝒜⁻¹b` by LU refined with residuals in twice the digits; `None` where the system is too ill-conditioned for that.
pub(crate) fn reference(blocks: &SaddleBlocks, b: &[f64]) -> Option<Vec<f64>> {
    let n_u = blocks.n_u();
    let lu = "direct"
        .parse::<SaddleMethod>()
        .unwrap()
        .ready(blocks)
        .ok()?
        .inverse;
    let mut x = [vec![0.0; b.len()], vec![0.0; b.len()]];
    let (mut z, mut work) = (vec![0.0; b.len()], vec![0.0; lu.work_len()]);
    let mut last = f64::INFINITY;
    for _ in 0..60 {
        let mut r: Vec<(f64, f64)> = b.iter().map(|b| (*b, 0.0)).collect();
        let (r_u, r_t) = r.split_at_mut(n_u);
        let u = [&x[0][..n_u], &x[1][..n_u]];
        let t = [&x[0][n_u..], &x[1][n_u..]];
        add_rows(r_u, -1.0, &blocks.a, u, false);
        add_rows(r_u, -1.0, &blocks.b1, t, false);
        match &blocks.b2 {
            Some(b2) => add_rows(r_t, -1.0, b2, u, false),
            None => add_rows(r_t, -1.0, &blocks.b1, u, true),
        }
        if let Some(h) = &blocks.h {
            add_rows(r_t, 1.0, h, t, false);
        }
        let r: Vec<f64> = r.into_iter().map(|(high, low)| high + low).collect();
        lu.solve(&r, &mut z, &mut work);
        let largest = |v: &[f64], part: std::ops::Range<usize>| {
            v[part].iter().fold(0.0, |m: f64, v| m.max(v.abs()))
        };
        let change = [0..n_u, n_u..b.len()]
            .map(|part| largest(&z, part.clone()) / largest(&x[0], part).max(f64::MIN_POSITIVE));
        let change = change[0].max(change[1]);
        for i in 0..b.len() {
            let (high, low) = two_sum(x[0][i], z[i]);
            (x[0][i], x[1][i]) = two_sum(high, x[1][i] + low);
        }
        if change < 1e-15 {
            let [high, _] = x;
            return Some(high);
        }
        // slow or no convergence: LU has no digits
        if last < 1.0 && change > 0.5 * last {
            return None;
        }
        last = change;
    }
    None
}
