//! The graph that fluid flows along: faces that meet on edges.

use super::Well;
use super::well::Driven;
use crate::mesh::{FractureFace, HexMesh};
use std::ops::Range;

/// What a face lets through to one of its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arm {
    /// The face.
    pub(super) face: u32,
    /// Length of the edge over its distance from the centre of the face: `τ = C_f shape/μ`.
    pub(super) shape: f64,
}

/// An edge of the network.
#[derive(Clone, Debug, PartialEq)]
struct Edge {
    arms: Range<usize>,
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
/// # Source
/// M. Karimi-Fard, L. J. Durlofsky, K. Aziz, SPE J. 9 (2004) 227–236 (star–delta at intersections).
#[derive(Clone, Debug, PartialEq)]
pub struct Network {
    edges: Vec<Edge>,
    arms: Vec<Arm>,
}

/// An edge at given conductivities and potentials.
pub(super) struct EdgeFlow<'n> {
    pub(super) arms: &'n [Arm],
    /// τ per arm [m³/(Pa s)].
    pub(super) tau: &'n [f64],
    /// Σ τ.
    pub(super) total: f64,
    /// Φ_e where nothing comes in or goes out [Pa].
    pub(super) shut: f64,
    /// Φ_e [Pa].
    pub(super) potential: f64,
    /// Its pressure is prescribed.
    pub(super) held: bool,
    /// What comes in here, shared by τ, where the rate of a well is [m³/s].
    pub(super) inflow: f64,
    /// Number of the well that it is.
    pub(super) well: Option<usize>,
    pub(super) middle: [f64; 3],
}

impl EdgeFlow<'_> {
    /// `F_kl` of every pair of arms that is no more than one, or of an arm and the edge: `(k, l or none, weight)`.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (usize, Option<usize>, f64)> + '_ {
        let n = self.arms.len();
        let held = (0..n).filter(|_| self.held).map(|k| (k, None, self.tau[k]));
        let between = (0..n).filter(|_| !self.held).flat_map(move |k| {
            (k + 1..n).map(move |l| (k, Some(l), self.tau[k] * self.tau[l] / self.total))
        });
        held.chain(between)
    }

    /// What comes to the face of every arm by the rate of a well [m³/s]; nothing on other edges.
    pub(super) fn inflows(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let arms = self
            .arms
            .iter()
            .zip(self.tau)
            .filter(|_| self.inflow != 0.0);
        arms.map(|(arm, tau)| (arm.face as usize, self.inflow * tau / self.total))
    }
}

impl Network {
    /// The edges that faces share; `held` are those of prescribed pressure, by their end nodes before splitting.
    pub fn new(faces: &[FractureFace], mesh: &HexMesh, held: &[[u32; 2]], wells: &[Well]) -> Self {
        // (ends, face, local end)
        let mut users: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(4 * faces.len());
        for (f, face) in faces.iter().enumerate() {
            for a in 0..4 {
                users.push((ends(face, mesh, a), f as u32, a));
            }
        }
        users.sort_unstable();
        let (mut edges, mut arms) = (Vec::new(), Vec::new());
        for list in users.chunk_by(|a, b| a.0 == b.0) {
            let held = held.iter().position(|ends| *ends == list[0].0);
            if list.len() < 2 && held.is_none() {
                continue;
            }
            let [p, q] = list[0].0.map(|node| mesh.nodes[node as usize]);
            let first = arms.len();
            arms.extend(list.iter().map(|(_, f, _)| Arm {
                face: *f,
                shape: shape(faces[*f as usize].center, [p, q]),
            }));
            edges.push(Edge {
                arms: first..arms.len(),
                middle: std::array::from_fn(|i| 0.5 * (p[i] + q[i])),
                held,
                well: None,
            });
        }
        for (number, well) in wells.iter().enumerate() {
            let first = arms.len();
            let cuts = well.cuts.iter();
            arms.extend(cuts.map(|&(face, shape)| Arm { face, shape }));
            edges.push(Edge {
                arms: first..arms.len(),
                middle: well.head,
                held: None,
                well: Some(number),
            });
        }
        Self { edges, arms }
    }

    /// Faces of every edge, one list after the other.
    pub(super) fn meetings(&self) -> impl Iterator<Item = &[Arm]> {
        self.edges.iter().map(|edge| &self.arms[edge.arms.clone()])
    }

    /// Faces beside an edge of prescribed pressure.
    pub(super) fn held_edge_faces(&self) -> impl Iterator<Item = usize> + '_ {
        let held = self.edges.iter().filter(|edge| edge.held.is_some());
        held.flat_map(|edge| &self.arms[edge.arms.clone()])
            .map(|arm| arm.face as usize)
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

    /// Visits the edges at conductivities over viscosity per face [m³/(Pa s)], potentials per face [Pa].
    pub(super) fn visit(
        &self,
        mobility: &[f64],
        potential: &[f64],
        driven: &Driven,
        mut visit: impl FnMut(&EdgeFlow<'_>),
    ) {
        let mut tau = Vec::new();
        for edge in &self.edges {
            let arms = &self.arms[edge.arms.clone()];
            tau.clear();
            tau.extend(
                arms.iter()
                    .map(|arm| mobility[arm.face as usize] * arm.shape),
            );
            let total: f64 = tau.iter().sum();
            // relative to the first, so that equal potentials stay equal
            let first = potential[arms[0].face as usize];
            let above = |(arm, tau): (&Arm, &f64)| tau * (potential[arm.face as usize] - first);
            let mean = first + arms.iter().zip(&tau).map(above).sum::<f64>() / total;
            let (potential, held) = match (edge.held, edge.well) {
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
                potential,
                held,
                inflow,
                well: edge.well,
                middle: edge.middle,
            });
        }
    }
}

/// End nodes, before splitting, of local edge a of a face, the lower one first.
pub(crate) fn ends(face: &FractureFace, mesh: &HexMesh, a: usize) -> [u32; 2] {
    let nodes = [face.minus.nodes[a], face.minus.nodes[(a + 1) % 4]];
    let mut ends = nodes.map(|node| mesh.origin[node as usize]);
    ends.sort_unstable();
    ends
}

/// `ℓ/d`: length of an edge over the distance of a point from its line.
fn shape(center: [f64; 3], [p, q]: [[f64; 3]; 2]) -> f64 {
    let along: [f64; 3] = std::array::from_fn(|i| q[i] - p[i]);
    let to: [f64; 3] = std::array::from_fn(|i| center[i] - p[i]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let length = dot(along, along).sqrt();
    let share = dot(to, along) / dot(along, along);
    let off: [f64; 3] = std::array::from_fn(|i| to[i] - share * along[i]);
    length / dot(off, off).sqrt()
}
