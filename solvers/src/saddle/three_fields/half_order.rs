//! M of half order: what an open fracture gives way to pressures, smooth ones and rough ones.

use super::fixed_stress::{neighbours, response};
use super::near::{NearSchur, entries};
use super::pressure::PressureSystem;
use crate::SetupError;
use crate::direct::{DirectChoice, Kind};
use crate::eigen::dense;
use crate::saddle::FlowBlocks;
use crate::saddle::augmentation::well_conditioned_factor;
use faer::Mat;
use fracas_operators::Preconditioner;
use fracas_operators::random::signed;
use fracas_operators::sparse::{SparseMatrix, Triplets};

/// Share of the largest entry of a row of K below which one is rounding. Unit: 1.
const ROUNDING: f64 = 1e-8;

/// Distance of poles in ln √σ: `x^(−½)` is met to 2 exp(−π²/STEP), 3 %, between them. Unit: 1.
const STEP: f64 = 2.3;

/// How far poles reach beyond the ends of the interval, in ln √σ. Unit: 1.
const BEYOND: f64 = 0.7;

/// Points at which the weights of the poles are fitted. Unit: 1.
const POINTS: usize = 60;

/// Share of `L^(−½)` at checkerboards that is left out: with a tenth of it M_s stays positive whatever the poles miss. Unit: 1.
const ROUGH: f64 = 0.9;

/// Sweeps of the fit, each of which keeps weights positive. Unit: 1.
const SWEEPS: usize = 400;

