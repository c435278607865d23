//! Kernels of large clusters of bodies by dense fronts in the order of nested dissection.

use super::bodies::MODES;
use super::loose::{Block, cholesky};
use fracas_operators::sparse::Triplets;
use fracas_solvers::direct::nested_dissection::nested_dissection;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rows of a front that a task updates at least.
const ROWS: usize = 24;

/// What eliminated bodies leave to those that they touch: a symmetric matrix, a row of blocks per body.
struct Front {
    /// Places in the order, ascending.
    bodies: Vec<usize>,
    /// Bodies at its head that are eliminated.
    gone: usize,
    /// By rows, the blocks on and above the diagonal.
    values: Vec<f64>,
}

/// Dimension of the kernel of a Gram matrix of its diagonal blocks and the blocks `beside` them per body, pivots up to `zero` left out.
///
/// Where a body comes behind a single one that touched the same bodies, it is eliminated where that one left it.
///
/// # Cost
/// That of a dense factorization of the largest separator, for n bodies side by side in space `O(n²)` products of blocks; half of what is
/// stored is used.
///
/// # Source
/// I. S. Duff, J. K. Reid, ACM Trans. Math. Software 9 (1983) 302–325.
pub(super) fn free_motions(
    diagonal: &[Block],
    beside: &[BTreeMap<usize, Block>],
    zero: f64,
) -> usize {
    let order = order_of(beside);
    let mut place = vec![0; order.len()];
    (order.iter().enumerate()).for_each(|(at, body)| place[*body] = at);
    let mut waiting: Vec<Vec<Front>> = order.iter().map(|_| Vec::new()).collect();
    let mut free = 0;
    for (at, body) in order.iter().enumerate() {
        let later = beside[*body].iter();
        let later = later.map(|(other, block)| (place[*other], block));
        let later: Vec<(usize, &Block)> = later.filter(|(other, _)| *other > at).collect();
        let children = std::mem::take(&mut waiting[at]);
        let mut front = Front::of(at, later.iter().map(|(other, _)| *other), children);
        front.add(at, at, &diagonal[*body]);
        (later.iter()).for_each(|(other, block)| front.add(at, *other, block));
        free += MODES - front.eliminate(zero);
        if let Some(next) = front.left().first() {
            waiting[*next].push(front);
        }
    }
    free
}

/// Nested dissection; where that fails, the order at hand.
fn order_of(beside: &[BTreeMap<usize, Block>]) -> Vec<usize> {
    let n = beside.len();
    let mut pattern = Triplets::new((n, n));
    for (body, others) in beside.iter().enumerate() {
        pattern.add_triplet(body, body, 1.0);
        others
            .keys()
            .for_each(|other| pattern.add_triplet(body, *other, 1.0));
    }
    nested_dissection(&pattern.to_csr()).unwrap_or_else(|_| (0..n).collect())
}

impl Front {
    /// That of the body at a place, of what touches it later and of what those eliminated before it left.
    fn of(at: usize, later: impl Iterator<Item = usize>, mut children: Vec<Self>) -> Self {
        let left = children.iter().flat_map(|child| child.left()).copied();
        let mut bodies: Vec<usize> = later.chain(left).chain([at]).collect();
        bodies.sort_unstable();
        bodies.dedup();
        if children.len() == 1
            && children[0].left() == bodies
            && let Some(child) = children.pop()
        {
            return child;
        }
        let width = MODES * bodies.len();
        let mut front = Self {
            bodies,
            gone: 0,
            values: vec![0.0; width * width],
        };
        children.iter().for_each(|child| front.add_left(child));
        front
    }

    /// Bodies that are not eliminated.
    fn left(&self) -> &[usize] {
        &self.bodies[self.gone..]
    }

    fn width(&self) -> usize {
        MODES * self.bodies.len()
    }

    /// Where the block of a body begins.
    fn column(&self, body: usize) -> usize {
        MODES * self.bodies.partition_point(|other| *other < body)
    }

    fn add(&mut self, row: usize, column: usize, block: &Block) {
        let (row, column, width) = (self.column(row), self.column(column), self.width());
        for (k, block) in block.chunks_exact(MODES).enumerate() {
            let values = &mut self.values[(row + k) * width + column..][..MODES];
            values.iter_mut().zip(block).for_each(|(v, b)| *v += b);
        }
    }

    /// Adds what another one left.
    fn add_left(&mut self, child: &Self) {
        let (width, from) = (self.width(), child.width());
        let columns: Vec<usize> = child.left().iter().map(|b| self.column(*b)).collect();
        for (i, row) in columns.iter().enumerate() {
            for k in 0..MODES {
                let source = &child.values[(MODES * (child.gone + i) + k) * from..][..from];
                let source = source[MODES * (child.gone + i)..].chunks_exact(MODES);
                let target = &mut self.values[(row + k) * width..][..width];
                for (column, source) in columns[i..].iter().zip(source) {
                    let target = target[*column..][..MODES].iter_mut();
                    target.zip(source).for_each(|(t, s)| *t += s);
                }
            }
        }
    }

    /// `G_cd ← G_cd − G_cb G_bb⁺ G_bd` for the first body b that is left; the rank of G_bb.
    fn eliminate(&mut self, zero: f64) -> usize {
        let (width, head) = (self.width(), MODES * self.gone);
        let block: Block =
            std::array::from_fn(|i| self.values[(head + i / MODES) * width + head + i % MODES]);
        let (factor, pivots) = cholesky(&block, 0, zero);
        let (head, tail) = self.values.split_at_mut((head + MODES) * width);
        let rows = &head[head.len() - MODES * width..];
        let begin = MODES * (self.gone + 1);
        // L⁻¹ P G_bd, rows of zeros for the motions that are left out
        let mut solved: [Vec<f64>; MODES] = std::array::from_fn(|_| vec![0.0; width - begin]);
        for (k, p) in pivots.iter().enumerate() {
            let (known, [row, ..]) = solved.split_at_mut(k) else {
                unreachable!("as many rows as pivots");
            };
            row.copy_from_slice(&rows[p * width + begin..][..width - begin]);
            for (l, known) in known.iter().enumerate() {
                let share = factor[MODES * l + p];
                row.iter_mut().zip(known).for_each(|(r, x)| *r -= share * x);
            }
            let pivot = factor[MODES * k + p];
            row.iter_mut().for_each(|r| *r /= pivot);
        }
        let [a, b, c, d, e, f] = &solved;
        let tail = tail.par_chunks_exact_mut(width).with_min_len(ROWS);
        tail.enumerate().for_each(|(i, row)| {
            let from = i - i % MODES;
            let row = &mut row[begin + from..];
            let n = row.len();
            let w = [a, b, c, d, e, f].map(|w| (w[i], &w[from..][..n]));
            for (j, value) in row.iter_mut().enumerate() {
                *value -= w.iter().map(|(own, w)| own * w[j]).sum::<f64>();
            }
        });
        self.gone += 1;
        pivots.len()
    }
}
