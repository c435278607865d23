//! Which neighbours of a node are far: those along the long sides of flat cells.

use super::aggregation::Aggregates;
use super::matrix::NodeMatrix;
use fracas_operators::Real;
use fracas_operators::sparse::Pattern;
use rayon::prelude::*;

/// Distance of a neighbour, over that of the nearest one, beyond which it is far: cubes have √3, cells of 1:2 have 3. Cells of
/// 1:2, 1:3.5, 1:8 on 18³ take 22, 20, 24 iterations; with a limit of 4 they take 23, 28, 27, without any 23, 35, 70 (all by
/// Gauss–Seidel). Unit: 1.
const FAR: f64 = 3.0;

/// Places of the nodes and how far each of them reaches; without places nothing is far.
///
/// Blocks do not tell. In a cell of 1:a the part of the stiffness across the thin side outweighs all others by a² and couples the
/// long sides like a mass matrix: ‖A_ij‖ is a quarter of the diagonal along them for any a, though what holds the nodes
/// together there is 1/a² of it.
pub(super) struct Reach<'a> {
    positions: &'a [[f64; 3]],
    /// Squares of the distances up to which a neighbour is near.
    squares: Vec<f64>,
}

impl<'a> Reach<'a> {
    /// From the nearest neighbour of every node of `group` block rows, with `bonds` of those that share one. Copies of a node on
    /// the two sides of a fracture share a place and do not count: they are near in any case.
    ///
    /// # Cost
    /// A pass over the pattern.
    pub(super) fn new<R: Real>(
        a: &NodeMatrix<R>,
        bonds: Option<&Pattern>,
        positions: &'a [[f64; 3]],
        group: usize,
    ) -> Self {
        let reached = |node: usize| {
            let bonded =
                |j: usize| bonds.is_none_or(|b| b.row(node).binary_search(&(j as u32)).is_ok());
            let nodes = a
                .columns_of(node * group)
                .iter()
                .map(|j| *j as usize / group);
            let squares = nodes
                .filter(|j| bonded(*j))
                .map(|j| square(positions, node, j));
            let nearest = squares.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
            FAR * FAR * nearest
        };
        let squares = (0..positions.len()).into_par_iter().map(reached).collect();
        Self { positions, squares }
    }

    /// True when neither of two nodes reaches the other.
    pub(super) fn is_far(&self, i: usize, j: usize) -> bool {
        !self.positions.is_empty()
            && square(self.positions, i, j) > self.squares[i].max(self.squares[j])
    }

    /// True when a block row of `a` couples this node to a far one.
    pub(super) fn has_far<R: Real>(&self, a: &NodeMatrix<R>, node: usize) -> bool {
        let mut columns = a.columns_of(node).iter();
        columns.any(|j| self.is_far(node, *j as usize))
    }

    /// True when an entry couples far nodes of different aggregates.
    pub(super) fn parts<R: Real>(
        &self,
        a: &NodeMatrix<R>,
        aggregates: &Aggregates,
        group: usize,
    ) -> bool {
        let of = &aggregates.of;
        (0..self.positions.len()).into_par_iter().any(|node| {
            let columns = a.columns_of(node * group).iter();
            let mut nodes = columns.map(|j| *j as usize / group);
            nodes.any(|j| of[node] != of[j] && self.is_far(node, j))
        })
    }
}

/// Square of the distance between two nodes.
fn square(positions: &[[f64; 3]], i: usize, j: usize) -> f64 {
    let [a, b] = [positions[i], positions[j]];
    (0..3).map(|d| (a[d] - b[d]).powi(2)).sum()
}
