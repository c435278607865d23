//! The tentative prolongation: an orthonormal basis of the near-null space on every aggregate.

use super::aggregation::Aggregates;
use super::node_map::NONE;
use rayon::prelude::*;

/// Norm of what is left of a mode after the earlier ones are taken out, relative to the mode, below which it is
/// dependent on the aggregate (a single node has no rotations): √ε, between rounding and the rotation of an aggregate beside the
/// extent of the body. 1e-12 and 1e-4 change none of 400 random systems (`tests/systems/accuracy.rs`). Unit: 1.
const DEPENDENT: f64 = 1.5e-8;

/// Aggregates that one task takes at least.
const AGGREGATES_PER_TASK: usize = 64;

/// `P_0` with `P_0 B_c = B` on every aggregate and `P_0ᵀP_0 = I` on the columns that exist.
#[derive(Clone, Debug)]
pub(super) struct Tentative<const K: usize> {
    /// The block of every block row in the column of its aggregate.
    pub(super) rows: Vec<[[f64; K]; 3]>,
    /// `B_c`, K rows per aggregate; a row is zero where the column of `P_0` is.
    pub(super) coarse: Vec<[[f64; K]; K]>,
}

impl<const K: usize> Tentative<K> {
    /// Orthonormalises the modes (three rows per block row, `group` block rows per node) on every aggregate by modified
    /// Gram–Schmidt, twice.
    pub(super) fn new(aggregates: &Aggregates, group: usize, modes: &[[[f64; K]; 3]]) -> Self {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); aggregates.count];
        // which of its aggregate's nodes a node is
        let mut places = vec![0; aggregates.of.len()];
        for (node, aggregate) in aggregates.of.iter().enumerate() {
            if *aggregate != NONE {
                let members = &mut members[*aggregate as usize];
                places[node] = members.len();
                members.push(node as u32);
            }
        }
        let block_rows = |nodes: &[u32]| -> Vec<usize> {
            let of_node = |n: &u32| *n as usize * group..(*n as usize + 1) * group;
            nodes.iter().flat_map(of_node).collect()
        };
        let bases = members.par_iter().map(|nodes| {
            let mut local: Vec<[f64; K]> = Vec::new();
            local.extend(block_rows(nodes).into_iter().flat_map(|i| modes[i]));
            let r = orthonormalise(&mut local);
            (local, r)
        });
        let bases: Vec<_> = bases.with_min_len(AGGREGATES_PER_TASK).collect();
        let row = |i: usize| match aggregates.of[i / group] {
            NONE => [[0.0; K]; 3],
            aggregate => {
                let first = 3 * (places[i / group] * group + i % group);
                let local = &bases[aggregate as usize].0;
                std::array::from_fn(|k| local[first + k])
            }
        };
        let rows = (0..modes.len()).into_par_iter().map(row).collect();
        let coarse = bases.iter().map(|(_, r)| *r).collect();
        Self { rows, coarse }
    }
}

/// `B = Q R`: overwrites the rows of B by those of Q and returns R. Dependent columns of Q become zero.
pub(super) fn orthonormalise<const K: usize>(b: &mut [[f64; K]]) -> [[f64; K]; K] {
    let dot = |b: &[[f64; K]], i: usize, j: usize| b.iter().map(|row| row[i] * row[j]).sum::<f64>();
    let mut r = [[0.0; K]; K];
    for j in 0..K {
        let before = dot(b, j, j).sqrt();
        for _ in 0..2 {
            for i in 0..j {
                let part = dot(b, i, j);
                r[i][j] += part;
                b.iter_mut().for_each(|row| row[j] -= part * row[i]);
            }
        }
        let norm = dot(b, j, j).sqrt();
        let inverse = if norm > DEPENDENT * before {
            r[j][j] = norm;
            1.0 / norm
        } else {
            0.0
        };
        b.iter_mut().for_each(|row| row[j] *= inverse);
    }
    r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_orthonormal_or_zero_and_reproduce_the_modes() {
        // nine rows, the third mode a combination of the first two
        let modes: Vec<[f64; 3]> = (0..9)
            .map(|i| {
                let (a, b) = ((i as f64).sin(), (i as f64 * 1.7).cos());
                [a, b, 2.0 * a - b]
            })
            .collect();
        let mut q = modes.clone();
        let r = orthonormalise(&mut q);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = q.iter().map(|row| row[i] * row[j]).sum();
                let expected = f64::from(u8::from(i == j && i < 2));
                assert!((product - expected).abs() < 1e-14);
            }
        }
        for (row, q) in modes.iter().zip(&q) {
            for j in 0..3 {
                let value: f64 = (0..3).map(|k| q[k] * r[k][j]).sum();
                assert!((value - row[j]).abs() < 1e-14);
            }
        }
    }
}
