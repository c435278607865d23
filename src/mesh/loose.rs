//! Rigid motions that are left to bodies which only hold each other up.

use super::bodies::MODES;
use super::fronts;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::ops::Range;

/// Neighbours of a body up to which it is eliminated before the others are dissected: chains are eliminated from their ends, where they
/// leave nothing behind that is small.
const FEW: usize = 2;

/// Bodies from which on they are dissected: 4,096 single cells side by side take a tenth of the time.
const MANY: usize = 300;

/// 6×6 numbers, row by row.
pub(super) type Block = [f64; MODES * MODES];

/// The Gram matrix of the constraints on a cluster of bodies, six rigid motions each: only bodies that touch have a block.
#[derive(Debug)]
pub(super) struct Cluster {
    diagonal: Vec<Block>,
    /// Blocks beside the diagonal per body, those of both triangles.
    beside: Vec<BTreeMap<usize, Block>>,
}

impl Cluster {
    /// Bodies with the constraints that each has for itself.
    pub(super) fn new(diagonal: Vec<Block>) -> Self {
        Self {
            beside: vec![BTreeMap::new(); diagonal.len()],
            diagonal,
        }
    }

    /// A constraint `w·c_b − v·c_a = 0` on the motions of two bodies.
    pub(super) fn join(&mut self, [a, b]: [usize; 2], v: &[f64; MODES], w: &[f64; MODES]) {
        add_product(&mut self.diagonal[a], 1.0, v, v);
        add_product(&mut self.diagonal[b], 1.0, w, w);
        for (row, column, x, y) in [(a, b, v, w), (b, a, w, v)] {
            let block = self.beside[row].entry(column);
            add_product(block.or_insert([0.0; 36]), -1.0, x, y);
        }
    }

    /// Dimension of the kernel; pivots below `tolerance` times the largest entry count as zero.
    ///
    /// Bodies are eliminated in the order of their neighbours left, `G_cd ← G_cd − G_cb G_bb⁺ G_bd`: as G is positive semi-definite, a
    /// kernel of G_bb is one of the whole of what is left. Of many bodies those with three neighbours and more are
    /// [dissected](fronts::free_motions).
    ///
    /// # Cost
    /// That of a sparse Cholesky factorization: linear for a chain.
    pub(super) fn free_motions(self, tolerance: f64) -> usize {
        self.dissected_from(MANY, tolerance)
    }

    fn dissected_from(mut self, many: usize, tolerance: f64) -> usize {
        let largest = (self.diagonal.iter())
            .flat_map(|block| block.iter().step_by(MODES + 1))
            .fold(0.0f64, |m, v| m.max(*v));
        let degree = |beside: &[BTreeMap<usize, Block>], b: usize| Reverse((beside[b].len(), b));
        let mut queue: BinaryHeap<_> = (0..self.diagonal.len())
            .map(|b| degree(&self.beside, b))
            .collect();
        let mut is_done = vec![false; self.diagonal.len()];
        let (mut free, mut left) = (0, is_done.len());
        while let Some(Reverse((neighbours, b))) = queue.pop() {
            if is_done[b] || neighbours != self.beside[b].len() {
                continue;
            }
            if neighbours > FEW && left >= many {
                let left = self.without(&is_done);
                return free
                    + fronts::free_motions(&left.diagonal, &left.beside, tolerance * largest);
            }
            is_done[b] = true;
            left -= 1;
            let row = std::mem::take(&mut self.beside[b]);
            let (factor, pivots) = cholesky(&self.diagonal[b], 0, tolerance * largest);
            free += MODES - pivots.len();
            let solved: Vec<(usize, Block)> = row
                .iter()
                .map(|(c, block)| (*c, forward(&factor, &pivots, block)))
                .collect();
            for (c, x) in &solved {
                self.beside[*c].remove(&b);
                for (d, y) in &solved {
                    let target = match c == d {
                        true => &mut self.diagonal[*c],
                        false => self.beside[*c].entry(*d).or_insert([0.0; 36]),
                    };
                    for k in 0..pivots.len() {
                        let (x, y) = (&x[MODES * k..][..MODES], &y[MODES * k..][..MODES]);
                        add_product(target, -1.0, x, y);
                    }
                }
            }
            queue.extend(solved.iter().map(|(c, _)| degree(&self.beside, *c)));
        }
        free
    }

    /// The same without bodies that are eliminated.
    fn without(self, is_done: &[bool]) -> Self {
        let mut number = vec![0; is_done.len()];
        let left = (0..is_done.len()).filter(|b| !is_done[*b]);
        left.enumerate().for_each(|(k, b)| number[b] = k);
        let beside = |row: BTreeMap<usize, Block>| row.into_iter().map(|(c, x)| (number[c], x));
        let rows = self.diagonal.into_iter().zip(self.beside).zip(is_done);
        let (diagonal, beside) = rows
            .filter(|(_, is_done)| !**is_done)
            .map(|((diagonal, row), _)| (diagonal, beside(row).collect()))
            .unzip();
        Self { diagonal, beside }
    }
}

/// G += s v wᵀ.
pub(super) fn add_product(gram: &mut Block, s: f64, v: &[f64], w: &[f64]) {
    for (row, x) in gram.chunks_exact_mut(MODES).zip(v) {
        row.iter_mut().zip(w).for_each(|(g, y)| *g += s * x * y);
    }
}

