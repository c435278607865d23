//! What the rock around open faces gives way to a pressure: M of `S_p = T + M`.

use super::near::{NearSchur, entries};
use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::FlowBlocks;
use crate::saddle::augmentation::{for_restricted, well_conditioned_factor};
use faer::Mat;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_operators::vector::{dot, norm2};
use rayon::prelude::*;

/// Steps of the power iteration for the largest eigenvalue of M⁻¹S: it is that of smooth pressures, which the start is. Unit: 1.
const STEPS: usize = 6;

/// A row of M by its face, entries `(column, value)`.
type Row = (usize, Vec<(usize, f64)>);

/// `M_ii = −r(q2_i) (S_u|_i)⁻¹ r(q1_i)`, on the displacements in column i of Q1, for these faces; `−sign(q2_i·q1_i) ‖r(q2_i)‖ ‖r(q1_i)‖ /
/// ‖S_u|_i‖` where S_u|_i is not positive definite.
///
/// Everything around the face is held: where `Q2 = −Q1ᵀ/Δt`, M_ii is at most the volume that rock free to move gives.
///
/// # Source
/// M. Ferronato, SNA'25 lecture, slide on the algebraic fixed stress; here one pressure per face.
pub(super) fn by_face(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
) -> Result<SparseMatrix<f64>, SetupError> {
    restricted(flow, near, faces, |i| vec![i])
}

/// `M_ij = −r(q2_i) (S_u|_i)⁻¹ r(q1_j)`, j = i and its neighbours in T, on the displacements in their columns of Q1.
pub(super) fn by_patch(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
) -> Result<SparseMatrix<f64>, SetupError> {
    restricted(flow, near, faces, |i| neighbours(flow, i))
}

/// `M_ij` for every j of the columns of face i, on the displacements in these columns of Q1.
fn restricted(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
    columns: impl Fn(usize) -> Vec<usize> + Sync,
) -> Result<SparseMatrix<f64>, SetupError> {
    let [q1, q2] = near.couplings(flow);
    rows(flow, faces, |i| {
        let columns = columns(i);
        let mut support: Vec<usize> = (columns.iter())
            .flat_map(|&j| entries(&q1, j).map(|(row, _)| row))
            .collect();
        support.sort_unstable();
        support.dedup();
        let response = response(near.matrix(), &support, (&q2, i), (&q1, &columns))?;
        Ok((i, response))
    })
}

/// `M_ij = −Σ_k q2_ik q1_kj / (S_u)_kk`, j = i and its neighbours in T.
pub(super) fn by_diagonal(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
) -> Result<SparseMatrix<f64>, SetupError> {
    let [q1, q2] = near.couplings(flow);
    let diagonal: Vec<f64> = (near.matrix().diag_iter())
        .map(|s| s.copied().unwrap_or(0.0))
        .collect();
    if let Some(row) = diagonal.iter().position(|s| s.is_nan() || *s <= 0.0) {
        return Err(SetupError::BadDiagonal {
            block: "S_u",
            row: near.row(row) + 1,
            value: diagonal[row],
            method: "T − Q2 diag(S_u)⁻¹ Q1",
        });
    }
    rows(flow, faces, |i| {
        let row = neighbours(flow, i).into_iter().map(|j| {
            let products = entries(&q2, i).map(|(k, q2)| q2 * entry(&q1, j, k) / diagonal[k]);
            (j, -products.sum::<f64>())
        });
        Ok((i, row.collect()))
    })
}

