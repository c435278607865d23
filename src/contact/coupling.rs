//! The coupling block B: tractions on faces push on the nodes of both sides.

use crate::elasticity::Constraints;
use crate::mesh::{FractureFace, FractureMesh, Places};
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_operators::vector::for_row_ranges;
use fracas_operators::{AdjointOperator, LinearOperator, Real, Shape};

/// Mark of a displacement that is prescribed and therefore no unknown.
const PRESCRIBED: u32 = u32::MAX;

/// Faces, or nodes, that one thread handles without splitting.
const GRAIN: usize = 512;

/// One face: `B[(a, i), (f, k)] = ± ∫_f N_a dS · e_k[i]`, + on the + side, and for k = n of a face that is not plane `± ∫_f N_a n[i] dS`, n the
/// normal of every point; nodes count in [`Coupling::unknowns`].
#[derive(Clone, Copy, Debug)]
struct Face<R> {
    minus: [u32; 4],
    plus: [u32; 4],
    node_areas: [R; 4],
    frame: [[R; 3]; 3],
}

/// A node with at least one unknown, and where its faces stand in the list `around`.
#[derive(Clone, Copy, Debug)]
struct Pushed {
    unknowns: [u32; 3],
    first: u32,
    last: u32,
}

/// B over the free displacements, applied face by face without being assembled.
///
/// `Bᵀu` is the jump `u⁺ − u⁻` weighted by area, in the local frame (n, t1, t2) of each face; `B t` is the force of
/// the tractions on the nodes. Prescribed displacements are no rows of B; see [`prescribed_jump`].
///
/// # Shape
/// n_u × (3 · faces): free displacements, tractions `3·face + (n, t1, t2)`.
/// # Cost
/// About 100 flops and 130 bytes per face and product.
/// # Source
/// Piecewise-constant tractions on Q1 hexahedra: Franceschini et al. 2020, CMAME 368, 113161; M. Ferronato, SNA'25 lecture, block B1.
#[derive(Clone, Debug)]
pub struct Coupling<R> {
    faces: Vec<Face<R>>,
    rows: usize,
    unknowns: Vec<[u32; 3]>,
    pushed: Vec<Pushed>,
    around: Vec<(u32, R)>,
    /// What a normal traction pushes beyond `∫ N_a dS n`, beside every entry of `around`; empty where every face is plane.
    around_tilts: Vec<[R; 3]>,
    /// The same per face and corner.
    tilts: Vec<[[R; 3]; 4]>,
}

/// A node on one side of a face.
struct Side {
    node: u32,
    face: u32,
    /// `± ∫ N_a dS` [m²].
    weight: f64,
    /// `± ∫ N_a (n(x) − n) dS` [m²].
    tilt: [f64; 3],
}

/// Every node that belongs to one side only, node by node; at a tip both sides share the node, their forces cancel and nothing is stored.
fn sides(fractures: &FractureMesh) -> Vec<Side> {
    let mut list = Vec::with_capacity(8 * fractures.faces.len());
    for (f, face) in fractures.faces.iter().enumerate() {
        for a in 0..4 {
            let (minus, plus) = (face.minus.nodes[a], face.plus.nodes[a]);
            if minus != plus {
                let tilt = face.tilts.as_ref().map_or([0.0; 3], |tilts| tilts[a]);
                for (node, sign) in [(minus, -1.0), (plus, 1.0)] {
                    list.push(Side {
                        node,
                        face: f as u32,
                        weight: sign * face.node_areas[a],
                        tilt: tilt.map(|t| sign * t),
                    });
                }
            }
        }
    }
    list.sort_unstable_by_key(|side| (side.node, side.face));
    list
}

impl<R: Real> Coupling<R> {
    /// The coupling of all faces of `fractures` to the displacements that `constraints` leave free.
    pub fn new(fractures: &FractureMesh, constraints: &Constraints) -> Self {
        let index = |dof: usize| constraints.free_index(dof).map_or(PRESCRIBED, |j| j as u32);
        Self::numbered(fractures, constraints.free_len(), index)
    }

    /// The coupling to all displacements of `nodes` nodes, `3·node + component`, whether prescribed or not.
    pub fn in_full_numbering(fractures: &FractureMesh, nodes: usize) -> Self {
        Self::numbered(fractures, 3 * nodes, |dof| dof as u32)
    }

    /// The coupling to the displacements of `nodes` alone, those of `fractures` among them: `3·place + component`; rows of prescribed
    /// displacements are empty.
    pub(crate) fn on(nodes: &Places, fractures: &FractureMesh, constraints: &Constraints) -> Self {
        let place = |dof: usize| Some(3 * nodes.of((dof / 3) as u32)? + dof % 3);
        let index = |dof: usize| match constraints.free_index(dof).and(place(dof)) {
            None => PRESCRIBED,
            Some(row) => row as u32,
        };
        Self::numbered(fractures, 3 * nodes.nodes().len(), index)
    }

