//! The fracture term `B C⁻¹Bᵀ`: in place on the finest level, Galerkin on the first coarse one.

use super::grid::{Grid, STEPS};
use super::interpolation::weights;
use super::remainder::{Rows, Step};
use crate::contact::Coupling;
use crate::mesh::{FaceSide, FractureFace, FractureMesh};
use fracas_operators::small::{Matrix3, Symmetric, cast, diagonal, times, upper};
use fracas_operators::{AdjointOperator, LinearOperator, Real};
use fracas_solvers::saddle::AugmentationMatrix;

/// The inverse block of every face, divided by `scale`.
pub(super) fn inverse_blocks(c: &AugmentationMatrix, scale: f64) -> Option<Vec<Matrix3<f64>>> {
    match c {
        AugmentationMatrix::Diagonal { c } => {
            let block = |c: &[f64; 3]| diagonal(c.map(|c| 1.0 / (c * scale)));
            Some(c.as_chunks().0.iter().map(block).collect())
        }
        AugmentationMatrix::FaceBlocks { inverse, .. } => {
            let scaled = |b: &Matrix3<f64>| b.map(|row| row.map(|v| v / scale));
            Some(inverse.iter().map(scaled).collect())
        }
        AugmentationMatrix::Dense { .. } | AugmentationMatrix::Custom(_) => None,
    }
}

/// `y ← y + α B C⁻¹Bᵀ x` over all displacements.
#[derive(Debug)]
pub(super) struct FractureTerm<R> {
    b: Coupling<R>,
    c_inverse: Vec<Matrix3<R>>,
}

impl<R: Real> FractureTerm<R> {
    pub(super) fn new(fractures: &FractureMesh, nodes: usize, c_inverse: &[Matrix3<f64>]) -> Self {
        Self {
            b: Coupling::in_full_numbering(fractures, nodes),
            c_inverse: c_inverse.iter().map(cast).collect(),
        }
    }

    pub(super) fn add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        if self.c_inverse.is_empty() {
            return;
        }
        let (t, work) = work.split_at_mut(self.work_len());
        t.fill(R::zero());
        self.b.apply_adjoint_add(alpha, x, t, work);
        for (t, c) in t.as_chunks_mut().0.iter_mut().zip(&self.c_inverse) {
            *t = times(c, t);
        }
        self.b.apply_add(R::one(), t, y, work);
    }

    pub(super) fn work_len(&self) -> usize {
        3 * self.c_inverse.len()
    }

    pub(super) fn flops(&self) -> u64 {
        2 * self.b.flops() + 15 * self.c_inverse.len() as u64
    }

    pub(super) fn bytes(&self) -> usize {
        self.c_inverse.len() * size_of::<Matrix3<R>>() + self.b.bytes()
    }
}

/// `M = Eᵀ C⁻¹ E` in global axes, E the frame by rows.
fn in_global_axes(face: &FractureFace, c_inverse: &Matrix3<f64>) -> Matrix3<f64> {
    let e = &face.frame;
    let entry = |i: usize, j: usize| {
        let mut sum = 0.0;
        for k in 0..3 {
            for l in 0..3 {
                sum += e[k][i] * c_inverse[k][l] * e[l][j];
            }
        }
        sum
    };
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// Adds the diagonal blocks of `B C⁻¹Bᵀ`.
pub(super) fn add_diagonals(
    fractures: &FractureMesh,
    c_inverse: &[Matrix3<f64>],
    diagonal: &mut [Symmetric<f64>],
) {
    for (face, c_inverse) in fractures.faces.iter().zip(c_inverse) {
        let m = upper(&in_global_axes(face, c_inverse));
        for a in 0..4 {
            let (minus, plus) = (face.minus.nodes[a], face.plus.nodes[a]);
            if minus == plus {
                continue;
            }
            let square = face.node_areas[a] * face.node_areas[a];
            for node in [minus, plus] {
                let to = diagonal[node as usize].iter_mut();
                to.zip(m).for_each(|(to, m)| *to += square * m);
            }
        }
    }
}

/// Pairs of elements on the two sides of a face, each once.
pub(super) fn links(fractures: &FractureMesh, parent: &[u32]) -> Vec<[u32; 2]> {
    let sides = |f: &FractureFace| [f.minus.element, f.plus.element];
    let pairs = fractures.faces.iter().map(sides);
    unique(pairs, parent)
}

/// The pairs of parents, each once, ascending.
pub(super) fn unique(pairs: impl Iterator<Item = [u32; 2]>, parent: &[u32]) -> Vec<[u32; 2]> {
    let mut links: Vec<[u32; 2]> = pairs
        .map(|pair| {
            let [a, b] = pair.map(|e| parent[e as usize]);
            [a.min(b), a.max(b)]
        })
        .collect();
    links.sort_unstable();
    links.dedup();
    links
}

/// Adds `Pᵀ b_f C_f⁻¹ b_fᵀ P`, face by face.
pub(super) fn add_faces(
    rows: &mut Rows,
    step: Step<'_>,
    fractures: &FractureMesh,
    c_inverse: &[Matrix3<f64>],
) {
    let mut jump: Vec<(u32, [f64; 3])> = Vec::new();
    for (face, c_inverse) in fractures.faces.iter().zip(c_inverse) {
        jump.clear();
        add_side(&mut jump, step, face, &face.minus, -1.0);
        add_side(&mut jump, step, face, &face.plus, 1.0);
        let m = in_global_axes(face, c_inverse);
        for (row, g) in &jump {
            for (column, h) in &jump {
                let block = std::array::from_fn(|i| std::array::from_fn(|j| g[i] * m[i][j] * h[j]));
                rows.add(*row as usize, *column, &block);
            }
        }
    }
}

/// Weights of the coarse nodes in ± the area-weighted displacement of one side, per component.
fn add_side(
    jump: &mut Vec<(u32, [f64; 3])>,
    step: Step<'_>,
    face: &FractureFace,
    side: &FaceSide,
    sign: f64,
) {
    let coarsening = step.coarsening;
    let (fine, coarse): (&Grid<'_>, _) = (step.fine, &coarsening.coarse);
    let element = side.element as usize;
    let piece = coarsening.parent[element] as usize;
    let place = coarse.place(step.owners.cell[piece] as usize);
    let at = fine.place(element);
    for a in 0..4 {
        let node = side.nodes[a];
        // both sides share the node: no jump there
        if face.minus.nodes[a] == face.plus.nodes[a] {
            continue;
        }
        for (_, up) in fine.elements[element]
            .iter()
            .zip(STEPS)
            .filter(|(n, _)| **n == node)
        {
            let starts = &coarsening.starts;
            let local = [0, 1, 2].map(|d: usize| at[d] - starts[d][place[d]] + up[d]);
            let shares = weights(step.owners.shares(place, local));
            for (corner, share) in coarse.elements[piece].iter().zip(shares) {
                if share == 0.0 {
                    continue;
                }
                let fixed = step.fixed[node as usize];
                let weight = sign * face.node_areas[a] * share;
                let entry = match jump.iter().position(|(n, _)| n == corner) {
                    Some(entry) => entry,
                    None => {
                        jump.push((*corner, [0.0; 3]));
                        jump.len() - 1
                    }
                };
                for i in 0..3 {
                    if fixed >> i & 1 == 0 {
                        jump[entry].1[i] += weight;
                    }
                }
            }
        }
    }
}
