//! The graph that fluid flows along: faces that meet on edges.

use super::Fluid;
use super::edge_flow::EdgeFlow;
use super::vertex::{Vertex, flat, leans};
use super::well::Driven;
use crate::mesh::{FractureFace, HexMesh};
use std::ops::Range;

/// What a face lets through to one of its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arm {
    /// The face.
    pub(super) face: u32,
    /// Length of the edge, or of its half, over its distance from the centre of the face: `τ = C_f shape/μ + directed`.
    pub(super) shape: f64,
    /// What the direction of the closed conductivity adds, of either sign; τ stays positive [m³/(Pa s)].
    pub(super) directed: f64,
}

impl Arm {
    /// To the local edge a of a face.
    pub(super) fn new(
        (f, face): (u32, &FractureFace),
        (fluid, mesh): (&Fluid, &HexMesh),
        a: usize,
        share: f64,
    ) -> Self {
        let line = ends(face, mesh, a).map(|node| mesh.nodes[node as usize]);
        let shape = shape(face.center, line);
        let directed = fluid.evened(face, mesh).map_or(0.0, |(closed, y)| {
            let (p, q) = (y[a], y[(a + 1) % 4]);
            let (length, off) = ((q[0] - p[0]).hypot(q[1] - p[1]), p[0] * q[1] - p[1] * q[0]);
            closed * (length * length / off.abs() - shape)
        });
        Self {
            face: f,
            shape: share * shape,
            directed: share * directed,
        }
    }

    /// τ at these conductivities over viscosity per face [m³/(Pa s)].
    pub(super) fn tau(&self, mobility: &[f64]) -> f64 {
        mobility[self.face as usize] * self.shape + self.directed
    }
}

/// An edge of the network.
#[derive(Clone, Debug, PartialEq)]
struct Edge {
    /// Those of the whole edge, or of the half whose vertex leaves it two-point fluxes.
    arms: Range<usize>,
    /// False where the vertices at both ends decide on what flows.
    two_point: bool,
    middle: [f64; 3],
    /// Number of its prescribed pressure.
    held: Option<usize>,
    /// Number of the well that it is.
    well: Option<usize>,
}

/// Faces connected by the edges they share, on planes, bends and junctions of any number of faces.
///
/// With `τ_k = C_k ℓ/(μ d_k)`, d_k the distance of the centre of face k from the edge of length ℓ, the potential of the edge is that for
/// which nothing is left on it, and each pair of arms has a flux of its own (star–delta):
/// ```text
/// Φ_e = Σ τ_k Φ_k / Σ τ_k        F_kl = τ_k τ_l/(Σ τ) (Φ_k − Φ_l)        Φ = p − ρ g·x
/// ```
/// An edge of prescribed pressure has its own Φ_e and takes `τ_k (Φ_k − Φ_e)`. Nothing flows across other edges of one face.
///
/// Where the conductivity depends on the direction ([`Directed`](super::Directed)), ℓ/d of the closed face is that of its evened corners.
///
/// This is exact for linear potentials where the normals through the centres of faces meet edges in their middles, as in rectangles.
/// Elsewhere it does not converge: faces that lean by θ let 1/cos² θ times too much through. A vertex where a face is such decides on the
/// halves of edges that end there, with fluxes of all faces around it (`vertex`).
///
/// # Source
/// M. Karimi-Fard, L. J. Durlofsky, K. Aziz, SPE J. 9 (2004) 227–236 (star–delta at intersections).
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    edges: Vec<Edge>,
    arms: Vec<Arm>,
    /// Vertices where faces are no rectangles.
    vertices: Vec<Vertex>,
}

impl Network {
    /// The edges that faces share; `held` are those of prescribed pressure, by their end nodes before splitting.
    pub fn new(faces: &[FractureFace], mesh: &HexMesh, held: &[[u32; 2]], fluid: &Fluid) -> Self {
        Self::deciding(faces, mesh, held, fluid, &leaning(faces, mesh, fluid))
    }

