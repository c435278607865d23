//! Interpolation that reproduces the modes.

use super::Interpolation;
use super::independent_set::{FINE, Splitting};
use super::pseudo_inverse::pseudo_inverse;
use super::strength::Strength;
use crate::amg::tentative::orthonormalise;
use fracas_operators::small::{Matrix3, diagonal, norm_squared};

/// Connections between a fine node and the coarse ones it interpolates from: at most 2, up to 4 where these do not do.
/// Source: the group's published multigrid.
const DISTANCES: std::ops::RangeInclusive<u8> = 2..=4;

/// Coarse nodes that a row takes, strongest first. Three that are not on a line reproduce rigid motions; with more of
/// them the smallest row spreads and its energy falls. Measured with every connection above 0.01 and no energy minimisation,
/// clamped boxes of 20³ elements, conjugate gradients to 1e-6 with as few as do (from 4), at least 8, at least 12 nodes:
/// layers of contrast 1000 20, 17, 18; elements 10:10:1 120, 80, 70; with 4, 6, 12 on a cube 11, 10, 9.
const MOST: usize = 8;

/// Part of the modes at a node that may be left over. Unit: 1.
const LEFT_OVER: f64 = 1e-8;

/// Largest Frobenius norm of the three rows of a node. Source: the group's published multigrid.
const LARGEST: f64 = 10.0;

/// The modes at the nodes, three rows each.
pub(super) type Modes<const K: usize> = [[[f64; K]; 3]];

/// P with `P V_c = V` on every fine node that can have it: from the coarse nodes C of node i nearest by strength w,
/// `P_iC = V_i (V_CᵀW V_C)⁺ V_CᵀW`, the smallest such row in the norm of W⁻¹.
///
/// Where the modes are not reproduced, or only by a row of norm above 10, nodes farther away are looked at in the first
/// graph, of strong connections, and then in the second, of all; a row that stays too large is scaled down.
///
/// # Source
/// After the dynamic-pattern least squares of V. A. Paludetto Magri, A. Franceschini, C. Janna, SIAM J. Sci. Comput. 41
/// (2019).
pub(super) fn interpolation<const K: usize>(
    graphs: [&Strength; 2],
    splitting: &Splitting,
    modes: &Modes<K>,
) -> Interpolation {
    let n = graphs[0].len();
    let scratch = || (Search::new(n), Vec::new());
    Interpolation::collect(n, scratch, |i, (search, row), out| {
        match splitting.number[i] {
            FINE => {
                search.row(graphs, splitting, modes, i, row);
                row.sort_unstable_by_key(|entry| entry.0);
                out.extend_from_slice(row);
            }
            number => out.push((number, diagonal([1.0; 3]))),
        }
    })
}

/// Coarse node and block.
type Entry = (u32, Matrix3<f64>);

/// Connections to a node that was not reached.
const FAR: u8 = u8::MAX;

/// Coarse nodes around a fine one, and their modes.
struct Search<const K: usize> {
    /// Connections from the fine node, [`FAR`] between searches.
    distance: Vec<u8>,
    /// Sum over the shortest paths of the products of strengths.
    weight: Vec<f64>,
    reached: Vec<u32>,
    coarse: Vec<(u32, f64)>,
    local: Vec<[f64; K]>,
}

impl<const K: usize> Search<K> {
    fn new(n: usize) -> Self {
        Self {
            distance: vec![FAR; n],
            weight: vec![0.0; n],
            reached: Vec::new(),
            coarse: Vec::new(),
            local: Vec::new(),
        }
    }