/// `√(δΔ)` with δ = 1 and the largest eigenvalue Δ of `M⁻¹S`, `S = −Q2 S̃_u⁻¹ Q1`, found from pressures that are all alike.
pub(super) fn middle(
    flow: &FlowBlocks,
    m: &SparseMatrix<f64>,
    s_u_inverse: &dyn Preconditioner<f64>,
) -> f64 {
    let (n_u, n_p) = (flow.q1.rows(), flow.t.rows());
    let m: Vec<f64> = (0..n_p)
        .map(|i| m.get(i, i).copied().unwrap_or(0.0))
        .collect();
    let mut p: Vec<f64> = m.iter().map(|m| f64::from(u8::from(*m != 0.0))).collect();
    let mut work = vec![0.0; s_u_inverse.work_len()];
    let (mut force, mut u, mut largest) = (vec![0.0; n_u], vec![0.0; n_u], 1.0);
    for _ in 0..STEPS {
        multiply(&flow.q1, &p, &mut force);
        s_u_inverse.solve(&force, &mut u, &mut work);
        let mut next = vec![0.0; n_p];
        multiply(&flow.q2, &u, &mut next);
        for (next, m) in next.iter_mut().zip(&m) {
            *next = if *m == 0.0 { 0.0 } else { -*next / m };
        }
        largest = dot(&p, &next) / dot(&p, &p);
        let size = norm2(&next);
        p = next.iter().map(|p| p / size).collect();
    }
    match largest.is_finite() {
        true => largest.max(1.0).sqrt(),
        false => 1.0,
    }
}

/// `y ← M x`.
fn multiply(m: &SparseMatrix<f64>, x: &[f64], y: &mut [f64]) {
    for (i, y) in y.iter_mut().enumerate() {
        *y = entries(m, i).map(|(j, v)| v * x[j]).sum();
    }
}

/// Rows of M for these faces, in parallel.
fn rows(
    flow: &FlowBlocks,
    faces: &[usize],
    row: impl Fn(usize) -> Result<Row, SetupError> + Sync,
) -> Result<SparseMatrix<f64>, SetupError> {
    let rows = faces.par_iter().map(|&i| row(i));
    let rows = rows.collect::<Result<Vec<Row>, SetupError>>()?;
    let n_p = flow.t.rows();
    let mut m = Triplets::new((n_p, n_p));
    for (i, row) in rows {
        row.into_iter()
            .for_each(|(j, value)| m.add_triplet(i, j, value));
    }
    Ok(m.to_csr())
}

/// Face i and those that T couples its balance with, ascending.
pub(super) fn neighbours(flow: &FlowBlocks, i: usize) -> Vec<usize> {
    let mut all: Vec<usize> = entries(&flow.t, i).map(|(j, _)| j).collect();
    if let Err(place) = all.binary_search(&i) {
        all.insert(place, i);
    }
    all
}

/// An entry of a matrix by rows, 0 where it has none.
fn entry(m: &SparseMatrix<f64>, i: usize, j: usize) -> f64 {
    m.get(i, j).copied().unwrap_or(0.0)
}

/// `−r(q2_i) (S_u|)⁻¹ r(q1_j)` on a support, for every j of `columns`.
pub(super) fn response(
    s_u: &SparseMatrix<f64>,
    support: &[usize],
    (q2, i): (&SparseMatrix<f64>, usize),
    (q1, columns): (&SparseMatrix<f64>, &[usize]),
) -> Result<Vec<(usize, f64)>, SetupError> {
    let n = support.len();
    if n == 0 {
        return Ok(Vec::new());
    }
    let mut restricted = Mat::zeros(n, n);
    for_restricted(s_u, support, |k, l, value| restricted[(k, l)] = value);
    // r(q2_i), r(q1_j), …
    let mut b = Mat::from_fn(n, 1 + columns.len(), |k, column| match column {
        0 => entry(q2, i, support[k]),
        _ => entry(q1, columns[column - 1], support[k]),
    });
    let product = |b: &Mat<f64>, j: usize| -> f64 { b.col(0).transpose() * b.col(j) };
    let Some(l) = well_conditioned_factor(&restricted) else {
        let values = dense::symmetric_eigenvalues(restricted.as_ref())?;
        let norm = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let of = |j: usize| match (j, norm > 0.0) {
            (_, false) => 0.0,
            (j, true) => -product(&b, j).signum() * b.col(0).norm_l2() * b.col(j).norm_l2() / norm,
        };
        // neighbours do not count then
        let own = columns.iter().position(|&j| j == i);
        return Ok(own.map(|k| (i, of(k + 1))).into_iter().collect());
    };
    dense::solve_lower(l.as_ref(), &mut b);
    let row = columns
        .iter()
        .enumerate()
        .map(|(k, &j)| (j, -product(&b, k + 1)));
    Ok(row.collect())
}
