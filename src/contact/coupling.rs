//! The coupling block B: tractions on faces push on the nodes of both sides.

use crate::elasticity::Constraints;
use crate::mesh::FractureMesh;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_operators::vector::for_row_ranges;
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// One face: `B[(a, i), (f, k)] = ± ∫_f N_a dS · e_k[i]`, + on the + side.
#[derive(Clone, Copy, Debug)]
struct Face<R> {
    minus: [u32; 4],
    plus: [u32; 4],
    node_areas: [R; 4],
    frame: [[R; 3]; 3],
}

/// A node of a fracture and the faces around it: entries `range` of the adjacency list.
#[derive(Clone, Copy, Debug)]
struct Touched {
    node: u32,
    first: u32,
    last: u32,
}

/// B, applied face by face without being assembled.
///
/// `Bᵀu` is the jump `u⁺ − u⁻` weighted by area, in the local frame (n, t1, t2) of each face; `B t` is the force of
/// the tractions on the nodes.
///
/// # Shape
/// (3 · nodes) × (3 · faces): displacement `3·node + component`, traction `3·face + (n, t1, t2)`.
/// # Cost
/// About 100 flops and 130 bytes per face and product.
/// # Source
/// Franceschini et al. 2020 (CMAME 368, 113161), piecewise-constant tractions on Q1 hexahedra; deck, slide on B1.
#[derive(Clone, Debug)]
pub struct Coupling<R> {
    faces: Vec<Face<R>>,
    nodes: usize,
    touched: Vec<Touched>,
    around: Vec<(u32, R, u8)>,
}

/// Faces, or touched nodes, that one thread handles without splitting.
const GRAIN: usize = 512;

impl<R: Real> Coupling<R> {
    /// The coupling of all faces of `fractures` in a mesh of `nodes` nodes.
    pub fn new(fractures: &FractureMesh, nodes: usize) -> Self {
        let faces: Vec<Face<R>> = fractures
            .faces
            .iter()
            .map(|f| Face {
                minus: f.minus.nodes,
                plus: f.plus.nodes,
                node_areas: f.node_areas.map(R::of),
                frame: f.frame.map(|e| e.map(R::of)),
            })
            .collect();
        let mut list: Vec<(u32, u32, R, u8)> = Vec::with_capacity(8 * faces.len());
        for (f, face) in faces.iter().enumerate() {
            for a in 0..4 {
                // at a tip both sides share the node and their forces cancel: nothing is stored
                if face.minus[a] != face.plus[a] {
                    list.push((face.minus[a], f as u32, -face.node_areas[a], a as u8));
                    list.push((face.plus[a], f as u32, face.node_areas[a], a as u8));
                }
            }
        }
        list.sort_unstable_by_key(|(node, face, _, a)| (*node, *face, *a));
        let mut touched: Vec<Touched> = Vec::new();
        for (k, entry) in list.iter().enumerate() {
            match touched.last_mut() {
                Some(t) if t.node == entry.0 => t.last = k as u32 + 1,
                _ => touched.push(Touched {
                    node: entry.0,
                    first: k as u32,
                    last: k as u32 + 1,
                }),
            }
        }
        let around = list.into_iter().map(|(_, f, w, a)| (f, w, a)).collect();
        Self {
            faces,
            nodes,
            touched,
            around,
        }
    }

    /// Faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Forces on the touched nodes, splitting the list of nodes and `y` together.
    fn add_forces(&self, touched: &[Touched], offset: usize, alpha: R, t: &[R], y: &mut [R]) {
        if touched.len() > GRAIN {
            let (left, right) = touched.split_at(touched.len() / 2);
            let cut = 3 * right[0].node as usize - offset;
            let (y0, y1) = y.split_at_mut(cut);
            rayon::join(
                || self.add_forces(left, offset, alpha, t, y0),
                || self.add_forces(right, offset + cut, alpha, t, y1),
            );
            return;
        }
        for node in touched {
            let mut force = [R::zero(); 3];
            for (f, weight, _) in &self.around[node.first as usize..node.last as usize] {
                let (e, t) = (&self.faces[*f as usize].frame, &t[3 * *f as usize..][..3]);
                for i in 0..3 {
                    force[i] += *weight * (e[0][i] * t[0] + e[1][i] * t[1] + e[2][i] * t[2]);
                }
            }
            let row = 3 * node.node as usize - offset;
            for i in 0..3 {
                y[row + i] += alpha * force[i];
            }
        }
    }

    /// B with the rows of prescribed displacements left out: n_u × n_t.
    pub fn assemble_free(&self, constraints: &Constraints) -> SparseMatrix<f64> {
        let shape = (constraints.free_len(), 3 * self.faces.len());
        let mut b = Triplets::new(shape);
        self.for_each_entry(|dof, column, value| {
            if let Some(row) = constraints.free_index(dof) {
                b.add_triplet(row, column, value);
            }
        });
        b.to_csr()
    }

    /// `B_cᵀ u_c`: the area-weighted jump that prescribed displacements alone make, one entry per traction.
    pub fn prescribed_jump(&self, constraints: &Constraints) -> Vec<f64> {
        let mut jump = vec![0.0; 3 * self.faces.len()];
        self.for_each_entry(|dof, column, value| {
            jump[column] += value * constraints.value(dof).unwrap_or(0.0);
        });
        jump
    }

    /// Calls `visit(displacement, traction, value)` for every non-zero of B.
    fn for_each_entry(&self, mut visit: impl FnMut(usize, usize, f64)) {
        for node in &self.touched {
            for (f, weight, _) in &self.around[node.first as usize..node.last as usize] {
                let face = *f as usize;
                for (k, e) in self.faces[face].frame.iter().enumerate() {
                    for (i, e_i) in e.iter().enumerate() {
                        let value = (*weight * *e_i).to_f64_exact();
                        if value != 0.0 {
                            visit(3 * node.node as usize + i, 3 * face + k, value);
                        }
                    }
                }
            }
        }
    }
}

impl<R: Real> LinearOperator<R> for Coupling<R> {
    fn shape(&self) -> Shape {
        Shape::new(3 * self.nodes, 3 * self.faces.len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape(), x, y);
        self.add_forces(&self.touched, 0, alpha, x, y);
    }

    fn flops(&self) -> u64 {
        21 * self.around.len() as u64 + 6 * self.touched.len() as u64
    }
}

impl<R: Real> AdjointOperator<R> for Coupling<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape().transposed(), x, y);
        for_row_ranges(0, 3 * GRAIN, y, &|start, part| {
            for (f, g) in part.chunks_exact_mut(3).enumerate() {
                let face = &self.faces[start / 3 + f];
                let mut jump = [R::zero(); 3];
                for a in 0..4 {
                    let (p, m) = (3 * face.plus[a] as usize, 3 * face.minus[a] as usize);
                    for i in 0..3 {
                        jump[i] += face.node_areas[a] * (x[p + i] - x[m + i]);
                    }
                }
                for (g_k, e) in g.iter_mut().zip(&face.frame) {
                    *g_k += alpha * (e[0] * jump[0] + e[1] * jump[1] + e[2] * jump[2]);
                }
            }
        });
    }
}