    /// The same where these nodes decide on what flows around them, each with the faces that meet there and their local nodes.
    pub(super) fn deciding(
        faces: &[FractureFace],
        mesh: &HexMesh,
        held: &[[u32; 2]],
        fluid: &Fluid,
        nodes: &[(u32, Vec<(u32, usize)>)],
    ) -> Self {
        // (ends, face, local end)
        let mut users: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(4 * faces.len());
        for (f, face) in faces.iter().enumerate() {
            for a in 0..4 {
                users.push((ends(face, mesh, a), f as u32, a));
            }
        }
        users.sort_unstable();
        let decides = |node: &&u32| nodes.binary_search_by_key(*node, |(n, _)| *n).is_ok();
        let (mut edges, mut arms, mut keys) = (Vec::new(), Vec::new(), Vec::new());
        for list in users.chunk_by(|a, b| a.0 == b.0) {
            let held = held.iter().position(|ends| *ends == list[0].0);
            if list.len() < 2 && held.is_none() {
                continue;
            }
            let decided = list[0].0.iter().filter(decides).count();
            let share = if decided == 1 { 0.5 } else { 1.0 };
            let [p, q] = list[0].0.map(|node| mesh.nodes[node as usize]);
            let first = arms.len();
            arms.extend(list.iter().map(|(_, f, a)| {
                let face = (*f, &faces[*f as usize]);
                Arm::new(face, (fluid, mesh), *a, share)
            }));
            keys.push(list[0].0);
            edges.push(Edge {
                arms: first..arms.len(),
                two_point: decided < 2,
                middle: std::array::from_fn(|i| 0.5 * (p[i] + q[i])),
                held,
                well: None,
            });
        }
        let edge = |ends: [u32; 2]| keys.binary_search(&ends).ok();
        let vertex =
            |(_, corners): &(u32, Vec<_>)| Vertex::new(corners, faces, (fluid, mesh), edge);
        let vertices = nodes.iter().map(vertex).collect();
        for (number, well) in fluid.wells.iter().enumerate() {
            let first = arms.len();
            let cuts = well.cuts.iter();
            arms.extend(cuts.map(|&(face, shape)| Arm {
                face,
                shape,
                directed: 0.0,
            }));
            edges.push(Edge {
                arms: first..arms.len(),
                two_point: true,
                middle: well.head,
                held: None,
                well: Some(number),
            });
        }
        Self {
            edges,
            arms,
            vertices,
        }
    }

    /// Faces of every edge, one list after the other.
    pub(super) fn meetings(&self) -> impl Iterator<Item = &[Arm]> {
        self.edges.iter().map(|edge| &self.arms[edge.arms.clone()])
    }

    /// Faces of every vertex that decides on what flows.
    pub(super) fn around(&self) -> impl Iterator<Item = Vec<u32>> {
        self.vertices.iter().map(|vertex| vertex.faces().collect())
    }

    /// Faces beside an edge of prescribed pressure, each behind the number of that pressure.
    pub(super) fn held_edge_faces(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let held = |edge: &'_ Edge| edge.held.map(|number| (number, edge.arms.clone()));
        let held = self.edges.iter().filter_map(held);
        held.flat_map(|(number, arms)| {
            let face = move |arm: &Arm| (number, arm.face as usize);
            self.arms[arms].iter().map(face)
        })
    }

