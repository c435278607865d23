//! Coarse cells, their pieces, and the copies of their corners.
//!
//! Inside a coarse cell the elements that are joined by faces with common nodes are one coarse element: a fracture through
//! the cell leaves one per side, a fracture that ends in it leaves one. Corners of coarse elements are one node if a
//! joined pair of elements lies across the coarse face between them. So a fine node gets the same weights from every
//! element around it: those around a copy are connected by joined faces at the node, and across such a face the coarse
//! corners are shared.

use super::grid::{ACROSS, Grid, STEPS};
use std::borrow::Cow;

/// Mark of a vertex without a node yet.
const NONE: u32 = u32::MAX;

/// A coarse grid and how the fine one lies in it.
#[derive(Debug)]
pub(super) struct Coarsening {
    pub(super) coarse: Grid<'static>,
    /// The coarse element that holds each fine element.
    pub(super) parent: Vec<u32>,
    /// First fine cell of every coarse cell per axis, and one more.
    pub(super) starts: [Vec<usize>; 3],
}

/// The coarse grid whose cells begin at the fine lines `starts` of each axis, at most two fine cells each.
///
/// # Cost
/// O(elements) time, 32 bytes per coarse element of scratch.
pub(super) fn coarsen(fine: &Grid<'_>, starts: [Vec<usize>; 3]) -> Coarsening {
    let cells = [0, 1, 2].map(|d: usize| starts[d].len() - 1);
    let mut coarse = Grid {
        cells,
        lines: [0, 1, 2].map(|d: usize| {
            let lines: Vec<f64> = starts[d].iter().map(|i| fine.lines[d][*i]).collect();
            Cow::Owned(lines)
        }),
        origin: [0, 1, 2].map(|d: usize| starts[d].iter().map(|i| fine.origin[d][*i]).collect()),
        nodes: 0,
        elements: Cow::Owned(Vec::new()),
        first: None,
        copies: Vec::new(),
    };
    let (parent, first) = pieces(fine, &coarse, &starts);
    let count = first.last().copied().unwrap_or(0) as usize;
    let mut root: Vec<u32> = (0..8 * count as u32).collect();
    for axis in 0..3 {
        join_corners(fine, &coarse, &starts, &parent, axis, &mut root);
    }
    coarse.first = Some(first);
    number(&mut coarse, count, &mut root);
    Coarsening {
        coarse,
        parent,
        starts,
    }
}

/// Coarse element of every fine one, and the first of every coarse cell.
fn pieces(fine: &Grid<'_>, coarse: &Grid<'_>, starts: &[Vec<usize>; 3]) -> (Vec<u32>, Vec<u32>) {
    let mut parent = vec![0; fine.elements.len()];
    let count = coarse.cells.iter().product::<usize>();
    let mut first = Vec::with_capacity(count + 1);
    let mut next = 0;
    let mut inside: Vec<(usize, [usize; 3])> = Vec::new();
    let mut group: Vec<usize> = Vec::new();
    let mut name: Vec<u32> = Vec::new();
    for cell in 0..count {
        first.push(next);
        inside.clear();
        for_each_fine(coarse.place(cell), starts, |at| {
            inside.extend(fine.elements_in(fine.cell(at)).map(|e| (e, at)));
        });
        group.clear();
        group.extend(0..inside.len());
        for (a, (e, low)) in inside.iter().enumerate() {
            for (b, (f, high)) in inside.iter().enumerate().skip(a + 1) {
                let step = [0, 1, 2].map(|d: usize| high[d].wrapping_sub(low[d]));
                let axis = match step {
                    [1, 0, 0] => 0,
                    [0, 1, 0] => 1,
                    [0, 0, 1] => 2,
                    _ => continue,
                };
                if fine.joined(*e, *f, axis) {
                    let (a, b) = (top(&group, a), top(&group, b));
                    group[a.max(b)] = a.min(b);
                }
            }
        }
        name.clear();
        name.resize(inside.len(), NONE);
        for (a, (e, _)) in inside.iter().enumerate() {
            let piece = top(&group, a);
            if name[piece] == NONE {
                name[piece] = next;
                next += 1;
            }
            parent[*e] = name[piece];
        }
    }
    first.push(next);
    (parent, first)
}