    /// Coarse nodes within `limit` connections of i, the strongest first; equals by number.
    fn find(&mut self, graph: &Strength, splitting: &Splitting, i: usize, limit: u8) {
        self.reached.clear();
        self.reached.push(i as u32);
        self.distance[i] = 0;
        self.weight[i] = 1.0;
        let mut next = 0;
        while let Some(from) = self.reached.get(next).map(|j| *j as usize) {
            next += 1;
            let there = self.distance[from] + 1;
            if there > limit {
                break;
            }
            for (j, strength) in graph.row(from) {
                if self.distance[j] == FAR {
                    self.distance[j] = there;
                    self.weight[j] = 0.0;
                    self.reached.push(j as u32);
                }
                if self.distance[j] == there {
                    self.weight[j] += self.weight[from] * strength;
                }
            }
        }
        self.coarse.clear();
        for j in &self.reached {
            let at = *j as usize;
            self.distance[at] = FAR;
            if splitting.number[at] != FINE {
                self.coarse.push((*j, self.weight[at]));
            }
        }
        // sums over paths in another order are equal in f32
        let size = |entry: &(u32, f64)| entry.1 as f32;
        let order =
            |a: &(u32, f64), b: &(u32, f64)| size(b).total_cmp(&size(a)).then(a.0.cmp(&b.0));
        self.coarse.sort_unstable_by(order);
    }

    fn row(
        &mut self,
        graphs: [&Strength; 2],
        splitting: &Splitting,
        modes: &Modes<K>,
        i: usize,
        out: &mut Vec<Entry>,
    ) {
        for (graph, limit) in graphs
            .iter()
            .flat_map(|graph| DISTANCES.map(move |d| (graph, d)))
        {
            self.find(graph, splitting, i, limit);
            self.coarse.truncate(MOST);
            let (left_over, norm) = self.fit(modes, i, out);
            if left_over <= LEFT_OVER && norm <= LARGEST {
                break;
            }
        }
        let squares = out.iter().map(|entry| norm_squared(&entry.1));
        let norm = squares.sum::<f64>().sqrt();
        let shrink = (LARGEST / norm).min(1.0);
        for (j, block) in out.iter_mut() {
            *j = splitting.number[*j as usize];
            (block.as_flattened_mut().iter_mut()).for_each(|v| *v *= shrink);
        }
    }

    /// Writes `P_iC` for the coarse nodes C; returns what is left over of the modes and `‖P_iC‖_F`.
    fn fit(&mut self, modes: &Modes<K>, i: usize, out: &mut Vec<Entry>) -> (f64, f64) {
        let coarse = &self.coarse;
        // modes in a basis of their own around node i: rotations about far axes become rotations
        self.local.clear();
        self.local.extend_from_slice(&modes[i]);
        for (j, _) in coarse {
            self.local.extend_from_slice(&modes[*j as usize]);
        }
        orthonormalise(&mut self.local);
        let (v_i, v_c) = self.local.split_at(3);
        let weighted = || coarse.iter().zip(v_c.chunks_exact(3));
        // N = V_CᵀW V_C
        let mut gram = [[0.0; K]; K];
        for ((_, w), rows) in weighted() {
            for row in rows {
                for a in 0..K {
                    (0..K).for_each(|b| gram[a][b] += w * row[a] * row[b]);
                }
            }
        }
        let inverse = pseudo_inverse(gram);
        // Y = V_i N⁺,  P_ij = w_j Y V_jᵀ,  what is left over: V_i − P_iC V_C = V_i − Y N
        let times = |row: &[f64; K], n: &[[f64; K]; K]| -> [f64; K] {
            std::array::from_fn(|b| (0..K).map(|a| row[a] * n[a][b]).sum())
        };
        let y: [[f64; K]; 3] = std::array::from_fn(|r| times(&v_i[r], &inverse));
        let dot = |a: &[f64; K], b: &[f64; K]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        out.clear();
        let mut norm = 0.0;
        for ((j, w), rows) in weighted() {
            let block: Matrix3<f64> = y.map(|y| std::array::from_fn(|k| w * dot(&y, &rows[k])));
            norm += norm_squared(&block);
            out.push((*j, block));
        }
        let (mut missing, mut all) = (0.0, 0.0);
        for r in 0..3 {
            let found = times(&y[r], &gram);
            missing += (0..K).map(|a| (v_i[r][a] - found[a]).powi(2)).sum::<f64>();
            all += dot(&v_i[r], &v_i[r]);
        }
        let left_over = if all > 0.0 {
            (missing / all).sqrt()
        } else {
            0.0
        };
        (left_over, norm.sqrt())
    }
}
