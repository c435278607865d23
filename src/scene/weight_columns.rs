//! The weight above a point in columns of elements whose sides are upright.

use crate::mesh::HexMesh;

/// σ_v = ∫ ρ g dz from a point up, exact for elements whose sides are upright along x and y and whose tops and bottoms are bilinear.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WeightColumns {
    /// Where sides are [m].
    lines: [Vec<f64>; 2],
    /// Elements in a column.
    count: usize,
    /// Per column, x first, per level from the bottom up, heights [m] and σ_v [Pa] at its four corners, counter-clockwise.
    corners: Vec<[(f64, f64); 4]>,
}

/// Share of the width of an element within which a side is upright. Unit: 1.
const CLOSE: f64 = 1e-9;

impl WeightColumns {
    /// Of a grid whose nodes stay on their lines in x and y; `None` of any other. `weights` are forces per volume along z, per region [N/m³].
    pub(super) fn new(mesh: &HexMesh, weights: &[f64]) -> Option<Self> {
        let grid = mesh.grid.as_ref()?;
        let [nx, ny, count] = grid.cells;
        let lines = [grid.lines[0].clone(), grid.lines[1].clone()];
        let mut corners = vec![[(0.0, 0.0); 4]; nx * ny * (count + 1)];
        for column in 0..nx * ny {
            let start = [column % nx, column / nx];
            let own = &mut corners[column * (count + 1)..][..count + 1];
            for k in (0..count).rev() {
                let e = column + nx * ny * k;
                let nodes = mesh.elements[e].map(|a| mesh.nodes[a as usize]);
                for (a, x) in nodes.iter().enumerate() {
                    let up = [
                        usize::from(a % 4 == 1 || a % 4 == 2),
                        usize::from(a % 4 > 1),
                    ];
                    for d in 0..2 {
                        let line = lines[d][start[d] + up[d]];
                        let width = lines[d][start[d] + 1] - lines[d][start[d]];
                        if (x[d] - line).abs() > CLOSE * width {
                            return None;
                        }
                    }
                }
                let weight = weights[usize::from(mesh.regions[e])];
                for c in 0..4 {
                    let (low, high) = (nodes[c][2], nodes[c + 4][2]);
                    let above = if k + 1 == count { 0.0 } else { own[k + 1][c].1 };
                    own[k + 1][c] = (high, above);
                    own[k][c] = (low, above + weight * (high - low));
                }
            }
        }
        Some(Self {
            lines,
            count,
            corners,
        })
    }

    /// σ_v at a point, negative below rock [Pa].
    pub(super) fn at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let place = |d: usize, value: f64| {
            let lines = &self.lines[d];
            let above = lines
                .partition_point(|line| *line <= value)
                .clamp(1, lines.len() - 1);
            let (from, to) = (lines[above - 1], lines[above]);
            (above - 1, (value - from) / (to - from))
        };
        let ((i, u), (j, v)) = (place(0, x), place(1, y));
        let column = i + (self.lines[0].len() - 1) * j;
        let own = &self.corners[column * (self.count + 1)..][..self.count + 1];
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), u * v, (1.0 - u) * v];
        let level = |k: usize| {
            let all = own[k].iter().zip(weights);
            all.fold((0.0, 0.0), |(h, s), ((z, stress), w)| {
                (h + w * z, s + w * stress)
            })
        };
        // levels go up with k
        let (mut below, mut above) = (0, self.count);
        while above - below > 1 {
            let middle = (below + above) / 2;
            match level(middle).0 <= z {
                true => below = middle,
                false => above = middle,
            }
        }
        let ((z0, s0), (z1, s1)) = (level(below), level(above));
        s0 + (s1 - s0) * (z - z0) / (z1 - z0)
    }
}
