//! Flow around a vertex at which faces that are no rectangles meet.

use super::Fluid;
use super::network::{Arm, ends};
use crate::mesh::{FractureFace, HexMesh};
use std::cell::OnceCell;
use std::ops::Range;

/// How far the foot of the centre of a face on an edge may be from the middle of the edge where two-point fluxes are exact, over its
/// distance: the rounding of coordinates that are some 1e7 times a cell. Unit: 1.
const FOOT: f64 = 1e-8;

/// Least dissipation in a corner, that in a parallelogram with the same half-edges being 1: what keeps flow from going up the potential.
/// Corners of random convex quadrilaterals that lean by 60° and have sides of one length, each node moved by up to a fifth of them, have more
/// but for one in a thousand. Unit: 1.
pub(super) const LEAST: f64 = 0.01;

/// A quarter of a face at a vertex.
#[derive(Clone, Debug, PartialEq)]
struct Corner {
    face: usize,
    /// Half-edges that it has there.
    halves: [usize; 2],
    /// W. Unit: 1.
    by: [[f64; 2]; 2],
    /// `C_f0/μ (Ŵ − W)` where the closed conductivity depends on the direction [m³/(Pa s)].
    directed: Option<[[f64; 2]; 2]>,
}

impl Corner {
    /// `λ W`, with the direction of the closed conductivity [m³/(Pa s)].
    fn at(&self, mobility: &[f64]) -> [[f64; 2]; 2] {
        let directed = self.directed.unwrap_or_default();
        let entry = |i: usize, j: usize| mobility[self.face] * self.by[i][j] + directed[i][j];
        [0, 1].map(|i| [0, 1].map(|j| entry(i, j)))
    }

    /// Sum of a row of it [m³/(Pa s)].
    fn whole(&self, mobility: &[f64], side: usize) -> f64 {
        let [a, b] = self.at(mobility)[side];
        a + b
    }
}

/// The half of an edge that ends in a vertex.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Half {
    /// Its edge, where anything flows across it.
    pub(super) edge: Option<usize>,
    pub(super) arms: Range<usize>,
}

/// The corners of all faces that meet at a vertex. Each half-edge has a potential π of its own in the middle of the edge, common to all of
/// its arms, so that each corner k has an even gradient, exact where the potential is linear:
/// ```text
/// F_ki = λ_k Σ_j W_ij (Φ_k − π_j)      W_ij = N_i·ν_j      ν_j·(x_l − x_k) = δ_jl      λ = C_f/μ
/// ```
/// with the outward normal N_i as long as the half-edge, its middle x_j and the centre x_k of the face. What the arms of a half-edge bring
/// adds to nothing, which eliminates π. W is symmetric in parallelograms, and diagonal in rectangles.
///
/// Where the closed conductivity depends on the direction, Ŵ of the evened corners takes the place of W in its share C_f0 of C_f:
/// `λ W + C_f0/μ (Ŵ − W)`.
///
/// A flow that loses energy in every corner does so in all, whatever the conductivities. In corners of faces that are flat and far from
/// parallelograms W does not, and as little as it takes of `P_ij = N_i·N_j/‖N_1 × N_2‖`, the W of the parallelogram of the half-edges, comes
/// in; there linear potentials are not exact.
///
/// # Cost
/// A dense solve with as many unknowns as edges meet at the vertex.
///
/// # Source
/// I. Aavatsmark, Comput. Geosci. 6 (2002) 405–432 (O-method); T. H. Sandve, I. Berre, J. M. Nordbotten, J. Comput. Phys. 231 (2012)
/// 3784–3800 (junctions).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Vertex {
    corners: Vec<Corner>,
    pub(super) halves: Vec<Half>,
    /// Arms of half-edges, one list after the other.
    pub(super) arms: Vec<Arm>,
    /// Corner of every arm, and which of the two half-edges of that corner it is.
    sides: Vec<(usize, usize)>,
}

/// A vertex at given mobilities and potentials.
pub(super) struct Around<'v> {
    vertex: &'v Vertex,
    mobility: &'v [f64],
    potential: &'v [f64],
    /// What potentials are relative to, so that equal ones stay equal [Pa].
    base: f64,
    /// π per half-edge, relative to the base [Pa].
    halves: Vec<f64>,
    /// Half-edges whose potential is prescribed.
    held: Vec<bool>,
    /// `W (Φ − π)` per arm [Pa].
    driven: Vec<f64>,
    slopes: OnceCell<Slopes>,
}

