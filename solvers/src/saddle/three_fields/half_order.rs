//! M of half order from the blocks alone: nodes are rows of Q1 that act on the same faces.

use super::fixed_stress::neighbours;
use super::near::{NearSchur, entries};
use super::poles::poles;
use super::pressure::PressureSystem;
use super::surface::Surface;
use crate::SetupError;
use crate::direct::{DirectChoice, Kind};
use crate::eigen::dense;
use crate::saddle::FlowBlocks;
use crate::saddle::augmentation::well_conditioned_factor;
use faer::Mat;
use fracas_operators::Preconditioner;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use std::collections::BTreeMap;

/// Share of the largest entry of a row of K below which one is rounding. Unit: 1.
const ROUNDING: f64 = 1e-8;

/// `−L_ab` of two nodes of a face; 2/3 of a face on the diagonal are those of a bilinear square. Unit: 1.
const BETWEEN: f64 = 2.0 / 9.0;

/// The [`Surface`] of blocks whose geometry is not known, and `T + K M` of it, `Q2 ≈ −K Q1ᵀ` by least squares on the pattern of T.
///
/// - Nodes: rows of Q1 with entries on the same faces; both sides of a fracture make one. W is their norm per face.
/// - L: 2/3 per face on the diagonal and −2/9 between any two nodes of it, as if faces were squares of one size; what a face lacks of its
///   four nodes is held.
/// - D: the compliance of the rows of a node held all around, times a factor of each connected part with which M meets `Q1ᵀS̃_u⁻¹Q1` of
///   pressures that are all alike (one solve with S̃_u).
pub(super) fn system(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
    s_u_inverse: &dyn Preconditioner<f64>,
) -> Result<PressureSystem, SetupError> {
    let k = couplings(flow, near, faces)?;
    let mut active: Vec<usize> = k.iter().map(|(_, (_, j))| j as usize).collect();
    active.sort_unstable();
    active.dedup();
    let mut surface = surface(flow, near, &active);
    calibrate(&mut surface, flow, &active, s_u_inverse)?;
    Ok(surface.system(&flow.t, &k))
}

/// W, L, N and D of the open faces.
fn surface(flow: &FlowBlocks, near: &NearSchur, active: &[usize]) -> Surface {
    let [q1, _] = near.couplings(flow);
    let n_p = flow.t.rows();
    // faces of every row, and rows by their faces
    let rows = q1.transpose_view().to_csr();
    let mut nodes: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
    for row in 0..near.len() {
        let faces: Vec<usize> = entries(&rows, row).map(|(j, _)| j).collect();
        if faces.iter().any(|j| active.binary_search(j).is_ok()) {
            nodes.entry(faces).or_default().push(row);
        }
    }
    let n = nodes.len();
    let mut volume = Triplets::new((n_p, n));
    let mut shares: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n_p];
    let mut compliance = Vec::with_capacity(n);
    for (a, (faces, rows_of)) in nodes.iter().enumerate() {
        let (mut given, mut size) = (0.0, 0.0);
        for j in faces {
            let values = rows_of.iter().map(|row| rows.get(*row, *j).copied());
            let squares = values.map(|v| v.unwrap_or(0.0).powi(2));
            let weight = squares.clone().sum::<f64>().sqrt();
            for (row, square) in rows_of.iter().zip(squares) {
                given += square / near.diagonal(*row);
                size += square;
            }
            shares[*j].push((a, weight));
            if active.binary_search(j).is_ok() {
                volume.add_triplet(*j, a, weight);
            }
        }
        compliance.push(given / size);
    }
    let mut laplacian = Triplets::new((n, n));
    let mut area = vec![0.0; n];
    for (j, nodes) in shares.iter().enumerate() {
        let most = nodes.iter().fold(0.0f64, |m, (_, w)| m.max(*w));
        // a closed face holds its nodes
        let is_open = active.binary_search(&j).is_ok();
        for (a, w) in nodes {
            let own = w / most;
            area[*a] += 0.25 * own;
            laplacian.add_triplet(*a, *a, 3.0 * BETWEEN * own);
            for (b, v) in nodes.iter().filter(|(b, _)| is_open && b != a) {
                laplacian.add_triplet(*a, *b, -BETWEEN * own * v / most);
            }
        }
    }
    let laplacian: SparseMatrix<f64> = laplacian.to_csr();
    let high = Surface::highest(&laplacian, &area);
    // N faces along each of two directions
    let low = 2.0 * std::f64::consts::PI.powi(2) / (n.max(1) as f64).powi(2);
    Surface {
        volume: volume.to_csr(),
        interval: (low.min(0.1 * high), high),
        laplacian,
        area,
        compliance,
    }
}

