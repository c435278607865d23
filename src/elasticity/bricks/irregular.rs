//! The bricks beside a fracture: their nodes were split, so they are reached through an index list.

use super::parity::{Coefficients, forces, to_nodes, to_parities};
use crate::mesh::HexMesh;
use fracas_operators::Real;
use fracas_operators::simd::{InstructionSet, Scalar, Simd};

/// Cells that are treated at once, one per SIMD lane (two vectors of eight in f64).
const LANES: usize = 16;

/// Nodes whose forces one thread sums without splitting.
const GRAIN: usize = 512;

/// VTK's corner order, x fastest.
const X_FASTEST: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

/// [`LANES`] cells side by side; a group that is not full repeats its last cell with zero stiffness.
#[derive(Clone, Debug)]
struct Group<R> {
    nodes: [[u32; LANES]; 8],
    lambda: [R; LANES],
    shear: [R; LANES],
    alpha: [[R; LANES]; 3],
    beta: [[R; LANES]; 3],
}

/// A node and its corners `first..last` in the list of all corners.
#[derive(Clone, Copy, Debug)]
struct Around {
    node: u32,
    first: u32,
    last: u32,
}

/// Bricks reached through indices: forces go to a buffer per corner, then every node sums its corners in a fixed order.
#[derive(Clone, Debug)]
pub(super) struct Irregular<R> {
    groups: Vec<Group<R>>,
    nodes: Vec<Around>,
    corners: Vec<u32>,
    cells: usize,
}

impl<R> Default for Irregular<R> {
    fn default() -> Self {
        Self {
            groups: Vec::new(),
            nodes: Vec::new(),
            corners: Vec::new(),
            cells: 0,
        }
    }
}

/// Entries of the buffer that a group fills: `[corner][component][lane]`.
const GROUP_LEN: usize = 24 * LANES;