/// Derivatives of the flux of every arm, a row of as many entries as corners for each.
pub(super) struct Slopes {
    /// By the potential of the face of a corner [m³/(Pa s)].
    pub(super) potential: Vec<f64>,
    /// By its mobility [Pa].
    pub(super) mobility: Vec<f64>,
}

/// Corners of a face in its plane, relative to its centre [m].
pub(super) fn flat(face: &FractureFace, mesh: &HexMesh) -> [[f64; 2]; 4] {
    let [_, t1, t2] = face.frame;
    face.minus.nodes.map(|node| {
        let x = mesh.nodes[node as usize];
        [t1, t2].map(|t| (0..3).map(|i| (x[i] - face.center[i]) * t[i]).sum())
    })
}

fn middle(p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
    [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
}

/// Whether the normal through the centre of a face with these corners meets an edge beside its middle, for each of its edges.
pub(super) fn leans(x: [[f64; 2]; 4]) -> [bool; 4] {
    [0, 1, 2, 3].map(|a: usize| {
        let (p, q) = (x[a], x[(a + 1) % 4]);
        let (along, to) = ([q[0] - p[0], q[1] - p[1]], middle(p, q));
        let beside = along[0] * to[0] + along[1] * to[1];
        let above = along[0] * to[1] - along[1] * to[0];
        beside.abs() > FOOT * above.abs()
    })
}

/// W of the corner a of a face for which linear potentials are exact, and the normals N, the edge from there to the next corner first.
pub(super) fn exact(x: [[f64; 2]; 4], a: usize) -> ([[f64; 2]; 2], [[f64; 2]; 2]) {
    let (v, next, last) = (x[a], x[(a + 1) % 4], x[(a + 3) % 4]);
    let outward = |p: [f64; 2], q: [f64; 2]| [0.5 * (q[1] - p[1]), 0.5 * (p[0] - q[0])];
    let normals = [outward(v, next), outward(last, v)];
    let [s, t] = [middle(v, next), middle(last, v)];
    let det = s[0] * t[1] - s[1] * t[0];
    let dual = [[t[1] / det, -t[0] / det], [-s[1] / det, s[0] / det]];
    let w = normals.map(|n| dual.map(|d| n[0] * d[0] + n[1] * d[1]));
    (w, normals)
}

/// P, and the least κ with `xᵀW x = κ xᵀP x`: what of the dissipation of a parallelogram there is left. Unit: 1.
pub(super) fn dissipation(w: [[f64; 2]; 2], [n, m]: [[f64; 2]; 2]) -> ([[f64; 2]; 2], f64) {
    let area = (n[0] * m[1] - n[1] * m[0]).abs();
    let dot = |a: [f64; 2], b: [f64; 2]| (a[0] * b[0] + a[1] * b[1]) / area;
    let p = [[dot(n, n), dot(n, m)], [dot(m, n), dot(m, m)]];
    // det (W − κ P) = 0 of the symmetric part; det P = 1
    let off = 0.5 * (w[0][1] + w[1][0]);
    let half = 0.5 * (w[0][0] * p[1][1] + w[1][1] * p[0][0]) - off * p[0][1];
    let det = w[0][0] * w[1][1] - off * off;
    (p, half - (half * half - det).max(0.0).sqrt())
}

/// W of the corner a of a face.
fn weights(x: [[f64; 2]; 4], a: usize) -> [[f64; 2]; 2] {
    let (w, normals) = exact(x, a);
    let (p, least) = dissipation(w, normals);
    if least >= LEAST {
        return w;
    }
    let share = (LEAST - least) / (1.0 - least);
    [0, 1].map(|i| [0, 1].map(|j: usize| w[i][j] + share * (p[i][j] - w[i][j])))
}

impl Vertex {
    /// Of the corners `(face, local node)` that meet; `edge` is the number of the edge with these end nodes.
    pub(super) fn new(
        meeting: &[(u32, usize)],
        faces: &[FractureFace],
        (fluid, mesh): (&Fluid, &HexMesh),
        edge: impl Fn([u32; 2]) -> Option<usize>,
    ) -> Self {
        // (ends, corner, side)
        let mut users = Vec::new();
        let mut corners = Vec::new();
        for (corner, &(f, a)) in meeting.iter().enumerate() {
            let face = &faces[f as usize];
            users.push((ends(face, mesh, a), corner, 0));
            users.push((ends(face, mesh, (a + 3) % 4), corner, 1));
            let by = weights(flat(face, mesh), a);
            corners.push(Corner {
                face: f as usize,
                halves: [0; 2],
                by,
                directed: fluid.evened(face, mesh).map(|(closed, evened)| {
                    let evened = weights(evened, a);
                    [0, 1].map(|i: usize| [0, 1].map(|j: usize| closed * (evened[i][j] - by[i][j])))
                }),
            });
        }
        users.sort_unstable();
        let (mut halves, mut arms, mut sides) = (Vec::new(), Vec::new(), Vec::new());
        for list in users.chunk_by(|a, b| a.0 == b.0) {
            let first = arms.len();
            for &(_, corner, side) in list {
                corners[corner].halves[side] = halves.len();
                let (f, a) = meeting[corner];
                let a = [a, (a + 3) % 4][side];
                arms.push(Arm::new((f, &faces[f as usize]), (fluid, mesh), a, 0.5));
                sides.push((corner, side));
            }
            halves.push(Half {
                edge: edge(list[0].0),
                arms: first..arms.len(),
            });
        }
        Self {
            corners,
            halves,
            arms,
            sides,
        }
    }

    /// Faces that meet.
    pub(super) fn faces(&self) -> impl Iterator<Item = u32> + '_ {
        self.corners.iter().map(|corner| corner.face as u32)
    }

    /// The potentials of half-edges, and what flows; `held` is the potential of an edge where it is prescribed.
    pub(super) fn around<'v>(
        &'v self,
        mobility: &'v [f64],
        potential: &'v [f64],
        held: impl Fn(usize) -> Option<f64>,
    ) -> Around<'v> {
        let base = potential[self.corners[0].face];
        let given = self.halves.iter().map(|half| half.edge.and_then(&held));
        let given: Vec<Option<f64>> = given.collect();
        let mut around = Around {
            vertex: self,
            mobility,
            potential,
            base,
            halves: Vec::new(),
            held: given.iter().map(Option::is_some).collect(),
            driven: Vec::new(),
            slopes: OnceCell::new(),
        };
        let mut right: Vec<f64> = given.iter().map(|p| p.map_or(0.0, |p| p - base)).collect();
        for (corner, side) in &self.sides {
            let corner = &self.corners[*corner];
            let half = corner.halves[*side];
            if !around.held[half] {
                right[half] += corner.whole(mobility, *side) * (potential[corner.face] - base);
            }
        }
        solve(&mut around.matrix(), &mut right);
        around.halves = right;
        let driven = self.sides.iter().map(|(corner, side)| {
            let corner = &self.corners[*corner];
            corner.by[*side][0] * around.above(corner, 0)
                + corner.by[*side][1] * around.above(corner, 1)
        });
        around.driven = driven.collect();
        around
    }
}

