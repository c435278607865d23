//! Which nodes count as neighbours.

use super::{NodeBlocks, diagonal};
use fracas_operators::small::norm_squared;
use fracas_operators::sparse::{Pattern, SparseRows};

/// Strongest neighbours that a node keeps. Source: the group's published multigrid.
const KEPT: usize = 40;

/// Part of the strongest connection of either end that a connection needs. Unit: 1.
/// Source: Ruge & Stüben, *Multigrid Methods* (1987), for problems in three dimensions.
const RELATIVE: f32 = 0.25;

/// Symmetric graph of the strong connections `s_ij = ‖A_ij‖_F / √(‖A_ii‖_F ‖A_jj‖_F)`.
///
/// Strengths have the digits of f32, so that those which differ by rounding alone, as on every grid of like cells, are equal.
#[derive(Clone, Debug)]
pub(super) struct Strength(SparseRows<f32>);

impl Strength {
    /// Connections that reach a quarter of the strongest and belong to the 40 strongest of either end; equals are all
    /// in or all out. No absolute limit: a node with any neighbour keeps one, and the modes reach it. With `bonds`, only
    /// nodes that share one count: those on the two sides of a fracture may turn against each other.
    pub(super) fn new(a: &NodeBlocks, bonds: Option<&Pattern>) -> Self {
        Self::above(a, bonds, RELATIVE, KEPT)
    }

    /// Every connection.
    pub(super) fn complete(a: &NodeBlocks) -> Self {
        Self::above(a, None, 0.0, usize::MAX)
    }

    fn above(a: &NodeBlocks, bonds: Option<&Pattern>, relative: f32, kept: usize) -> Self {
        let n = a.pattern.rows();
        let own: Vec<f64> = (0..n)
            .map(|i| norm_squared(diagonal(a, i)).sqrt())
            .collect();
        let strong = |i: usize| {
            let own = &own;
            a.row(i).filter_map(move |(j, block)| {
                let weight = (norm_squared(block).sqrt() / (own[i] * own[j]).sqrt()) as f32;
                let bonded = bonds.is_none_or(|b| b.row(i).binary_search(&(j as u32)).is_ok());
                (j != i && weight > 0.0 && bonded).then_some((j, weight))
            })
        };
        let mut row: Vec<f32> = Vec::new();
        let least: Vec<f32> = (0..n)
            .map(|i| {
                row.clear();
                row.extend(strong(i).map(|entry| entry.1));
                let strongest = row.iter().copied().fold(0.0, f32::max);
                if row.len() <= kept {
                    return relative * strongest;
                }
                row.select_nth_unstable_by(kept - 1, |a, b| b.total_cmp(a))
                    .1
                    .max(relative * strongest)
            })
            .collect();
        let kept = |i: usize, (): &mut (), out: &mut Vec<_>| {
            let both = strong(i).filter(|(j, w)| *w >= least[i].min(least[*j]));
            out.extend(both.map(|(j, weight)| (j as u32, weight)));
        };
        Self(SparseRows::collect(n, || (), kept))
    }

    /// Nodes.
    pub(super) fn len(&self) -> usize {
        self.0.pattern.rows()
    }

    /// Neighbours of a node.
    pub(super) fn neighbours(&self, i: usize) -> &[u32] {
        self.0.pattern.row(i)
    }

    /// Neighbours of a node with the strength of the connection.
    pub(super) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> {
        self.0.row(i).map(|(j, strength)| (j, f64::from(*strength)))
    }
}
