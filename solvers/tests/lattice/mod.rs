//! Matrices with the pattern and the null space of 3-D elasticity, without a mesh: a lattice of bars between the 26
//! neighbours of every node.

use fracas_operators::sparse::{SparseMatrix, Triplets};

/// How the lattice is held.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Support {
    /// Nodes with x = 0 stand on stiff springs.
    Clamped,
    /// Nodes with x = 0 stand on springs of this stiffness.
    Springs(f64),
    /// Not at all: six rigid motions.
    Floating,
}

/// A box of nodes at unit distance.
pub(crate) struct Lattice {
    size: [usize; 3],
}

impl Lattice {
    pub(crate) fn new(size: [usize; 3]) -> Self {
        Self { size }
    }

    fn node(&self, p: [usize; 3]) -> usize {
        (p[2] * self.size[1] + p[1]) * self.size[0] + p[0]
    }

    fn positions(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let [nx, ny, nz] = self.size;
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }

    fn unknowns(&self) -> usize {
        3 * self.size.iter().product::<usize>()
    }

    /// Σ over bars of k (d dᵀ) between their ends, d the unit direction.
    fn add_stiffness(&self, support: Support, t: &mut Triplets<f64>) {
        for p in self.positions() {
            let a = self.node(p);
            for k in 0..27usize {
                let step = [k % 3, k / 3 % 3, k / 9].map(|s| s as f64 - 1.0);
                let q: [f64; 3] = std::array::from_fn(|c| p[c] as f64 + step[c]);
                let inside = (0..3).all(|c| q[c] >= 0.0 && q[c] < self.size[c] as f64);
                let length: f64 = step.iter().map(|s| s * s).sum::<f64>().sqrt();
                if !inside || length == 0.0 {
                    continue;
                }
                let b = self.node(q.map(|v| v as usize));
                // stiffness varies from bar to bar, equally seen from both ends
                let stiffness = (1.0 + ((a + b) % 5) as f64) / length;
                for (r, c) in (0..9).map(|k| (k / 3, k % 3)) {
                    let value = stiffness * step[r] * step[c] / (length * length);
                    t.add_triplet(3 * a + r, 3 * a + c, value);
                    t.add_triplet(3 * a + r, 3 * b + c, -value);
                }
            }
            let ground = match support {
                Support::Clamped => 10.0,
                Support::Springs(k) => k,
                Support::Floating => 0.0,
            };
            if p[0] == 0 && ground > 0.0 {
                (0..3).for_each(|c| t.add_triplet(3 * a + c, 3 * a + c, ground));
            }
        }
    }

    /// Stiffness matrix.
    pub(crate) fn stiffness(&self, support: Support) -> SparseMatrix<f64> {
        let n = self.unknowns();
        let mut t = Triplets::new((n, n));
        self.add_stiffness(support, &mut t);
        t.to_csr()
    }

    /// `[A Bᵀ; s B −C]`: B takes the difference of the displacements of node pairs across the middle layer, three rows
    /// a pair; `None` for C means no (2,2) block at all.
    pub(crate) fn saddle(&self, c: Option<f64>, s: f64) -> SparseMatrix<f64> {
        let n_u = self.unknowns();
        let pairs: Vec<(usize, usize)> = self
            .positions()
            .filter(|p| p[2] == self.size[2] / 2)
            .map(|p| {
                let below = [p[0], p[1], p[2].saturating_sub(1)];
                (self.node(p), self.node(below))
            })
            .collect();
        let n = n_u + 3 * pairs.len();
        let mut t = Triplets::new((n, n));
        self.add_stiffness(Support::Clamped, &mut t);
        for (k, (above, below)) in pairs.into_iter().enumerate() {
            for component in 0..3 {
                let row = n_u + 3 * k + component;
                for (node, sign) in [(above, 1.0), (below, -0.5)] {
                    t.add_triplet(3 * node + component, row, sign);
                    t.add_triplet(row, 3 * node + component, s * sign);
                }
                if let Some(c) = c {
                    t.add_triplet(row, row, -c);
                }
            }
        }
        t.to_csr()
    }
}