    /// The coupling to `rows` unknowns, `index(3·node + component)` of them or [`PRESCRIBED`].
    fn numbered(fractures: &FractureMesh, rows: usize, index: impl Fn(usize) -> u32) -> Self {
        let mut nodes: Vec<u32> = fractures
            .faces
            .iter()
            .flat_map(|f| f.minus.nodes.into_iter().chain(f.plus.nodes))
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        let local = |node: u32| nodes.partition_point(|n| *n < node) as u32;
        let unknowns: Vec<[u32; 3]> = nodes
            .iter()
            .map(|node| std::array::from_fn(|i| index(3 * *node as usize + i)))
            .collect();
        let faces = fractures
            .faces
            .iter()
            .map(|f| Face {
                minus: f.minus.nodes.map(local),
                plus: f.plus.nodes.map(local),
                node_areas: f.node_areas.map(R::of),
                frame: f.frame.map(|e| e.map(R::of)),
            })
            .collect();

        let is_plane = fractures.faces.iter().all(|f| f.tilts.is_none());
        let (mut pushed, mut around): (Vec<Pushed>, Vec<(u32, R)>) = Default::default();
        let mut around_tilts = Vec::new();
        for group in sides(fractures).chunk_by(|a, b| a.node == b.node) {
            let first = around.len() as u32;
            around.extend(group.iter().map(|side| (side.face, R::of(side.weight))));
            if !is_plane {
                around_tilts.extend(group.iter().map(|side| side.tilt.map(R::of)));
            }
            let unknowns = unknowns[local(group[0].node) as usize];
            if unknowns != [PRESCRIBED; 3] {
                let last = around.len() as u32;
                pushed.push(Pushed {
                    unknowns,
                    first,
                    last,
                });
            }
        }
        Self {
            faces,
            rows,
            unknowns,
            pushed,
            around,
            around_tilts,
            tilts: match is_plane {
                true => Vec::new(),
                false => fractures.faces.iter().map(tilts_of).collect(),
            },
        }
    }

    /// What a unit traction along k = n, t1, t2 pushes on a node, face by face, as `(face, k, weight, direction)`.
    fn columns(&self, node: &Pushed) -> impl Iterator<Item = (usize, usize, R, [R; 3])> + '_ {
        let places = node.first as usize..node.last as usize;
        places.flat_map(move |place| {
            let (face, weight) = self.around[place];
            let frame = self.faces[face as usize].frame;
            (0..3).map(move |k| {
                let mut direction = frame[k];
                if let (0, Some(tilt)) = (k, self.around_tilts.get(place)) {
                    (0..3).for_each(|i| direction[i] += tilt[i] / weight);
                }
                (face as usize, k, weight, direction)
            })
        })
    }

    /// `s B`: the coupling of tractions counted in units of s.
    #[must_use]
    pub fn in_traction_unit(mut self, unit: R) -> Self {
        let weights = self.around.iter_mut().map(|(_, weight)| weight);
        let areas = self.faces.iter_mut().flat_map(|face| &mut face.node_areas);
        weights.chain(areas).for_each(|factor| *factor *= unit);
        let of_faces = self.tilts.iter_mut().flatten();
        let tilts = self.around_tilts.iter_mut().chain(of_faces).flatten();
        tilts.for_each(|factor| *factor *= unit);
        self
    }

    /// Largest |entry| of B; 0 where it has none.
    pub fn largest_entry(&self) -> R {
        let mut largest = R::zero();
        for node in &self.pushed {
            for (_, _, weight, e) in self.columns(node) {
                for (row, e_i) in node.unknowns.iter().zip(e) {
                    if *row != PRESCRIBED {
                        largest = largest.max((weight * e_i).abs());
                    }
                }
            }
        }
        largest
    }

    /// `y ← y + |B|ᵀ|u|`: what the jumps `Bᵀu` are the difference of.
    pub fn add_absolute_jumps(&self, u: &[R], y: &mut [R]) {
        assert_product(self.shape().transposed(), u, y);
        for node in &self.pushed {
            let size = node.unknowns.map(|row| match row {
                PRESCRIBED => R::zero(),
                j => u[j as usize].abs(),
            });
            for (f, k, weight, e) in self.columns(node) {
                let jump = e[0].abs() * size[0] + e[1].abs() * size[1] + e[2].abs() * size[2];
                y[3 * f + k] += weight.abs() * jump;
            }
        }
    }

    /// `y ← y + diag(Bᵀ W B)` for a diagonal W.
    pub fn add_weighted_squares(&self, w: &[R], y: &mut [R]) {
        assert_product(self.shape().transposed(), w, y);
        for node in &self.pushed {
            let w = node.unknowns.map(|row| match row {
                PRESCRIBED => R::zero(),
                j => w[j as usize],
            });
            for (f, k, weight, e) in self.columns(node) {
                let sum = w[0] * e[0] * e[0] + w[1] * e[1] * e[1] + w[2] * e[2] * e[2];
                y[3 * f + k] += weight * weight * sum;
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.faces)
            + size_of_val(&*self.unknowns)
            + size_of_val(&*self.pushed)
            + size_of_val(&*self.around)
            + size_of_val(&*self.around_tilts)
            + size_of_val(&*self.tilts)
    }

    /// Forces on the nodes, splitting the list of nodes and `y` together (both are ordered).
    fn add_forces(&self, nodes: &[Pushed], offset: usize, alpha: R, t: &[R], y: &mut [R]) {
        if nodes.len() > GRAIN {
            let (left, right) = nodes.split_at(nodes.len() / 2);
            let start = right[0]
                .unknowns
                .iter()
                .min()
                .map_or(offset, |u| *u as usize);
            let (y0, y1) = y.split_at_mut(start - offset);
            rayon::join(
                || self.add_forces(left, offset, alpha, t, y0),
                || self.add_forces(right, start, alpha, t, y1),
            );
            return;
        }
        for node in nodes {
            let mut force = [R::zero(); 3];
            for (f, weight) in &self.around[node.first as usize..node.last as usize] {
                let (e, t) = (&self.faces[*f as usize].frame, &t[3 * *f as usize..][..3]);
                for i in 0..3 {
                    force[i] += *weight * (e[0][i] * t[0] + e[1][i] * t[1] + e[2][i] * t[2]);
                }
            }
            if !self.around_tilts.is_empty() {
                for place in node.first as usize..node.last as usize {
                    let t_n = t[3 * self.around[place].0 as usize];
                    (0..3).for_each(|i| force[i] += self.around_tilts[place][i] * t_n);
                }
            }
            for (row, f_i) in node.unknowns.iter().zip(force) {
                if *row != PRESCRIBED {
                    y[*row as usize - offset] += alpha * f_i;
                }
            }
        }
    }
}