/// L with `P G Pᵀ ≈ L Lᵀ` by diagonal pivoting, column k in row k, and the motions in the order of their pivots, the `first` ones before
/// the others; those with pivots up to `zero` are left out.
pub(super) fn cholesky(gram: &Block, first: usize, zero: f64) -> (Block, Vec<usize>) {
    let (mut rest, mut factor, mut pivots) = (*gram, [0.0; 36], Vec::with_capacity(MODES));
    loop {
        let largest = |range: Range<usize>| {
            let left = range.filter(|i| !pivots.contains(i) && rest[7 * i] > zero);
            left.max_by(|i, j| rest[7 * i].total_cmp(&rest[7 * j]))
        };
        let Some(p) = largest(0..first).or_else(|| largest(first..MODES)) else {
            return (factor, pivots);
        };
        let column = &mut factor[MODES * pivots.len()..][..MODES];
        let root = rest[7 * p].sqrt();
        for i in 0..MODES {
            column[i] = match pivots.contains(&i) {
                true => 0.0,
                false => rest[MODES * i + p] / root,
            };
        }
        add_product(&mut rest, -1.0, column, column);
        pivots.push(p);
    }
}

/// `L⁻¹ P X`, a row per pivot.
fn forward(factor: &Block, pivots: &[usize], block: &Block) -> Block {
    let mut solved = [0.0; 36];
    for (k, p) in pivots.iter().enumerate() {
        for j in 0..MODES {
            let known: f64 = (0..k)
                .map(|l| factor[MODES * l + p] * solved[MODES * l + j])
                .sum();
            solved[MODES * k + j] = (block[MODES * p + j] - known) / factor[MODES * k + p];
        }
    }
    solved
}

#[cfg(test)]
mod tests {
    use super::super::rank::gram_rank;
    use super::*;
    use fracas_operators::random::signed;

    #[test]
    fn kernels_are_those_of_the_dense_gram_matrix() {
        let mut drawn = 0;
        for case in 0..60 {
            let bodies = 2 + case % 9;
            let n = MODES * bodies;
            let mut dense = vec![0.0; n * n];
            let mut cluster = Cluster::new(vec![[0.0; 36]; bodies]);
            let mut modes = || -> [f64; MODES] {
                std::array::from_fn(|_| {
                    drawn += 1;
                    signed(drawn)
                })
            };
            // a chain with a few more joints, each of one to seven constraints: some motions stay free
            for joint in 0..bodies - 1 + case % 4 {
                let a = joint % bodies;
                let b = (a + 1 + joint / bodies) % bodies;
                if a == b {
                    continue;
                }
                for _ in 0..1 + (joint + case) % 7 {
                    let (v, w) = (modes(), modes());
                    cluster.join([a, b], &v, &w);
                    let row = |i: usize| match (i / MODES == a, i / MODES == b) {
                        (true, _) => -v[i % MODES],
                        (_, true) => w[i % MODES],
                        _ => 0.0,
                    };
                    for i in 0..n {
                        for j in 0..n {
                            dense[i * n + j] += row(i) * row(j);
                        }
                    }
                }
            }
            let expected = n - gram_rank(&mut dense, n, 1e-10);
            let dissected = Cluster {
                diagonal: cluster.diagonal.clone(),
                beside: cluster.beside.clone(),
            };
            assert_eq!(cluster.free_motions(1e-10), expected, "case {case}");
            let free = fronts::free_motions(&dissected.diagonal, &dissected.beside, {
                let diagonal = dissected.diagonal.iter().flatten();
                1e-10 * diagonal.fold(0.0, |m: f64, v| m.max(*v))
            });
            assert_eq!(free, expected, "case {case}, dissected");
        }
    }

    /// Bodies side by side in space, of which some joints let go: as many motions whatever the order.
    #[test]
    fn bodies_that_are_dissected_have_the_kernel_of_those_that_are_not() {
        let random = &mut fracas_operators::random::Random::new(3);
        let mut all = 0;
        for sides in [[4, 5, 6], [7, 3, 8], [2, 2, 40]] {
            let count = sides.iter().product();
            let mut clusters = [0, 1].map(|_| Cluster::new(vec![[0.0; 36]; count]));
            for b in 0..count {
                let at = [
                    b % sides[0],
                    b / sides[0] % sides[1],
                    b / (sides[0] * sides[1]),
                ];
                for axis in 0..3 {
                    let stride = [1, sides[0], sides[0] * sides[1]][axis];
                    if at[axis] + 1 == sides[axis] || random.chance(0.1) {
                        continue;
                    }
                    for _ in 0..random.whole(1, 7) {
                        let mut mode = || std::array::from_fn(|_| random.between(-1.0, 1.0));
                        let (v, w) = (mode(), mode());
                        (clusters.iter_mut()).for_each(|c| c.join([b, b + stride], &v, &w));
                    }
                }
            }
            let [whole, dissected] = clusters;
            let free = whole.dissected_from(usize::MAX, 1e-10);
            assert_eq!(dissected.dissected_from(0, 1e-10), free, "{sides:?}");
            all += free;
        }
        assert!(all > 0);
    }
}
