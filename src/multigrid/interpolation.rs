//! Trilinear interpolation from the corners of a coarse element to the fine nodes in it.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::coarsening::{Coarsening, for_each_fine};
use super::grid::{Grid, STEPS};
use fracas_operators::Real;
use fracas_operators::shared::Colours;
use fracas_solvers::multigrid::Transfer;
use std::ops::Range;

/// Mark of a node that no element has claimed yet.
const NONE: u32 = u32::MAX;

/// For every fine node the coarse element that it is interpolated in, and where it lies there.
#[derive(Debug)]
pub(super) struct Owners {
    /// A coarse element.
    pub(super) element: Vec<u32>,
    /// Fine lines from the lowest corner of its cell: `x + 3 y + 9 z`.
    pub(super) step: Vec<u8>,
    /// Cell of every coarse element.
    pub(super) cell: Vec<u32>,
    /// Share of the way through a coarse cell at its fine lines, per axis.
    pub(super) share: [Vec<[f64; 3]>; 3],
}

impl Owners {
    /// Owners of all fine nodes: the parent of the lowest fine element around each.
    pub(super) fn new(fine: &Grid<'_>, coarsening: &Coarsening) -> Self {
        let Coarsening {
            coarse,
            parent,
            starts,
        } = coarsening;
        let mut element = vec![NONE; fine.nodes];
        let mut step = vec![0; fine.nodes];
        let mut cell = vec![0; coarse.elements.len()];
        for c in 0..coarse.cells.iter().product() {
            let place = coarse.place(c);
            coarse.elements_in(c).for_each(|e| cell[e] = c as u32);
            for_each_fine(place, starts, |at| {
                for e in fine.elements_in(fine.cell(at)) {
                    for (node, up) in fine.elements[e].iter().zip(STEPS) {
                        let node = *node as usize;
                        if element[node] == NONE {
                            element[node] = parent[e];
                            let l = [0, 1, 2].map(|d: usize| at[d] - starts[d][place[d]] + up[d]);
                            step[node] = (l[0] + 3 * l[1] + 9 * l[2]) as u8;
                        }
                    }
                }
            });
        }
        let share = [0, 1, 2].map(|d: usize| {
            let lines = &fine.lines[d];
            let span = |w: &[usize]| {
                let (low, high) = (lines[w[0]], lines[w[1]]);
                std::array::from_fn(|l| (lines[(w[0] + l).min(w[1])] - low) / (high - low))
            };
            starts[d].windows(2).map(span).collect()
        });
        Self {
            element,
            step,
            cell,
            share,
        }
    }

    /// Shares of the way through the cell at `place` after `steps` fine lines.
    pub(super) fn shares(&self, place: [usize; 3], steps: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|d: usize| self.share[d][place[d]][steps[d]])
    }

    /// Weights of a fine node at the corners of its coarse element.
    pub(super) fn weights(&self, coarse: &Grid<'_>, node: usize) -> [f64; 8] {
        let place = coarse.place(self.cell[self.element[node] as usize] as usize);
        weights(self.shares(place, steps(self.step[node])))
    }
}

/// `x + 3 y + 9 z` taken apart.
pub(super) fn steps(step: u8) -> [usize; 3] {
    let step = usize::from(step);
    [step % 3, step / 3 % 3, step / 9]
}

/// Trilinear weights at the corners, VTK order.
#[inline(always)]
pub(super) fn weights<R: Real>(share: [R; 3]) -> [R; 8] {
    let [x, y, z] = share;
    let one = R::one();
    let (x0, y0, z0) = (one - x, one - y, one - z);
    let [a, b, c, d] = [x0 * y0, x * y0, x * y, x0 * y];
    [a * z0, b * z0, c * z0, d * z0, a * z, b * z, c * z, d * z]
}

/// P and Pᵀ without stored weights.
#[derive(Debug)]
pub(super) struct Interpolation<R> {
    cells: [usize; 3],
    /// First element of every coarse cell, and one more.
    first: Vec<u32>,
    corners: Vec<[u32; 8]>,
    /// First of the fine nodes of every coarse element, and one more.
    begin: Vec<u32>,
    /// Fine nodes and their steps, coarse element by coarse element.
    nodes: Vec<u32>,
    steps: Vec<u8>,
    share: [Vec<[R; 3]>; 3],
    coarse_nodes: usize,
    /// Layers of coarse cells; those of one colour share no coarse node.
    gather: Colours<usize>,
    scatter: Colours<usize>,
}

