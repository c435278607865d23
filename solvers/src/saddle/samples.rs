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
