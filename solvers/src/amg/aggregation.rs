//! Nodes gathered into aggregates of strongly connected neighbours.

use super::matrix::NodeMatrix;
use super::node_map::NONE;
use super::reach::Reach;
use fracas_operators::Real;
use fracas_operators::small::Matrix3;
use fracas_operators::sparse::{Pattern, SparseRows};
use rayon::prelude::*;

/// Part by which a connection has to be stronger than another one: less is rounding of f32 on coarse levels, by which alone connections of
/// like cells differ. Unit: 1.
const STRONGER: f32 = 1e-4;

/// Which aggregate every node belongs to; a node without any connection stays [`NONE`]: the smoother solves it exactly.
#[derive(Clone, Debug)]
pub(super) struct Aggregates {
    /// Aggregate of every node.
    pub(super) of: Vec<u32>,
    /// Aggregates.
    pub(super) count: usize,
}

impl Aggregates {
    /// First node of every aggregate; 0 for one without nodes.
    pub(super) fn first_nodes(&self) -> Vec<usize> {
        let mut first = vec![0; self.count];
        for (node, aggregate) in self.of.iter().enumerate().rev() {
            if *aggregate != NONE {
                first[*aggregate as usize] = node;
            }
        }
        first
    }

    /// Middles of the aggregates.
    pub(super) fn centres(&self, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
        if positions.is_empty() {
            return Vec::new();
        }
        let mut sums = vec![([0.0; 3], 0.0); self.count];
        for (aggregate, x) in self.of.iter().zip(positions) {
            if let Some((sum, count)) = sums.get_mut(*aggregate as usize) {
                sum.iter_mut().zip(x).for_each(|(s, x)| *s += x);
                *count += 1.0;
            }
        }
        let middle = |(sum, count): &([f64; 3], f64)| sum.map(|s| s / count.max(1.0));
        sums.iter().map(middle).collect()
    }

    /// Aggregates that a bond between their nodes joins.
    pub(super) fn bonds(&self, of_nodes: &Pattern) -> Pattern {
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); self.count];
        for (node, aggregate) in self.of.iter().enumerate() {
            if *aggregate != NONE {
                members[*aggregate as usize].push(node as u32);
            }
        }
        let scratch = || vec![NONE; self.count];
        Pattern::collect(self.count, scratch, |aggregate, seen, columns| {
            let start = columns.len();
            for node in &members[aggregate] {
                for j in of_nodes.row(*node as usize) {
                    let other = self.of[*j as usize];
                    if other != NONE && seen[other as usize] != aggregate as u32 {
                        seen[other as usize] = aggregate as u32;
                        columns.push(other);
                    }
                }
            }
            columns[start..].sort_unstable();
        })
    }
}

/// Graph of the strong connections `‖A_ij‖_F > θ √(‖A_ii‖_F ‖A_jj‖_F)` between nodes of `group` block rows each that are not far
/// from each other.
pub(super) struct Strong(SparseRows<f32>);

impl Strong {
    pub(super) fn new<R: Real>(
        a: &NodeMatrix<R>,
        bonds: Option<&Pattern>,
        reach: &Reach<'_>,
        group: usize,
        theta: f64,
    ) -> Self {
        let nodes = a.rows() / group;
        let scales = scales(a, group);
        let square = |i: usize, j: usize, block: &Matrix3<R>| {
            let [rows, columns] = [scales[i], scales[j]];
            let entry =
                |k: usize| block[k / 3][k % 3].to_f64_exact() * rows[k / 3] * columns[k % 3];
            (0..9).map(|k| entry(k).powi(2)).sum::<f64>()
        };
        let diagonal: Vec<f64> = (0..nodes)
            .into_par_iter()
            .map(|node| {
                let rows = node * group..(node + 1) * group;
                let own = |i: usize| a.row(i).filter(|(j, _)| j / group == node);
                rows.map(|i| own(i).map(|(j, block)| square(i, j, block)).sum::<f64>())
                    .sum()
            })
            .collect();
        let of_node = |node: usize, (sums, list): &mut (Vec<f64>, Vec<u32>), out: &mut Vec<_>| {
            list.clear();
            for i in node * group..(node + 1) * group {
                for (j, block) in a.row(i) {
                    let other = j / group;
                    if sums[other] == 0.0 {
                        list.push(other as u32);
                    }
                    // a stored zero block must not be listed twice
                    sums[other] += square(i, j, block).max(f64::MIN_POSITIVE);
                }
            }
            for other in &*list {
                let j = *other as usize;
                let weight = sums[j] / (diagonal[node] * diagonal[j]).sqrt();
                let bonded = bonds.is_none_or(|b| b.row(node).binary_search(other).is_ok());
                if j != node && bonded && weight > theta * theta && !reach.is_far(node, j) {
                    out.push((*other, weight as f32));
                }
                sums[j] = 0.0;
            }
        };
        Self(SparseRows::collect(
            nodes,
            || (vec![0.0; nodes], Vec::new()),
            of_node,
        ))
    }