/// Calls `visit` with every fine cell in a coarse one, x fastest.
pub(super) fn for_each_fine(
    coarse: [usize; 3],
    starts: &[Vec<usize>; 3],
    mut visit: impl FnMut([usize; 3]),
) {
    let range = |d: usize| starts[d][coarse[d]]..starts[d][coarse[d] + 1];
    for k in range(2) {
        for j in range(1) {
            for i in range(0) {
                visit([i, j, k]);
            }
        }
    }
}

fn top(group: &[usize], mut a: usize) -> usize {
    while group[a] != a {
        a = group[a];
    }
    a
}

/// Root of an entry in a union-find forest, halving paths.
fn root_of(root: &mut [u32], mut i: u32) -> u32 {
    while root[i as usize] != i {
        root[i as usize] = root[root[i as usize] as usize];
        i = root[i as usize];
    }
    i
}

/// Unites the corners of coarse elements across coarse faces normal to `axis` where fine elements are joined.
fn join_corners(
    fine: &Grid<'_>,
    coarse: &Grid<'_>,
    starts: &[Vec<usize>; 3],
    parent: &[u32],
    axis: usize,
    root: &mut [u32],
) {
    let mut done: Vec<[u32; 2]> = Vec::new();
    for cell in 0..coarse.cells.iter().product() {
        let place = coarse.place(cell);
        if place[axis] + 1 == coarse.cells[axis] {
            continue;
        }
        done.clear();
        let border = starts[axis][place[axis] + 1];
        for_each_fine(place, starts, |low| {
            if low[axis] + 1 != border {
                return;
            }
            let mut high = low;
            high[axis] = border;
            for e in fine.elements_in(fine.cell(low)) {
                for f in fine.elements_in(fine.cell(high)) {
                    let pair = [parent[e], parent[f]];
                    if done.contains(&pair) || !fine.joined(e, f, axis) {
                        continue;
                    }
                    done.push(pair);
                    for [a, b] in ACROSS[axis] {
                        let a = root_of(root, 8 * pair[0] + a as u32);
                        let b = root_of(root, 8 * pair[1] + b as u32);
                        root[a.max(b) as usize] = a.min(b);
                    }
                }
            }
        });
    }
}

/// Numbers the classes of corners: the first one at a vertex takes the vertex' number, the others follow behind.
fn number(coarse: &mut Grid<'static>, count: usize, root: &mut [u32]) {
    let vertices = coarse.vertices();
    let mut taken = vec![false; vertices];
    let mut next = vertices as u32;
    let mut elements = vec![[NONE; 8]; count];
    for cell in 0..coarse.cells.iter().product() {
        let place = coarse.place(cell);
        for e in coarse.elements_in(cell) {
            for (a, step) in STEPS.iter().enumerate() {
                let entry = (8 * e + a) as u32;
                let class = root_of(root, entry);
                if class != entry {
                    // roots are the lowest entries of their classes, so they are numbered already
                    let (e, a) = (class as usize / 8, class as usize % 8);
                    let node = elements[e][a];
                    elements[entry as usize / 8][entry as usize % 8] = node;
                    continue;
                }
                let vertex = coarse.vertex([0, 1, 2].map(|d: usize| place[d] + step[d]));
                elements[e][a] = if taken[vertex] {
                    coarse.copies.push(vertex as u32);
                    next += 1;
                    next - 1
                } else {
                    taken[vertex] = true;
                    vertex as u32
                };
            }
        }
    }
    coarse.nodes = next as usize;
    coarse.elements = Cow::Owned(elements);
}