impl Around<'_> {
    /// `Σ λ W` of the half-edges, by rows; a row of the identity where the potential is prescribed.
    fn matrix(&self) -> Vec<f64> {
        let n = self.held.len();
        let mut matrix = vec![0.0; n * n];
        for (half, held) in self.held.iter().enumerate() {
            matrix[half * n + half] = if *held { 1.0 } else { 0.0 };
        }
        for corner in &self.vertex.corners {
            for (half, row) in corner.halves.iter().zip(corner.at(self.mobility)) {
                if !self.held[*half] {
                    for (other, w) in corner.halves.iter().zip(row) {
                        matrix[half * n + other] += w;
                    }
                }
            }
        }
        matrix
    }

    /// Number of corners.
    pub(super) fn corners(&self) -> usize {
        self.vertex.corners.len()
    }

    /// Face of a corner.
    pub(super) fn face(&self, corner: usize) -> usize {
        self.vertex.corners[corner].face
    }

    /// Potential of a half-edge [Pa].
    pub(super) fn half(&self, half: usize) -> f64 {
        self.base + self.halves[half]
    }

    /// `Φ − π` between the face of a corner and its half-edge j [Pa].
    fn above(&self, corner: &Corner, j: usize) -> f64 {
        self.potential[corner.face] - self.base - self.halves[corner.halves[j]]
    }

    /// The drop of potential that would drive the flux of an arm if it was a two-point one, and the sum of what rounds in it [Pa].
    pub(super) fn drop(&self, arm: usize) -> [f64; 2] {
        let (corner, side) = self.vertex.sides[arm];
        let corner = &self.vertex.corners[corner];
        let whole = self.vertex.arms[arm].tau(self.mobility);
        let by = corner.at(self.mobility)[side];
        let flux = |j: usize| by[j] * self.above(corner, j);
        let sizes = |j: usize| {
            by[j].abs() * (self.potential[corner.face].abs() + self.half(corner.halves[j]).abs())
        };
        [(flux(0) + flux(1)) / whole, (sizes(0) + sizes(1)) / whole]
    }

    /// Derivatives of the fluxes: with π eliminated, `dF = ∂F − λ W A⁻¹ Σ ∂F` over the arms of each half-edge, ∂ at a given π.
    pub(super) fn slopes(&self) -> &Slopes {
        self.slopes.get_or_init(|| {
            let (n, count) = (self.held.len(), self.corners());
            let sides = &self.vertex.sides;
            let apart = |arm: usize| {
                let (corner, side) = sides[arm];
                let corner = &self.vertex.corners[corner];
                [corner.whole(self.mobility, side), self.driven[arm]]
            };
            // potentials of half-edges by potentials, then by mobilities
            let mut right = vec![0.0; n * 2 * count];
            for (arm, (corner, side)) in sides.iter().enumerate() {
                let half = self.vertex.corners[*corner].halves[*side];
                if !self.held[half] {
                    for (k, value) in apart(arm).into_iter().enumerate() {
                        right[(half * 2 + k) * count + corner] += value;
                    }
                }
            }
            solve(&mut self.matrix(), &mut right);
            let rows = |k: usize| {
                let mut slopes = Vec::with_capacity(sides.len() * count);
                for (arm, (corner, side)) in sides.iter().enumerate() {
                    let own = &self.vertex.corners[*corner];
                    let by = own.at(self.mobility)[*side];
                    for column in 0..count {
                        let of = |j: usize| by[j] * right[(own.halves[j] * 2 + k) * count + column];
                        let own = if column == *corner {
                            apart(arm)[k]
                        } else {
                            0.0
                        };
                        slopes.push(own - (of(0) + of(1)));
                    }
                }
                slopes
            };
            Slopes {
                potential: rows(0),
                mobility: rows(1),
            }
        })
    }
}