impl<R: Real> Interpolation<R> {
    pub(super) fn new(owners: &Owners, coarse: &Grid<'_>) -> Self {
        let mut begin = vec![0u32; coarse.elements.len() + 1];
        owners
            .element
            .iter()
            .for_each(|e| begin[*e as usize + 1] += 1);
        for e in 0..coarse.elements.len() {
            begin[e + 1] += begin[e];
        }
        let mut next = begin.clone();
        let mut nodes = vec![0; owners.element.len()];
        let mut steps = vec![0; owners.element.len()];
        for (node, (e, step)) in owners.element.iter().zip(&owners.step).enumerate() {
            let at = &mut next[*e as usize];
            nodes[*at as usize] = node as u32;
            steps[*at as usize] = *step;
            *at += 1;
        }
        let layers = coarse.cells[2];
        let every = |from: usize, by: usize| (from..layers).step_by(by).collect::<Vec<_>>();
        // SAFETY: a fine node has one owner, so layers write disjoint fine nodes; a coarse node lies in one plane, so
        // every second layer has coarse nodes of its own.
        let (scatter, gather) = unsafe {
            (
                Colours::new(vec![every(0, 1)]),
                Colours::new(vec![every(0, 2), every(1, 2)]),
            )
        };
        Self {
            cells: coarse.cells,
            first: coarse.first.clone().unwrap_or_default(),
            corners: coarse.elements.to_vec(),
            begin,
            nodes,
            steps,
            share: owners
                .share
                .each_ref()
                .map(|s| s.iter().map(|s| s.map(R::of)).collect()),
            coarse_nodes: coarse.nodes,
            gather,
            scatter,
        }
    }

    /// Calls `visit` with the corners of every coarse element of a layer, and the shares of its fine lines per axis, and
    /// its fine nodes.
    #[inline(always)]
    fn layer(&self, k: usize, mut visit: impl FnMut(&[u32; 8], [&[R; 3]; 3], Range<usize>)) {
        let [nx, ny, _] = self.cells;
        for j in 0..ny {
            for i in 0..nx {
                let cell = i + nx * (j + ny * k);
                let share = [&self.share[0][i], &self.share[1][j], &self.share[2][k]];
                for e in self.first[cell] as usize..self.first[cell + 1] as usize {
                    let nodes = self.begin[e] as usize..self.begin[e + 1] as usize;
                    visit(&self.corners[e], share, nodes);
                }
            }
        }
    }

    /// Weights of the n-th fine node in the list.
    #[inline(always)]
    fn weights(&self, share: [&[R; 3]; 3], n: usize) -> [R; 8] {
        let [a, b, c] = steps(self.steps[n]);
        weights([share[0][a], share[1][b], share[2][c]])
    }
    /// `x ← P x_c`, or `x ← x + P x_c` if `ADD`.
    fn interpolate<const ADD: bool>(&self, coarse: &[R], x: &mut [R]) {
        assert!(x.len() == 3 * self.nodes.len() && coarse.len() == 3 * self.coarse_nodes);
        self.scatter.run(x, &|k, x| {
            self.layer(*k, |corners, share, nodes| {
                let mut values = [[R::zero(); 3]; 8];
                for (value, corner) in values.iter_mut().zip(corners) {
                    value.copy_from_slice(&coarse[3 * *corner as usize..][..3]);
                }
                for n in nodes {
                    let w = self.weights(share, n);
                    // SAFETY: this layer owns the node.
                    let to = unsafe { x.part(3 * self.nodes[n] as usize, 3) };
                    for i in 0..3 {
                        let sum = (0..8).fold(R::zero(), |sum, a| sum + w[a] * values[a][i]);
                        to[i] = if ADD { to[i] + sum } else { sum };
                    }
                }
            });
        });
    }
}

impl<R: Real> Transfer<R> for Interpolation<R> {
    fn coarse_len(&self) -> usize {
        3 * self.coarse_nodes
    }

    fn restrict(&self, r: &[R], coarse: &mut [R]) {
        assert!(r.len() == 3 * self.nodes.len() && coarse.len() == 3 * self.coarse_nodes);
        coarse.fill(R::zero());
        self.gather.run(coarse, &|k, coarse| {
            self.layer(*k, |corners, share, nodes| {
                let mut sums = [[R::zero(); 3]; 8];
                for n in nodes {
                    let w = self.weights(share, n);
                    let r = &r[3 * self.nodes[n] as usize..][..3];
                    for a in 0..8 {
                        for i in 0..3 {
                            sums[a][i] += w[a] * r[i];
                        }
                    }
                }
                for (corner, sum) in corners.iter().zip(sums) {
                    // SAFETY: a node of this layer.
                    let to = unsafe { coarse.part(3 * *corner as usize, 3) };
                    (0..3).for_each(|i| to[i] += sum[i]);
                }
            });
        });
    }

    fn prolong(&self, coarse: &[R], x: &mut [R]) {
        self.interpolate::<false>(coarse, x);
    }

    fn prolong_add(&self, coarse: &[R], x: &mut [R]) {
        self.interpolate::<true>(coarse, x);
    }

    fn flops(&self) -> u64 {
        // 12 for the weights, 8 fused pairs for three components, twice
        2 * (12 + 48) * self.nodes.len() as u64
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.first)
            + size_of_val(&*self.corners)
            + size_of_val(&*self.begin)
            + size_of_val(&*self.nodes)
            + size_of_val(&*self.steps)
    }
}
