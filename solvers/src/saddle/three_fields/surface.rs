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
