//! Small saddle points with known properties, for tests.

use super::SaddleBlocks;
use fracas_operators::laws::probe;
use fracas_operators::sparse::{SparseMatrix, Triplets};

/// All entries of `entry(i, j)` that are not zero.
pub(crate) fn sparse(
    rows: usize,
    cols: usize,
    entry: impl Fn(usize, usize) -> f64,
) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((rows, cols));
    for i in 0..rows {
        for j in 0..cols {
            let value = entry(i, j);
            if value != 0.0 {
                triplets.add_triplet(i, j, value);
            }
        }
    }
    triplets.to_csr()
}

/// Random dense blocks: A = RRᵀ/n + δI, B, and `H = h·QQᵀ` of rank n_t/2 + 1.
pub(crate) fn random(n_u: usize, n_t: usize, h: f64, seed: u64) -> SaddleBlocks {
    let r: Vec<f64> = probe(n_u * n_u, seed);
    let b: Vec<f64> = probe(n_u * n_t, seed + 1000);
    let q: Vec<f64> = probe(n_t * n_t, seed + 2000);
    let rank = n_t / 2 + 1;
    let gram = |v: &[f64], n: usize, k: usize, i: usize, j: usize| -> f64 {
        (0..k).map(|l| v[l * n + i] * v[l * n + j]).sum()
    };
    let a = sparse(n_u, n_u, |i, j| {
        gram(&r, n_u, n_u, i, j) / n_u as f64 + if i == j { 1e-2 } else { 0.0 }
    });
    let h = (h != 0.0).then(|| sparse(n_t, n_t, |i, j| h * gram(&q, n_t, rank, i, j)));
    SaddleBlocks {
        a,
        b1: sparse(n_u, n_t, |i, j| b[i * n_t + j]),
        b2: None,
        h,
        rhs_u: vec![0.0; n_u],
        rhs_t: vec![0.0; n_t],
        coordinates: None,
        flow: None,
    }
}

/// Two chains of springs with a jump condition at every node of their contact: n nodes a side, stiffness ratio
/// `contrast`; only the first chain is held when `floating`, so A is singular.
///
/// A = diag(K, contrast·K'), B = [−I; I] on the last m nodes, like an assembled fracture between two blocks.
pub(crate) fn two_chains(n: usize, m: usize, contrast: f64, floating: bool) -> SaddleBlocks {
    let chain = |i: usize, j: usize, held: bool| -> f64 {
        let end = if i == 0 {
            f64::from(u8::from(held))
        } else {
            1.0
        };
        match i.abs_diff(j) {
            0 => end + if i + 1 < n { 1.0 } else { 0.0 },
            1 => -1.0,
            _ => 0.0,
        }
    };
    let a = sparse(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => chain(i, j, true),
        (false, false) => contrast * chain(i - n, j - n, !floating),
        _ => 0.0,
    });
    let b1 = sparse(2 * n, m, |i, k| match i {
        i if i == n - m + k => -1.0,
        i if i == 2 * n - m + k => 1.0,
        _ => 0.0,
    });
    SaddleBlocks {
        a,
        b1,
        b2: None,
        h: None,
        rhs_u: vec![0.0; 2 * n],
        rhs_t: vec![0.0; m],
        coordinates: None,
        flow: None,
    }
}