/// `T + K M_s`, `M_s = D^½ (L^(−½) − r) D^½` where `Q2 ≈ −K Q1ᵀ`: a sparse K by least squares on the pattern of T, which is 1/Δt and the
/// derivatives of conductivities.
///
/// - D: γ times the fixed stress `r(q1_j)ᵀ (S_u|_j)⁻¹ r(q1_j)`, with a γ of each connected part of the open faces so that M_s meets
///   `Q1ᵀS̃_u⁻¹Q1` of pressures that are alike on it (one solve with S̃_u, signs drawn by parts).
/// - r: 0.9 of the value of `L^(−½)` at checkerboards, which B_n averages away: they open nothing.
/// - L: the graph Laplacian of open neighbours in T, with a diagonal as of faces inside a fracture, since a tip or a closed neighbour
///   holds the opening.
///
/// A crack opens under a pressure of wave number k by `2p/(E' k)`, E' = E/(1 − ν²): the stiffness is of half the order of a Laplacian.
/// The fixed stress is that of the shortest waves and misses smooth ones by the length of the fracture over that of a face, the eigenvalues of
/// M⁻¹S reach N; those of M_s⁻¹S do not depend on N.
///
/// `x^(−½) ≈ Σ c_i/(x + σ_i)`, c_i > 0, with three to six poles; S_p⁻¹ comes from the sparse
/// `[T, c_1 K D^½, …; D^½, −(L + σ_1); …]`.
///
/// # Source
/// Derived here; poles by the trapezoidal rule of `x^(−½) = (2/π) ∫ eˢ/(x + e²ˢ) ds` (N. Hale, N. J. Higham, L. N. Trefethen, SIAM J.
/// Numer. Anal. 46 (2008) 2505–2523), weights fitted.
pub(super) fn system(
    flow: &FlowBlocks,
    near: &NearSchur,
    faces: &[usize],
    s_u_inverse: &dyn Preconditioner<f64>,
) -> Result<PressureSystem, SetupError> {
    let n_p = flow.t.rows();
    let k = couplings(flow, near, faces)?;
    let mut is_active = vec![false; n_p];
    k.iter()
        .for_each(|(_, (_, j))| is_active[j as usize] = true);
    let active: Vec<usize> = (0..n_p).filter(|&j| is_active[j]).collect();
    let l = laplacian(flow, &active);
    let poles = Poles::new(interval(&l));
    let [q1, _] = near.couplings(flow);
    let mut d = Vec::with_capacity(active.len());
    for &j in &active {
        let support: Vec<usize> = entries(&q1, j).map(|(row, _)| row).collect();
        let own = response(near.matrix(), &support, (&q1, j), (&q1, &[j]))?;
        d.push(own.first().map_or(0.0, |(_, value)| value.abs()));
    }
    let gamma = calibration(flow, (&active, &l), &poles, &d, s_u_inverse)?;
    let root: Vec<f64> = d.iter().zip(gamma).map(|(d, g)| (g * d).sqrt()).collect();

    let mut place = vec![None; n_p];
    (active.iter().enumerate()).for_each(|(a, &j)| place[j] = Some(a));
    let rough = |j: usize| place[j].map_or(0.0, |a| poles.rough * root[a] * root[a]);
    let size = n_p + poles.poles.len() * active.len();
    let mut whole = Triplets::new((size, size));
    for (value, (i, j)) in &flow.t {
        whole.add_triplet(i as usize, j as usize, *value);
    }
    for (value, (i, j)) in &k {
        whole.add_triplet(i as usize, j as usize, -value * rough(j as usize));
    }
    for (number, (sigma, c)) in poles.poles.iter().enumerate() {
        let first = n_p + number * active.len();
        for (value, (i, j)) in &k {
            if let Some(a) = place[j as usize] {
                whole.add_triplet(i as usize, first + a, c * value * root[a]);
            }
        }
        for (a, &j) in active.iter().enumerate() {
            whole.add_triplet(first + a, j, root[a]);
            whole.add_triplet(first + a, first + a, -sigma);
        }
        for (value, (a, b)) in &l {
            whole.add_triplet(first + a as usize, first + b as usize, -value);
        }
    }
    Ok(PressureSystem::with_auxiliary(whole.to_csr(), n_p))
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

/// `L_ab = −1` for neighbours in T, on the diagonal the edges of a face inside a fracture.
fn laplacian(flow: &FlowBlocks, active: &[usize]) -> SparseMatrix<f64> {
    let others = |j: usize| entries(&flow.t, j).filter(move |(k, _)| *k != j);
    let mut counts: Vec<usize> = active.iter().map(|&j| others(j).count()).collect();
    counts.sort_unstable();
    // two edges along a line, four in a plane; more at junctions
    let inside =
        (counts.get(counts.len() / 2)).map_or(2, |median| median.next_multiple_of(2).max(2));
    let mut l = Triplets::new((active.len(), active.len()));
    for (a, &j) in active.iter().enumerate() {
        let open = others(j).filter_map(|(k, _)| active.binary_search(&k).ok());
        let open: Vec<usize> = open.collect();
        l.add_triplet(a, a, open.len().max(inside) as f64);
        open.into_iter().for_each(|b| l.add_triplet(a, b, -1.0));
    }
    l.to_csr()
}

/// An interval that holds the eigenvalues of L: from that of the smoothest wave, `π²/N²` per direction, to Gershgorin's bound.
fn interval(l: &SparseMatrix<f64>) -> (f64, f64) {
    let most = l.diag_iter().map(|l| l.copied().unwrap_or(0.0));
    let most = most.fold(2.0, f64::max);
    let n = l.rows().max(1) as f64;
    // N faces along each of (edges / 2) directions
    let low = match most > 2.0 {
        true => 2.0 * std::f64::consts::PI.powi(2) / n,
        false => std::f64::consts::PI.powi(2) / (n * n),
    };
    (low.min(1.0), 2.0 * most)
}

/// `(σ_i, c_i)` and r of `Σ c_i/(x + σ_i) − r`.
#[derive(Clone, Debug)]
struct Poles {
    poles: Vec<(f64, f64)>,
    rough: f64,
}

impl Poles {
    /// For this interval.
    fn new((low, high): (f64, f64)) -> Self {
        let (first, last) = (0.5 * low.ln() - BEYOND, 0.5 * high.ln() + BEYOND);
        let n = ((last - first) / STEP).ceil().max(1.0) as usize + 1;
        let step = (last - first) / (n - 1) as f64;
        let node = |i: usize| first + step * i as f64;
        let sigma: Vec<f64> = (0..n).map(|i| (2.0 * node(i)).exp()).collect();
        let weight = |i: usize| 2.0 / std::f64::consts::PI * step * node(i).exp();
        let mut c: Vec<f64> = (0..n).map(weight).collect();
        let x = (0..POINTS).map(|k| low * (high / low).powf(k as f64 / (POINTS - 1) as f64));
        // g_ki = √x_k/(x_k + σ_i), to be one with c; c ← c (gᵀ1)/(gᵀg c)
        let g: Vec<Vec<f64>> = x
            .map(|x| sigma.iter().map(|s| x.sqrt() / (x + s)).collect())
            .collect();
        for _ in 0..SWEEPS {
            let met: Vec<f64> = (g.iter())
                .map(|g| g.iter().zip(&c).map(|(g, c)| g * c).sum())
                .collect();
            for (i, c) in c.iter_mut().enumerate() {
                let wanted: f64 = g.iter().map(|g| g[i]).sum();
                let found: f64 = g.iter().zip(&met).map(|(g, met)| g[i] * met).sum();
                *c *= wanted / found;
            }
        }
        Self {
            poles: sigma.into_iter().zip(c).collect(),
            rough: ROUGH / high.sqrt(),
        }
    }

    /// `Σ c_i/(x + σ_i)`.
    #[cfg(test)]
    fn value(&self, x: f64) -> f64 {
        self.poles.iter().map(|(sigma, c)| c / (x + sigma)).sum()
    }
}

/// γ of every open face: `pᵀQ1ᵀS̃_u⁻¹Q1p / pᵀM_sp` over its part, p = ±1.
fn calibration(
    flow: &FlowBlocks,
    (active, l): (&[usize], &SparseMatrix<f64>),
    poles: &Poles,
    d: &[f64],
    s_u_inverse: &dyn Preconditioner<f64>,
) -> Result<Vec<f64>, SetupError> {
    let parts = parts(l);
    let p: Vec<f64> = (parts.iter())
        .map(|part| {
            if signed(*part as u64) < 0.0 {
                -1.0
            } else {
                1.0
            }
        })
        .collect();
    // Q1ᵀ S̃_u⁻¹ Q1 p
    let n_u = flow.q1.rows();
    let mut all = vec![0.0; flow.t.rows()];
    active.iter().zip(&p).for_each(|(&j, p)| all[j] = *p);
    let force: Vec<f64> = (0..n_u)
        .map(|row| entries(&flow.q1, row).map(|(j, q)| q * all[j]).sum())
        .collect();
    let mut u = vec![0.0; n_u];
    s_u_inverse.solve(&force, &mut u, &mut vec![0.0; s_u_inverse.work_len()]);
    let mut opening = vec![0.0; flow.t.rows()];
    for (row, u) in u.iter().enumerate() {
        entries(&flow.q1, row).for_each(|(j, q)| opening[j] += q * u);
    }
    // D^½ (Σ c_i (L + σ_i)⁻¹ − r) D^½ p
    let n = active.len();
    let weighted: Vec<f64> = d.iter().zip(&p).map(|(d, p)| d.sqrt() * p).collect();
    let mut model: Vec<f64> = weighted.iter().map(|p| -poles.rough * p).collect();
    let direct = DirectChoice::default().solver()?;
    for (sigma, c) in &poles.poles {
        let shifted = l + &SparseMatrix::eye(n).map(|one: &f64| sigma * one);
        let factors = direct.analyze(&shifted, Kind::Spd)?.factor(&shifted)?;
        let mut y = vec![0.0; n];
        factors.solve(&weighted, &mut y, &mut vec![0.0; factors.work_len()]);
        model.iter_mut().zip(&y).for_each(|(m, y)| *m += c * y);
    }
    let count = parts.iter().max().map_or(0, |last| last + 1);
    let (mut given, mut made) = (vec![0.0; count], vec![0.0; count]);
    for a in 0..n {
        given[parts[a]] += p[a] * opening[active[a]];
        made[parts[a]] += p[a] * d[a].sqrt() * model[a];
    }
    let gamma = |part: &usize| match given[*part] / made[*part] {
        gamma if gamma > 0.0 && gamma.is_finite() => gamma,
        _ => 1.0,
    };
    Ok(parts.iter().map(gamma).collect())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn poles_meet_the_inverse_root_within_a_tenth_and_are_few() {
        for low in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-6] {
            let poles = Poles::new((low, 8.0));
            assert!(poles.poles.len() <= 6, "{} poles", poles.poles.len());
            assert!(
                poles
                    .poles
                    .iter()
                    .all(|(sigma, c)| *sigma > 0.0 && *c > 0.0)
            );
            for k in 0..=200 {
                let x = low * (8.0 / low).powf(f64::from(k) / 200.0);
                let met = x.sqrt() * poles.value(x);
                assert!((met - 1.0).abs() < 0.1, "{met} at {x:e} of {low:e}");
            }
        }
    }
}