/// K of `Q2 ≈ −K Q1ᵀ`, row by row over face i and its neighbours in T.
fn couplings(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
) -> Result<SparseMatrix<f64>, SetupError> {
    let [q1, q2] = near.couplings(flow);
    let product = |a: &SparseMatrix<f64>, i: usize, b: &SparseMatrix<f64>, j: usize| -> f64 {
        entries(a, i)
            .map(|(row, v)| v * b.get(j, row).copied().unwrap_or(0.0))
            .sum()
    };
    let n_p = flow.t.rows();
    let mut k = Triplets::new((n_p, n_p));
    for &i in faces {
        let moves = |j: &usize| entries(&q1, *j).next().is_some();
        let columns: Vec<usize> = neighbours(flow, i).into_iter().filter(moves).collect();
        let n = columns.len();
        let gram = Mat::from_fn(n, n, |a, b| product(&q1, columns[a], &q1, columns[b]));
        let mut x = Mat::from_fn(n, 1, |a, _| -product(&q2, i, &q1, columns[a]));
        match well_conditioned_factor(&gram) {
            Some(l) => {
                dense::solve_lower(l.as_ref(), &mut x);
                dense::solve_lower_adjoint(l.as_ref(), &mut x);
            }
            // columns depend on each other: face i alone
            None => {
                for a in 0..n {
                    let own = columns[a] == i;
                    x[(a, 0)] = if own { x[(a, 0)] / gram[(a, a)] } else { 0.0 };
                }
            }
        }
        let largest = x.norm_max();
        for (a, &j) in columns.iter().enumerate() {
            if x[(a, 0)].abs() > ROUNDING * largest {
                k.add_triplet(i, j, x[(a, 0)]);
            }
        }
    }
    Ok(k.to_csr())
}

/// D times `pᵀQ1ᵀS̃_u⁻¹Q1p / pᵀMp` of each connected part, p = 1.
fn calibrate(
    surface: &mut Surface,
    flow: &FlowBlocks,
    active: &[usize],
    s_u_inverse: &dyn Preconditioner<f64>,
) -> Result<(), SetupError> {
    let parts = parts(&surface.laplacian);
    let (n_u, n_p) = (flow.q1.rows(), flow.t.rows());
    let part_of = |j: usize| entries(&surface.volume, j).next().map(|(a, _)| parts[a]);
    let mut p = vec![0.0; n_p];
    active.iter().for_each(|&j| p[j] = 1.0);
    // Q1ᵀ S̃_u⁻¹ Q1 p
    let force: Vec<f64> = (0..n_u)
        .map(|row| entries(&flow.q1, row).map(|(j, q)| q * p[j]).sum())
        .collect();
    let mut u = vec![0.0; n_u];
    s_u_inverse.solve(&force, &mut u, &mut vec![0.0; s_u_inverse.work_len()]);
    let mut opening = vec![0.0; n_p];
    for (row, u) in u.iter().enumerate() {
        entries(&flow.q1, row).for_each(|(j, q)| opening[j] += q * u);
    }
    let count = parts.iter().max().map_or(0, |last| last + 1);
    let (mut given, mut made) = (vec![0.0; count], vec![0.0; count]);
    for &j in active {
        if let Some(part) = part_of(j) {
            given[part] += p[j] * opening[j];
        }
    }
    // D^½ Wᵀ p
    let mut pushed = vec![0.0; parts.len()];
    for &j in active {
        entries(&surface.volume, j).for_each(|(a, w)| pushed[a] += w * p[j]);
    }
    (pushed.iter_mut().zip(&surface.compliance)).for_each(|(f, d)| *f *= d.sqrt());
    let direct = DirectChoice::default().solver()?;
    let mut y = vec![0.0; pushed.len()];
    for (sigma, c) in poles(surface.interval) {
        let shifted = surface.shifted(sigma);
        let factors = direct.analyze(&shifted, Kind::Spd)?.factor(&shifted)?;
        factors.solve(&pushed, &mut y, &mut vec![0.0; factors.work_len()]);
        for (a, part) in parts.iter().enumerate() {
            made[*part] += c * pushed[a] * y[a];
        }
    }
    for (d, part) in surface.compliance.iter_mut().zip(&parts) {
        let factor = given[*part] / made[*part];
        if factor > 0.0 && factor.is_finite() {
            *d *= factor;
        }
    }
    Ok(())
}

/// The connected part that each row of a graph belongs to.
fn parts(graph: &SparseMatrix<f64>) -> Vec<usize> {
    let mut parts = vec![usize::MAX; graph.rows()];
    let mut count = 0;
    let mut open = Vec::new();
    for start in 0..graph.rows() {
        if parts[start] != usize::MAX {
            continue;
        }
        open.push(start);
        parts[start] = count;
        while let Some(a) = open.pop() {
            for (b, _) in entries(graph, a) {
                if parts[b] == usize::MAX {
                    parts[b] = count;
                    open.push(b);
                }
            }
        }
        count += 1;
    }
    parts
}