/// Two cubes of m×m×m nodes one above the other, trusses along edges and diagonals, three tractions at every pair of
/// facing nodes: contact between elastic blocks. The lower one is held at its bottom, the upper one (of `contrast`
/// times the stiffness) at its top unless `floating`.
pub(crate) fn trusses(m: usize, contrast: f64, floating: bool) -> SaddleBlocks {
    let node = |block: usize, p: [usize; 3]| block * m.pow(3) + (p[2] * m + p[1]) * m + p[0];
    let points = || (0..m.pow(3)).map(|k| [k % m, k / m % m, k / (m * m)]);
    let n_u = 6 * m.pow(3);
    let mut a = Triplets::new((n_u, n_u));
    for (block, stiffness) in [(0, 1.0), (1, contrast)] {
        for p in points() {
            for k in 14..27 {
                // Half of the 26 neighbours: d after (0, 0, 0) in the order of k.
                let d = [k % 3, k / 3 % 3, k / 9];
                let q = [p[0] + d[0], p[1] + d[1], p[2] + d[2]];
                if q.iter().any(|&c| c == 0 || c > m) {
                    continue;
                }
                let (i, j) = (node(block, p), node(block, q.map(|c| c - 1)));
                let e = d.map(|c| c as f64 - 1.0);
                let length_squared: f64 = e.iter().map(|c| c * c).sum();
                for r in 0..3 {
                    for c in 0..3 {
                        let value = stiffness * e[r] * e[c] / length_squared;
                        a.add_triplet(3 * i + r, 3 * i + c, value);
                        a.add_triplet(3 * j + r, 3 * j + c, value);
                        a.add_triplet(3 * i + r, 3 * j + c, -value);
                        a.add_triplet(3 * j + r, 3 * i + c, -value);
                    }
                }
            }
            let held = (block == 0 && p[2] == 0) || (block == 1 && p[2] == m - 1 && !floating);
            if held {
                let i = node(block, p);
                (0..3).for_each(|r| a.add_triplet(3 * i + r, 3 * i + r, stiffness));
            }
        }
    }
    let mut b = Triplets::new((n_u, 3 * m * m));
    for f in 0..m * m {
        let (x, y) = (f % m, f / m);
        for r in 0..3 {
            b.add_triplet(3 * node(0, [x, y, m - 1]) + r, 3 * f + r, -0.5);
            b.add_triplet(3 * node(1, [x, y, 0]) + r, 3 * f + r, 0.5);
        }
    }
    SaddleBlocks {
        a: a.to_csr(),
        b1: b.to_csr(),
        b2: None,
        h: None,
        rhs_u: vec![0.0; n_u],
        rhs_t: vec![0.0; 3 * m * m],
        coordinates: None,
        flow: None,
    }
}

/// What flow is like beside a system with three tractions a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// Share of open faces.
    pub(crate) open: f64,
    /// Size of T.
    pub(crate) size: f64,
    /// Storage, relative to T.
    pub(crate) storage: f64,
    /// Derivative of the conductivity, relative to `1/Δt`: the part of Q2 that is no transpose of Q1.
    pub(crate) derivative: f64,
    /// 1/Δt.
    pub(crate) rate: f64,
}

/// The same system with a pressure per face: `Q1 = −B_n`; on open faces `Q2 = B_nᵀ/Δt` and derivatives, and the contact law t = 0; T a
/// graph of neighbours in a row with conductivities over four magnitudes.
pub(crate) fn with_flow(stick: SaddleBlocks, flow: Flow, seed: u64) -> SaddleBlocks {
    let (n_u, n_p) = (stick.n_u(), stick.n_t() / 3);
    let number = |k: u64| fracas_operators::random::signed(seed * 7919 + k);
    let open: Vec<bool> = (0..n_p)
        .map(|f| 0.5 * (1.0 + number(f as u64)) < flow.open)
        .collect();
    let b_n = |row: usize, f: usize| stick.b1.get(row, 3 * f).copied().unwrap_or(0.0);
    let q1 = sparse(n_u, n_p, |row, f| -b_n(row, f));
    let q2 = sparse(n_p, n_u, |f, row| {
        let near = (f.saturating_sub(1)..n_p.min(f + 2)).filter(|&g| open[g]);
        let derivative = |g: usize| {
            let sign = if f == g { 1.0 } else { -0.5 };
            flow.derivative * sign * number((1000 + f * n_p + g) as u64) * b_n(row, g)
        };
        let own = if open[f] { b_n(row, f) } else { 0.0 };
        flow.rate * (own + near.map(derivative).sum::<f64>())
    });
    let conductivity = |f: usize| flow.size * 10f64.powf(2.0 * number((500 + f) as u64));
    let t = sparse(n_p, n_p, |f, g| match f.abs_diff(g) {
        0 => {
            let before = if f > 0 { conductivity(f - 1) } else { 0.0 };
            let behind = if f + 1 < n_p { conductivity(f) } else { 0.0 };
            before + behind + flow.storage * flow.size
        }
        1 => -conductivity(f.min(g)),
        _ => 0.0,
    });
    let is_open = |k: usize| open[k / 3];
    let h = |k: usize, l: usize| match is_open(k) || is_open(l) {
        true => f64::from(u8::from(k == l)),
        false => stick
            .h
            .as_ref()
            .and_then(|h| h.get(k, l))
            .map_or(0.0, |h| *h),
    };
    let b2 = sparse(stick.n_t(), n_u, |k, row| match is_open(k) {
        true => 0.0,
        false => stick.b1.get(row, k).copied().unwrap_or(0.0),
    });
    let h = sparse(stick.n_t(), stick.n_t(), h);
    SaddleBlocks {
        b2: open.contains(&true).then_some(b2),
        h: (h.nnz() > 0).then_some(h),
        flow: Some(super::FlowBlocks {
            q1,
            q2,
            t,
            rhs_p: vec![0.0; n_p],
        }),
        ..stick
    }
}
