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
