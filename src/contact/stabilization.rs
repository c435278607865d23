//! The jump stabilization H that balances the checkerboard modes of piecewise-constant tractions.

mod interfaces;
mod junctions;
mod lengths;
mod turned;

use super::ContactState;
use crate::elasticity::Elastic;
use crate::mesh::{FaceSide, FractureEdge, FractureFace, FractureMesh, HexMesh, Incidence};
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

pub use interfaces::{Interfaces, Rocks};
pub use junctions::Junctions;
pub use lengths::{Lengths, Side, side_stiffness};
use lengths::{Tensor, inverse};
use turned::in_one_plane;

/// `H(μ, t) = Σ_e [[μ]]_e · Y⁽ᵉ⁾ · [[t]]_e` over the inner edges e of every fracture.
///
/// With K, L the faces of an edge, F ∈ {K, L}, side ∈ {−, +}, and elements as prisms of depth d over the edges a, b of their faces:
/// ```text
/// k_{F,side} = s E/((1+ν)(1−2ν)) (2/9)(2−3ν) A_F d G       G = (a aᵀ + b bᵀ + d² n nᵀ)⁻¹: diag(1/h_j²) of a brick
/// Y          = Σ_side (k_{K,side} + k_{L,side})⁻¹ · Σ_{a ∈ the 2 edge nodes} A_{K,a} A_{L,a}        A_{K,a} = ∫_K N_a dS
/// H         += [ R_K Y R_Kᵀ  −R_K Y R_Lᵀ ; −R_L Y R_Kᵀ  R_L Y R_Lᵀ ]        rows of R_F: the frame of F, turned into one plane
/// ```
/// On a planar fracture R_K = R_L, which is the published form. Across a bend both frames are turned by the shortest way to the normal
/// half-way between theirs, so that a normal traction is compared with a normal one: a pressure all round is penalised nowhere. An element is as deep as its volume says, or as its face is wide where that is more
/// ([`Lengths::Deep`]). The published weights ([`Lengths::Box`]) are those of the bounding box, V and diag(1/h_j²), which are the
/// same for bricks along the axes that are no thinner; elsewhere they depend on how the body is turned. What becomes of edges at which fractures meet
/// say [`Junctions`], of those at which materials do [`Interfaces`].
///
/// # Shape
/// (3 · faces) × (3 · faces), symmetric positive semi-definite; kernel: constants on each plane fracture, or on each of its parts between junctions
/// and interfaces.
/// # Units
/// m³/Pa.
/// # Source
/// Form: M. Ferronato, SNA'25 lecture (Franceschini et al. 2022a). Scaling: open implementations of the authors, s = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JumpStabilization {
    /// Dimensionless factor s on the stiffness; 1 balances the checkerboard exactly on uniform cubes.
    pub scale: f64,
    /// What k is made of.
    pub lengths: Lengths,
    /// Edges at which fractures meet.
    pub junctions: Junctions,
    /// Edges at which materials meet.
    pub interfaces: Interfaces,
}

impl JumpStabilization {
    /// The published weights, for what is held against published numbers.
    pub const PUBLISHED: Self = Self {
        scale: 1.0,
        lengths: Lengths::Box,
        junctions: Junctions::Apart,
        interfaces: Interfaces::Joined,
    };
}

impl Default for JumpStabilization {
    fn default() -> Self {
        Self {
            scale: 1.0,
            lengths: Lengths::default(),
            junctions: Junctions::default(),
            interfaces: Interfaces::default(),
        }
    }
}

impl JumpStabilization {
    /// Assembles H for all faces in stick.
    pub fn assemble(
        &self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        rocks: Rocks<'_>,
    ) -> SparseMatrix<f64> {
        self.assemble_for(mesh, fractures, rocks, |_| ContactState::Stick)
    }

    /// Assembles H for faces in given states: an edge couples the components that both of its faces constrain (all
    /// three between sticking faces, the normal one beside a slipping face, none beside an open face; at junctions as [`Junctions`] say).
    ///
    /// H stays symmetric positive semi-definite, and on a plane fracture it penalises no constant.
    pub fn assemble_for(
        &self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        rocks: Rocks<'_>,
        state: impl Fn(usize) -> ContactState + Sync,
    ) -> SparseMatrix<f64> {
        let faces = &fractures.faces;
        let beside = self.beside(mesh, faces, rocks.elastic);
        let mut edges: Vec<(&FractureEdge, &[u32])> = self.junctions.edges(fractures).collect();
        let acts = self.interfaces.acts(mesh, fractures, rocks, &edges);
        let mut acts = acts.into_iter();
        edges.retain(|_| acts.next().unwrap_or(true));
        let edges_of = Incidence::new(faces.len(), || {
            let ends = edges.iter().enumerate();
            ends.flat_map(|(e, (edge, _))| edge.faces.map(|f| (f as usize, e as u32)))
        });
        // 3×3 blocks (column face, block) of the rows of a face, by column
        let blocks_of = |f: usize| {
            let mut row: Vec<(usize, [[f64; 3]; 3])> = Vec::with_capacity(8);
            for edge in edges_of.row(f) {
                let (edge, others) = edges[*edge as usize];
                let ends = edge.faces.map(|f| f as usize);
                let shared = ends.map(|f| state(f).constrained());
                let through = others.iter().all(|f| state(*f as usize).constrained() == 3);
                let shared = if through { shared[0].min(shared[1]) } else { 0 };
                let y = self.weight(edge, fractures, &beside);
                let frames = in_one_plane(ends.map(|f| &faces[f]));
                let frame = |g: usize| &frames[usize::from(g == ends[1])];
                for g in ends {
                    let sign = if f == g { 1.0 } else { -1.0 };
                    let [r_f, r_g] = [f, g].map(frame);
                    let place = row.iter().position(|(column, _)| *column == g);
                    let place = place.unwrap_or_else(|| {
                        row.push((g, [[0.0; 3]; 3]));
                        row.len() - 1
                    });
                    for k in 0..shared {
                        for l in 0..shared {
                            let value = between(r_f[k], y, r_g[l]);
                            row[place].1[k][l] += sign * value;
                        }
                    }
                }
            }
            row.sort_unstable_by_key(|(column, _)| *column);
            row
        };
        let tasks: Vec<Rows> = (0..faces.len().div_ceil(PER_TASK))
            .into_par_iter()
            .map(|task| {
                let mut rows = Rows::default();
                let first = task * PER_TASK;
                for f in first..faces.len().min(first + PER_TASK) {
                    rows.push(&blocks_of(f));
                }
                rows
            })
            .collect();
        let n = 3 * faces.len();
        let mut h = Rows::default();
        let nnz = tasks.iter().map(|rows| rows.values.len()).sum();
        h.lengths.reserve_exact(n);
        h.columns.reserve_exact(nnz);
        h.values.reserve_exact(nnz);
        for rows in tasks {
            h.lengths.extend(rows.lengths);
            h.columns.extend(rows.columns);
            h.values.extend(rows.values);
        }
        let mut offsets = vec![0; n + 1];
        for (row, length) in h.lengths.iter().enumerate() {
            offsets[row + 1] = offsets[row] + usize::from(*length);
        }
        SparseMatrix::new((n, n), offsets, h.columns, h.values)
    }
}