impl<R: Real> Irregular<R> {
    /// The cells `elements`, with `brick(e) = (λ, G, h)`.
    pub(super) fn new(
        mesh: &HexMesh,
        elements: &[usize],
        brick: impl Fn(usize) -> (R, R, [R; 3]),
    ) -> Self {
        let mut list: Vec<(u32, u32)> = Vec::with_capacity(8 * elements.len());
        let mut groups = Vec::with_capacity(elements.len().div_ceil(LANES));
        for (g, cells) in elements.chunks(LANES).enumerate() {
            let mut group = Group {
                nodes: [[0; LANES]; 8],
                lambda: [R::zero(); LANES],
                shear: [R::zero(); LANES],
                alpha: [[R::zero(); LANES]; 3],
                beta: [[R::zero(); LANES]; 3],
            };
            for (lane, e) in cells.iter().enumerate() {
                let (lambda, shear, h) = brick(*e);
                let volume = h[0] * h[1] * h[2];
                group.lambda[lane] = lambda;
                group.shear[lane] = shear;
                for d in 0..3 {
                    group.alpha[d][lane] = volume / (R::of(16.0) * h[d] * h[d]);
                    group.beta[d][lane] = h[d] / R::of(16.0);
                }
                for corner in 0..8 {
                    let node = mesh.elements[*e][X_FASTEST[corner]];
                    group.nodes[corner][lane] = node;
                    list.push((node, (g * GROUP_LEN + 3 * corner * LANES + lane) as u32));
                }
            }
            groups.push(group);
        }
        list.sort_unstable();
        let mut nodes: Vec<Around> = Vec::new();
        let mut first = 0;
        for corners in list.chunk_by(|a, b| a.0 == b.0) {
            let last = first + corners.len() as u32;
            nodes.push(Around {
                node: corners[0].0,
                first,
                last,
            });
            first = last;
        }
        let corners = list.into_iter().map(|(_, position)| position).collect();
        Self {
            groups,
            nodes,
            corners,
            cells: elements.len(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.cells
    }

    pub(super) fn work_len(&self) -> usize {
        self.groups.len() * GROUP_LEN
    }

    /// `y ← y + α K x` over these cells.
    pub(super) fn apply_add(
        &self,
        instructions: InstructionSet,
        alpha: R,
        x: &[R],
        y: &mut [R],
        work: &mut [R],
    ) {
        let buffer = &mut work[..self.work_len()];
        fill(&self.groups, instructions, x, buffer);
        self.gather(&self.nodes, 0, alpha, buffer, y);
    }

    /// Sums the corners of every node; `y` starts at entry `offset`.
    fn gather(&self, nodes: &[Around], offset: usize, alpha: R, buffer: &[R], y: &mut [R]) {
        if nodes.len() > GRAIN {
            let (left, right) = nodes.split_at(nodes.len() / 2);
            let start = 3 * right[0].node as usize;
            let (y0, y1) = y.split_at_mut(start - offset);
            rayon::join(
                || self.gather(left, offset, alpha, buffer, y0),
                || self.gather(right, start, alpha, buffer, y1),
            );
            return;
        }
        for around in nodes {
            let mut force = [R::zero(); 3];
            for corner in &self.corners[around.first as usize..around.last as usize] {
                for (i, f) in force.iter_mut().enumerate() {
                    *f += buffer[*corner as usize + i * LANES];
                }
            }
            let row = 3 * around.node as usize - offset;
            for i in 0..3 {
                y[row + i] += alpha * force[i];
            }
        }
    }
}

/// Forces of all groups, in parallel.
fn fill<R: Real>(groups: &[Group<R>], instructions: InstructionSet, x: &[R], buffer: &mut [R]) {
    if groups.len() > 8 {
        let half = groups.len() / 2;
        let (b0, b1) = buffer.split_at_mut(half * GROUP_LEN);
        rayon::join(
            || fill(&groups[..half], instructions, x, b0),
            || fill(&groups[half..], instructions, x, b1),
        );
        return;
    }
    for (group, forces) in groups.iter().zip(buffer.chunks_exact_mut(GROUP_LEN)) {
        match instructions {
            // SAFETY: `instructions` names a set that this processor was found to have.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512 => unsafe { group_avx512(group, x, forces) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2 => unsafe { group_avx2(group, x, forces) },
            _ => group_forces::<R, Scalar<R>>(group, x, forces),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma")]
fn group_avx512<R: Real>(group: &Group<R>, x: &[R], out: &mut [R]) {
    group_forces::<R, R::Wide512>(group, x, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn group_avx2<R: Real>(group: &Group<R>, x: &[R], out: &mut [R]) {
    group_forces::<R, R::Wide256>(group, x, out);
}

/// Forces of one group: gather, then the brick formula in every lane.
#[inline(always)]
fn group_forces<R: Real, V: Simd<R>>(group: &Group<R>, x: &[R], out: &mut [R]) {
    let mut u = [[[R::zero(); LANES]; 8]; 3];
    for corner in 0..8 {
        for lane in 0..LANES {
            let node = 3 * group.nodes[corner][lane] as usize;
            for (c, value) in x[node..node + 3].iter().enumerate() {
                u[c][corner][lane] = *value;
            }
        }
    }
    for lane in (0..LANES).step_by(V::LANES) {
        let load = |line: &[R; LANES]| V::load(&line[lane..]);
        let k = Coefficients::new(
            load(&group.lambda),
            load(&group.shear),
            [
                load(&group.alpha[0]),
                load(&group.alpha[1]),
                load(&group.alpha[2]),
            ],
            [
                load(&group.beta[0]),
                load(&group.beta[1]),
                load(&group.beta[2]),
            ],
        );
        let mut parities = [[V::splat(R::zero()); 8]; 3];
        for c in 0..3 {
            for corner in 0..8 {
                parities[c][corner] = load(&u[c][corner]);
            }
            to_parities(&mut parities[c]);
        }
        let mut f = forces::<R, V>(&parities, &k);
        for c in 0..3 {
            to_nodes(&mut f[c]);
            for corner in 0..8 {
                f[c][corner].store(&mut out[(3 * corner + c) * LANES + lane..]);
            }
        }
    }
}
