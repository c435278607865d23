//! Nodes gathered into aggregates of strongly connected neighbours.

use super::node_map::NONE;
use super::rows::{Pattern, chunks};
use super::sweeps::SweepMatrix;
use fracas_operators::Real;
use rayon::prelude::*;
use std::ops::Range;

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

/// Graph of the strong connections `‖A_ij‖_F > θ √(‖A_ii‖_F ‖A_jj‖_F)` between nodes of `group` block rows each.
struct Strong {
    offsets: Vec<usize>,
    neighbours: Vec<u32>,
    weights: Vec<f32>,
}

impl Strong {
    fn new<R: Real>(a: &SweepMatrix<R>, bonds: Option<&Pattern>, group: usize, theta: f64) -> Self {
        let nodes = a.rows() / group;
        let square = |block: &[R; 9]| {
            block.iter().fold(0.0, |sum, v| {
                let v = v.to_f64_exact();
                sum + v * v
            })
        };
        let diagonal: Vec<f64> = (0..nodes)
            .into_par_iter()
            .map(|node| {
                let rows = node * group..(node + 1) * group;
                let own = |i: usize| a.row(i).filter(|(j, _)| j / group == node);
                rows.map(|i| own(i).map(|(_, block)| square(block)).sum::<f64>())
                    .sum()
            })
            .collect();
        let of_rows = |(sums, list): &mut (Vec<f64>, Vec<u32>), rows: Range<usize>| {
            let (mut ends, mut neighbours, mut weights) = (Vec::new(), Vec::new(), Vec::new());
            for node in rows {
                list.clear();
                for i in node * group..(node + 1) * group {
                    for (j, block) in a.row(i) {
                        let other = j / group;
                        if sums[other] == 0.0 {
                            list.push(other as u32);
                        }
                        // a stored zero block must not be listed twice
                        sums[other] += square(block).max(f64::MIN_POSITIVE);
                    }
                }
                for other in &*list {
                    let j = *other as usize;
                    let weight = sums[j] / (diagonal[node] * diagonal[j]).sqrt();
                    let bonded = bonds.is_none_or(|b| b.row(node).binary_search(other).is_ok());
                    if j != node && bonded && weight > theta * theta {
                        neighbours.push(*other);
                        weights.push(weight as f32);
                    }
                    sums[j] = 0.0;
                }
                ends.push(neighbours.len());
            }
            (ends, neighbours, weights)
        };
        let parts: Vec<_> = chunks(nodes)
            .map_init(|| (vec![0.0_f64; nodes], Vec::new()), of_rows)
            .collect();
        let (mut offsets, mut neighbours, mut weights) = (vec![0], Vec::new(), Vec::new());
        for (ends, own_neighbours, own_weights) in parts {
            let start = neighbours.len();
            offsets.extend(ends.iter().map(|end| start + end));
            neighbours.extend(own_neighbours);
            weights.extend(own_weights);
        }
        Self {
            offsets,
            neighbours,
            weights,
        }
    }

    fn of(&self, node: usize) -> impl Iterator<Item = (usize, f32)> {
        let range = self.offsets[node]..self.offsets[node + 1];
        self.neighbours[range.clone()]
            .iter()
            .map(|j| *j as usize)
            .zip(self.weights[range].iter().copied())
    }
}

/// Greedy aggregation in three passes: whole neighbourhoods, leftovers to the strongest neighbour, the rest among
/// themselves. With `bonds`, only nodes that share a bond count as connected: aggregates then do not reach across a
/// fracture, whose two sides may turn against each other at no cost (columns between crossing fractures, like gears).
///
/// # Source
/// Vaněk, Mandel, Brezina, Computing 56 (1996).
pub(super) fn aggregate<R: Real>(
    a: &SweepMatrix<R>,
    bonds: Option<&Pattern>,
    group: usize,
    theta: f64,
) -> Aggregates {
    let strong = Strong::new(a, bonds, group, theta);
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
        let best = joined.reduce(|best, next| if next.1 > best.1 { next } else { best });
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
fn has_neighbours<R: Real>(a: &SweepMatrix<R>, group: usize, node: usize) -> bool {
    let zero = [R::zero(); 9];
    (node * group..(node + 1) * group).any(|i| {
        a.row(i)
            .any(|(j, block)| j / group != node && *block != zero)
    })
}