/// Faces of one task.
const PER_TASK: usize = 1024;

/// Consecutive rows without stored zeros.
#[derive(Debug, Default)]
struct Rows {
    lengths: Vec<u16>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Rows {
    /// Appends the three rows of a face, blocks by increasing column.
    fn push(&mut self, blocks: &[(usize, [[f64; 3]; 3])]) {
        for k in 0..3 {
            let before = self.values.len();
            for (face, block) in blocks {
                for (l, value) in block[k].iter().enumerate().filter(|(_, v)| **v != 0.0) {
                    self.columns.push((3 * face + l) as u32);
                    self.values.push(*value);
                }
            }
            self.lengths.push((self.values.len() - before) as u16);
        }
    }
}

/// An element beside a face.
struct Beside {
    material: Elastic,
    side: Side,
}

impl JumpStabilization {
    /// The elements beside every face.
    fn beside(
        &self,
        mesh: &HexMesh,
        faces: &[FractureFace],
        materials: &[Elastic],
    ) -> Vec<[Beside; 2]> {
        faces
            .par_iter()
            .with_min_len(PER_TASK)
            .map(|face| {
                [face.minus, face.plus].map(|side| {
                    let element = side.element as usize;
                    Beside {
                        material: materials[usize::from(mesh.regions[element])],
                        side: match self.lengths {
                            Lengths::Box => Side::boxed(mesh, element),
                            Lengths::Deep => Side::deep(mesh, element, face),
                        },
                    }
                })
            })
            .collect()
    }

    /// Y⁽ᵉ⁾ of every inner edge, in the order of `fractures.edges` [m³/Pa].
    pub fn edge_weights(
        &self,
        mesh: &HexMesh,
        fractures: &FractureMesh,
        materials: &[Elastic],
    ) -> Vec<[[f64; 3]; 3]> {
        let beside = self.beside(mesh, &fractures.faces, materials);
        let edges = fractures.edges.iter();
        edges
            .map(|edge| self.weight(edge, fractures, &beside))
            .collect()
    }

    /// Y⁽ᵉ⁾ [m³/Pa], from `k_{F,side}` of both faces.
    fn weight(
        &self,
        edge: &FractureEdge,
        fractures: &FractureMesh,
        beside: &[[Beside; 2]],
    ) -> Tensor {
        let faces = edge.faces.map(|f| &fractures.faces[f as usize]);
        let areas: f64 = (0..2)
            .map(|a| {
                faces[0].node_areas[edge.nodes_k[a] as usize]
                    * faces[1].node_areas[edge.nodes_l[a] as usize]
            })
            .sum();
        let stiffness = edge.faces.map(|f| {
            let of = |b: &Beside| side_stiffness(self.scale, b.material, b.side);
            beside[f as usize].each_ref().map(of)
        });
        let [of_k, of_l] = stiffness;
        let [minus, plus] = [0, 1].map(|side: usize| inverse(sum(of_k[side], of_l[side])));
        sum(minus, plus).map(|row| row.map(|y| y * areas))
    }
}

fn sum(a: Tensor, b: Tensor) -> Tensor {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] + b[i][j]))
}

/// `aᵀ y b`.
pub(crate) fn between(a: [f64; 3], y: Tensor, b: [f64; 3]) -> f64 {
    let terms = (0..9).map(|k| a[k / 3] * y[k / 3][k % 3] * b[k % 3]);
    terms.sum()
}

/// `ω = Σ_a A_a²/A_f · Σ_side 1/k_n` [m/Pa], `k_n = nᵀk n`: the mean jump of a face under a unit normal traction
/// when each of its corner nodes moves against one element alone.
pub fn face_compliance(mesh: &HexMesh, materials: &[Elastic], face: &FractureFace) -> f64 {
    let squares: f64 = face.node_areas.iter().map(|a| a * a).sum();
    let compliance = |side: FaceSide| {
        let element = side.element as usize;
        let material = materials[mesh.regions[element] as usize];
        let k = side_stiffness(1.0, material, Side::beside(mesh, element, face));
        let n = face.frame[0];
        1.0 / between(n, k, n)
    };
    squares / face.area * (compliance(face.minus) + compliance(face.plus))
}

#[cfg(test)]
mod tests;