    /// Faces beside an edge of prescribed pressure, and those that wells cut.
    pub(super) fn held_faces(&self) -> impl Iterator<Item = usize> + '_ {
        let may_be = |edge: &&Edge| edge.held.is_some() || edge.well.is_some();
        let held = self.edges.iter().filter(may_be);
        held.flat_map(|edge| &self.arms[edge.arms.clone()])
            .map(|arm| arm.face as usize)
    }

    /// Middle of every edge of prescribed pressure, by the number of that pressure.
    pub(super) fn held_middles(&self) -> impl Iterator<Item = (usize, [f64; 3])> + '_ {
        let held = |edge: &Edge| edge.held.map(|number| (number, edge.middle));
        self.edges.iter().filter_map(held)
    }

    /// Visits the edges, and halves of those on which vertices decide, at conductivities over viscosity per face [m³/(Pa s)], potentials per face [Pa].
    pub(super) fn visit(
        &self,
        mobility: &[f64],
        potential: &[f64],
        driven: &Driven,
        mut visit: impl FnMut(&EdgeFlow<'_>),
    ) {
        let mut tau = Vec::new();
        let fill = |tau: &mut Vec<f64>, arms: &[Arm]| {
            tau.clear();
            tau.extend(arms.iter().map(|arm| arm.tau(mobility)));
        };
        for edge in self.edges.iter().filter(|edge| edge.two_point) {
            let arms = &self.arms[edge.arms.clone()];
            fill(&mut tau, arms);
            let total: f64 = tau.iter().sum();
            // relative to the first, so that equal potentials stay equal
            let first = potential[arms[0].face as usize];
            let above = |(arm, tau): (&Arm, &f64)| tau * (potential[arm.face as usize] - first);
            let mean = first + arms.iter().zip(&tau).map(above).sum::<f64>() / total;
            let (on_edge, held) = match (edge.held, edge.well) {
                (Some(number), _) => (driven.held[number], true),
                (None, Some(number)) => driven.wells[number].potential(mean, total),
                (None, None) => (mean, false),
            };
            let inflow = edge
                .well
                .map_or(0.0, |number| driven.wells[number].inflow());
            visit(&EdgeFlow {
                arms,
                tau: &tau,
                total,
                shut: mean,
                potential: on_edge,
                held,
                inflow,
                well: edge.well,
                middle: edge.middle,
                potentials: potential,
                around: None,
            });
        }
        for vertex in &self.vertices {
            let held = |edge: usize| self.edges[edge].held.map(|number| driven.held[number]);
            let around = vertex.around(mobility, potential, held);
            for (number, half) in vertex.halves.iter().enumerate() {
                let Some(edge) = half.edge else { continue };
                let arms = &vertex.arms[half.arms.clone()];
                fill(&mut tau, arms);
                visit(&EdgeFlow {
                    arms,
                    tau: &tau,
                    total: tau.iter().sum(),
                    shut: around.half(number),
                    potential: around.half(number),
                    held: self.edges[edge].held.is_some(),
                    inflow: 0.0,
                    well: None,
                    middle: self.edges[edge].middle,
                    potentials: potential,
                    around: Some((&around, half.arms.start)),
                });
            }
        }
    }
}

/// Nodes, before splitting, where faces are no rectangles, or none once evened, each with the faces that meet there and their local nodes.
fn leaning(faces: &[FractureFace], mesh: &HexMesh, fluid: &Fluid) -> Vec<(u32, Vec<(u32, usize)>)> {
    let mut places: Vec<u32> = Vec::new();
    for face in faces {
        let mut lean = leans(flat(face, mesh));
        if let Some((_, evened)) = fluid.evened(face, mesh) {
            let evened = leans(evened);
            lean = [0, 1, 2, 3].map(|a: usize| lean[a] || evened[a]);
        }
        let beside = |a: &usize| lean[*a] || lean[(a + 3) % 4];
        let node = |a: usize| mesh.origin[face.minus.nodes[a] as usize];
        places.extend((0..4).filter(beside).map(node));
    }
    places.sort_unstable();
    places.dedup();
    meeting(faces, mesh, places)
}

/// These nodes, increasing, with the faces that meet there and their local nodes.
pub(super) fn meeting(
    faces: &[FractureFace],
    mesh: &HexMesh,
    nodes: Vec<u32>,
) -> Vec<(u32, Vec<(u32, usize)>)> {
    let mut meeting: Vec<_> = nodes.into_iter().map(|n| (n, Vec::new())).collect();
    if meeting.is_empty() {
        return meeting;
    }
    for (f, face) in faces.iter().enumerate() {
        for a in 0..4 {
            let node = mesh.origin[face.minus.nodes[a] as usize];
            if let Ok(place) = meeting.binary_search_by_key(&node, |(n, _)| *n) {
                meeting[place].1.push((f as u32, a));
            }
        }
    }
    meeting
}

/// End nodes, before splitting, of local edge a of a face, the lower one first.
pub(crate) fn ends(face: &FractureFace, mesh: &HexMesh, a: usize) -> [u32; 2] {
    let nodes = [face.minus.nodes[a], face.minus.nodes[(a + 1) % 4]];
    let mut ends = nodes.map(|node| mesh.origin[node as usize]);
    ends.sort_unstable();
    ends
}

/// `ℓ/d`: length of an edge over the distance of a point from its line.
pub(super) fn shape(center: [f64; 3], [p, q]: [[f64; 3]; 2]) -> f64 {
    let along: [f64; 3] = std::array::from_fn(|i| q[i] - p[i]);
    let to: [f64; 3] = std::array::from_fn(|i| center[i] - p[i]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let length = dot(along, along).sqrt();
    let share = dot(to, along) / dot(along, along);
    let off: [f64; 3] = std::array::from_fn(|i| to[i] - share * along[i]);
    length / dot(off, off).sqrt()
}
