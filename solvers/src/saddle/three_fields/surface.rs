//! How far open fractures give way to pressures: half the order of a Laplacian on their nodes.

use super::poles::poles;
use super::pressure::PressureSystem;
use fracas_operators::sparse::{SparseMatrix, Triplets};

/// The open faces of fractures and the nodes at which they open.
///
/// A crack opens under a pressure of wave number k by `4p/(E' k)`, E' = E/(1 − ν²), so that
/// ```text
/// −Q2 S_u⁻¹ Q1 ≈ M = K W P Wᵀ,   P = D^½ Σ c_i (L + σ_i N)⁻¹ D^½ ≈ D^½ N^(−½) (N^(−½) L N^(−½))^(−½) N^(−½) D^½
/// ```
/// W averages over the nodes of a face as B_n does: pressures that alternate from face to face open nothing. Nodes at tips and beside
/// faces that none of these touch are held, and are none of them.
///
/// # Source
/// Derived here; the opening of a half space under a wave of pressure is Boussinesq's (K. L. Johnson, Contact Mechanics, 1985, §13.2).
#[derive(Clone, Debug)]
pub struct Surface {
    /// W, faces × nodes: volume of a face by the opening of a node; rows of closed faces are empty.
    pub volume: SparseMatrix<f64>,
    /// L, nodes × nodes: the Laplacian.
    pub laplacian: SparseMatrix<f64>,
    /// N: area of a node.
    pub area: Vec<f64>,
    /// D: 4/E' at a node.
    pub compliance: Vec<f64>,
    /// Bounds of the eigenvalues of N⁻¹L.
    pub interval: (f64, f64),
}

impl Surface {
    /// `T + M` for `M = K W P Wᵀ`, its inverse by the sparse `[T, c_1 K W D^½, …; D^½ Wᵀ, −(L + σ_1 N); …]`.
    pub fn system(&self, t: &SparseMatrix<f64>, k: &SparseMatrix<f64>) -> PressureSystem {
        let (n_p, nodes) = (t.rows(), self.area.len());
        if nodes == 0 {
            return t.clone().into();
        }
        let poles = poles(self.interval);
        let root: Vec<f64> = self.compliance.iter().map(|d| d.sqrt()).collect();
        let mut whole = Triplets::new((n_p + poles.len() * nodes, n_p + poles.len() * nodes));
        for (value, (i, j)) in t {
            whole.add_triplet(i as usize, j as usize, *value);
        }
        let taken = k * &self.volume;
        for (number, (sigma, c)) in poles.iter().enumerate() {
            let first = n_p + number * nodes;
            for (value, (i, a)) in &taken {
                let a = a as usize;
                whole.add_triplet(i as usize, first + a, c * value * root[a]);
            }
            for (value, (j, a)) in &self.volume {
                let a = a as usize;
                whole.add_triplet(first + a, j as usize, value * root[a]);
            }
            for (value, (a, b)) in &self.shifted(*sigma) {
                whole.add_triplet(first + a as usize, first + b as usize, -value);
            }
        }
        PressureSystem::with_auxiliary(whole.to_csr(), n_p)
    }

    /// `L + σ N`.
    pub(super) fn shifted(&self, sigma: f64) -> SparseMatrix<f64> {
        let n = self.area.len();
        let mut shifted = Triplets::new((n, n));
        for (value, (a, b)) in &self.laplacian {
            shifted.add_triplet(a as usize, b as usize, *value);
        }
        for (a, area) in self.area.iter().enumerate() {
            shifted.add_triplet(a, a, sigma * area);
        }
        shifted.to_csr()
    }

    /// An upper bound of the eigenvalues of N⁻¹L by Gershgorin.
    pub fn highest(laplacian: &SparseMatrix<f64>, area: &[f64]) -> f64 {
        let rows = laplacian.outer_iterator().zip(area);
        let bounds = rows.map(|(row, area)| row.data().iter().map(|v| v.abs()).sum::<f64>() / area);
        bounds.fold(0.0, f64::max)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::eigen::dense::to_dense;
    use crate::eigen::factors::inverse;
    use crate::saddle::PressureFactors;
    use faer::Mat;
    use fracas_operators::Preconditioner;
    use fracas_operators::random::signed;

    fn matrix(rows: usize, cols: usize, entry: impl Fn(usize, usize) -> f64) -> SparseMatrix<f64> {
        let mut m = Triplets::new((rows, cols));
        for i in 0..rows {
            for j in 0..cols {
                m.add_triplet(i, j, entry(i, j));
            }
        }
        m.to_csr()
    }

    /// Against `(T + K W D^½ Σ c_i (L + σ_i N)⁻¹ D^½ Wᵀ)⁻¹`, all dense.
    #[test]
    fn factors_with_the_nodes_behind_the_pressures_invert_the_sum_of_poles() {
        for seed in 0..20 {
            let number = |k: usize| signed(1_000 * seed + k as u64);
            let (n_p, nodes) = (5, 4);
            let surface = Surface {
                volume: matrix(
                    n_p,
                    nodes,
                    |i, a| if i < 3 { number(10 * i + a) } else { 0.0 },
                ),
                laplacian: matrix(nodes, nodes, |a, b| match a.abs_diff(b) {
                    0 => 2.0,
                    1 => -1.0,
                    _ => 0.0,
                }),
                area: (0..nodes).map(|a| 1.5 + number(100 + a)).collect(),
                compliance: (0..nodes).map(|a| 1.2 + number(200 + a)).collect(),
                interval: (0.1, 8.0),
            };
            let t = matrix(n_p, n_p, |i, j| match i == j {
                true => 3.0,
                false => 0.3 * number(300 + 10 * i + j),
            });
            let k = matrix(n_p, n_p, |i, j| match j < 3 {
                true => number(400 + 10 * i + j) + f64::from(u8::from(i == j)),
                false => 0.0,
            });
            let (w, n) = (to_dense(&surface.volume), surface.area.len());
            let mut p = Mat::<f64>::zeros(n, n);
            for (sigma, c) in poles(surface.interval) {
                let solved = inverse(to_dense(&surface.shifted(sigma)).as_ref()).unwrap();
                for a in 0..n {
                    for b in 0..n {
                        let d = (surface.compliance[a] * surface.compliance[b]).sqrt();
                        p[(a, b)] += c * d * solved[(a, b)];
                    }
                }
            }
            let s_p = to_dense(&t) + to_dense(&k) * (&w * p * w.transpose());
            let factors = PressureFactors::default()
                .factor(&surface.system(&t, &k))
                .unwrap();
            let mut work = vec![0.0; factors.work_len()];
            for j in 0..n_p {
                let r: Vec<f64> = (0..n_p).map(|i| s_p[(i, j)]).collect();
                let mut z = vec![0.0; n_p];
                factors.solve(&r, &mut z, &mut work);
                for (i, z) in z.iter().enumerate() {
                    let expected = f64::from(u8::from(i == j));
                    assert!((z - expected).abs() < 1e-9, "seed {seed}: {z} at {i}, {j}");
                }
            }
        }
    }
}