    fn of(&self, node: usize) -> impl Iterator<Item = (usize, f32)> {
        self.0.row(node).map(|(j, weight)| (j, *weight))
    }
}

/// Factors of the rows: 1 on the finest level; on the others, where translations and rotations have different units, those of a unit
/// diagonal. In flat cells a rotation is up to (ratio of sides)² stiffer than a translation, and couples to its like less and less
/// from level to level: without factors it hides all others, and coarsening stops.
fn scales<R: Real>(a: &NodeMatrix<R>, group: usize) -> Vec<[f64; 3]> {
    let of_row = |i: usize| {
        let own = a.diagonal(i);
        [0, 1, 2].map(|k: usize| {
            let scale = own[k][k].to_f64_exact().sqrt().recip();
            match group {
                1 => 1.0,
                _ if scale.is_finite() => scale,
                _ => 0.0,
            }
        })
    };
    (0..a.rows()).into_par_iter().map(of_row).collect()
}

/// Greedy aggregation in three passes: whole neighbourhoods, leftovers to the strongest neighbour, the rest among
/// themselves. With `bonds`, only nodes that share a bond count as connected: aggregates then do not reach across a
/// fracture, whose two sides may turn against each other at no cost (columns between crossing fractures, like gears).
///
/// # Source
/// Vaněk, Mandel, Brezina, Computing 56 (1996).
pub(super) fn aggregate<R: Real>(a: &NodeMatrix<R>, strong: &Strong, group: usize) -> Aggregates {
    let nodes = a.rows() / group;
    let mut of = vec![NONE; nodes];
    let mut count = 0_u32;
    for node in 0..nodes {
        let free = of[node] == NONE && strong.of(node).all(|(j, _)| of[j] == NONE);
        if free && strong.of(node).next().is_some() {
            of[node] = count;
            strong.of(node).for_each(|(j, _)| of[j] = count);
            count += 1;
        }
    }
    let roots = of.clone();
    for node in 0..nodes {
        if of[node] != NONE {
            continue;
        }
        let joined = strong.of(node).filter(|(j, _)| roots[*j] != NONE);
        // the strongest; among equals the first
        let stronger = |next: f32, best: f32| next > best + STRONGER * best;
        let best = joined.reduce(|best, next| match stronger(next.1, best.1) {
            true => next,
            false => best,
        });
        if let Some((j, _)) = best {
            of[node] = roots[j];
        }
    }
    for node in 0..nodes {
        if of[node] == NONE && has_neighbours(a, group, node) {
            of[node] = count;
            for (j, _) in strong.of(node) {
                if of[j] == NONE {
                    of[j] = count;
                }
            }
            count += 1;
        }
    }
    Aggregates {
        of,
        count: count as usize,
    }
}

/// True when a node is coupled to any other.
fn has_neighbours<R: Real>(a: &NodeMatrix<R>, group: usize, node: usize) -> bool {
    let zero = [[R::zero(); 3]; 3];
    (node * group..(node + 1) * group).any(|i| {
        a.row(i)
            .any(|(j, block)| j / group != node && *block != zero)
    })
}