/// `b ← A⁻¹ b` for columns b that lie side by side in rows, by elimination with rows scaled and exchanged.
fn solve(a: &mut [f64], b: &mut [f64]) {
    let n = a.len().isqrt();
    let m = b.len() / n;
    for i in 0..n {
        let size: f64 = a[i * n..][..n].iter().map(|v| v.abs()).sum();
        a[i * n..][..n].iter_mut().for_each(|v| *v /= size);
        b[i * m..][..m].iter_mut().for_each(|v| *v /= size);
    }
    for k in 0..n {
        let mut pivot = k;
        for i in k + 1..n {
            if a[i * n + k].abs() > a[pivot * n + k].abs() {
                pivot = i;
            }
        }
        if pivot != k {
            (0..n).for_each(|j| a.swap(k * n + j, pivot * n + j));
            (0..m).for_each(|j| b.swap(k * m + j, pivot * m + j));
        }
        for i in k + 1..n {
            let factor = a[i * n + k] / a[k * n + k];
            if factor != 0.0 {
                (k..n).for_each(|j| a[i * n + j] -= factor * a[k * n + j]);
                (0..m).for_each(|j| b[i * m + j] -= factor * b[k * m + j]);
            }
        }
    }
    for k in (0..n).rev() {
        for j in 0..m {
            let known: f64 = (k + 1..n).map(|l| a[k * n + l] * b[l * m + j]).sum();
            b[k * m + j] = (b[k * m + j] - known) / a[k * n + k];
        }
    }
}