impl Coupling<f64> {
    /// The same block as a sparse matrix without stored zeros.
    pub fn assemble(&self) -> SparseMatrix<f64> {
        let mut b = Triplets::new((self.rows, 3 * self.faces.len()));
        for node in &self.pushed {
            for (f, k, weight, e) in self.columns(node) {
                for (row, e_i) in node.unknowns.iter().zip(e) {
                    if *row != PRESCRIBED && e_i != 0.0 {
                        b.add_triplet(*row as usize, 3 * f + k, weight * e_i);
                    }
                }
            }
        }
        b.to_csr()
    }
}

/// Those of a face, 0 where it is plane.
fn tilts_of<R: Real>(face: &FractureFace) -> [[R; 3]; 4] {
    let zero = [[R::zero(); 3]; 4];
    (face.tilts.as_ref()).map_or(zero, |tilts| tilts.map(|tilt| tilt.map(R::of)))
}

/// `B_cᵀ u_c`: the area-weighted jump that the prescribed displacements alone make, one entry per traction [m³].
pub fn prescribed_jump(fractures: &FractureMesh, constraints: &Constraints) -> Vec<f64> {
    let mut jump = vec![0.0; 3 * fractures.faces.len()];
    for side in sides(fractures) {
        let (node, f) = (side.node as usize, side.face as usize);
        for (k, e) in fractures.faces[f].frame.iter().enumerate() {
            for (i, e_i) in e.iter().enumerate() {
                let u_c = constraints.value(3 * node + i).unwrap_or(0.0);
                let tilt = if k == 0 { side.tilt[i] } else { 0.0 };
                jump[3 * f + k] += (side.weight * e_i + tilt) * u_c;
            }
        }
    }
    jump
}

impl<R: Real> LinearOperator<R> for Coupling<R> {
    fn shape(&self) -> Shape {
        Shape::new(self.rows, 3 * self.faces.len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape(), x, y);
        self.add_forces(&self.pushed, 0, alpha, x, y);
    }

    fn flops(&self) -> u64 {
        let tilts = 6 * self.around_tilts.len() as u64;
        21 * self.around.len() as u64 + 6 * self.pushed.len() as u64 + tilts
    }
}

impl<R: Real> AdjointOperator<R> for Coupling<R> {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], _work: &mut [R]) {
        assert_product(self.shape().transposed(), x, y);
        let u = |node: u32, i: usize| match self.unknowns[node as usize][i] {
            PRESCRIBED => R::zero(),
            j => x[j as usize],
        };
        for_row_ranges(0, 3 * GRAIN, y, &|start, part| {
            for (f, g) in part.chunks_exact_mut(3).enumerate() {
                let face = &self.faces[start / 3 + f];
                let (mut jump, mut tilted) = ([R::zero(); 3], R::zero());
                let tilts = self.tilts.get(start / 3 + f);
                for a in 0..4 {
                    for i in 0..3 {
                        let du = u(face.plus[a], i) - u(face.minus[a], i);
                        jump[i] += face.node_areas[a] * du;
                        if let Some(tilts) = tilts {
                            tilted += tilts[a][i] * du;
                        }
                    }
                }
                g[0] += alpha * tilted;
                for (g_k, e) in g.iter_mut().zip(&face.frame) {
                    *g_k += alpha * (e[0] * jump[0] + e[1] * jump[1] + e[2] * jump[2]);
                }
            }
        });
    }

    fn adjoint_flops(&self) -> u64 {
        // jumps of four pairs of nodes, their components in the frame of the face
        57 * self.faces.len() as u64 + 26 * self.tilts.len() as u64
    }
}
