//! The balance of fluid volume on fracture faces over a step, and its derivatives.

use super::network::Network;
use super::pattern::pattern;
use super::reservoir::Reservoir;
use super::sealed::connected;
use super::well::Driven;
use super::{FlowPoint, FlowStep, Fluid, Given, Place, Well, WellGiven};
use crate::contact::{ContactState, JumpStabilization, between, face_compliance};
use crate::elasticity::Elastic;
use crate::mesh::{FractureEdge, FractureFace, FractureMesh, HexMesh};
use fracas_operators::sparse::{Pattern, SparseMatrix};
use fracas_operators::vector::norm2;
use std::sync::OnceLock;

/// Roundings of a sum that are no error. Unit: 1.
pub(super) const ROUNDINGS: f64 = 32.0;

/// Backward Euler per face, volumes at the density of p = 0 [m³]:
/// ```text
/// R = A (a − a₀) + A c_f (p w − p₀ w₀) + A s (p − p₀) + Δt Σ F − ∫ q dt + Σ_e Y_e ([[p]]_e − [[p₀]]_e)
/// a = g_N where open, 0 where closed      w = (12 C_f0)^⅓ + a      F of the network at p, C_f(a)
/// ```
/// Y, between open faces alone, is the pressure jump stabilization: `nᵀ diag(inv) n Σ A_{K,a} A_{L,a}` of the weights of H, on what the
/// pressure does in the step, so that a steady pressure is left alone. It moves volume from face to face and loses none. A face of
/// prescribed pressure has `ω A (p − P)` as its row.
///
/// A sealed part of closed faces has a pressure up to a constant. The row of its first face then holds the mean where it was,
/// `R + ω Σ A (p − p₀)`: the limit of a storage that goes to nothing. Whatever must open, opens ([`Sealed`](super::Sealed)). A well at its
/// limit gives the part its pressure instead. A closed part that stores something, but so little that rounding loses it beside what flows
/// in the step, has its balance as a whole there, `Σ R`, in which fluxes cancel.
///
/// # Source
/// M. Ferronato, SNA'25 lecture (conductivity, two-point fluxes, stabilization of the same form as that of tractions); increments in
/// the stabilization and the rows of sealed parts are choices of this project.
#[derive(Clone, Debug)]
pub struct Balance<'a> {
    fluid: &'a Fluid,
    pub(super) faces: &'a [FractureFace],
    edges: &'a [FractureEdge],
    pub(super) network: Network,
    /// Middles of the edges of prescribed pressure, in their order [m].
    pub(super) held_middles: Vec<[f64; 3]>,
    /// Y per inner edge [m³/Pa].
    weights: Vec<f64>,
    /// ω per face [m/Pa].
    pub(super) compliance: Vec<f64>,
    /// Connected parts.
    pub(super) parts: Vec<Vec<u32>>,
    /// Those that are sealed where all their faces are closed: none of their faces stores fluid or has a pressure of its own.
    pub(super) closable: Vec<Vec<u32>>,
    /// Those that have a pressure by what their faces store alone where all are closed.
    pub(super) reservoirs: Vec<Reservoir>,
    pattern: Pattern,
    /// That with the rows of reservoirs, made for the first step in which one drowns.
    whole_pattern: OnceLock<Pattern>,
}

/// Derivatives of the balance.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowTangent {
    /// T = ∂R/∂p [m³/Pa].
    pub t: SparseMatrix<f64>,
    /// ∂R/∂g_N, columns of closed faces 0 [m²].
    pub by_gap: SparseMatrix<f64>,
}

impl<'a> Balance<'a> {
    /// All that depends on neither states nor time.
    pub fn new(
        fluid: &'a Fluid,
        mesh: &HexMesh,
        fractures: &'a FractureMesh,
        materials: &[Elastic],
        stabilization: JumpStabilization,
    ) -> Self {
        let faces = &fractures.faces;
        let held_edges = fluid
            .sources
            .iter()
            .filter_map(|s| match (&s.place, s.given) {
                (Place::Edges(edges), Given::Pressure(_)) => Some(edges.as_slice()),
                _ => None,
            });
        let held_edges: Vec<[u32; 2]> = held_edges.flatten().copied().collect();
        let network = Network::new(faces, mesh, &held_edges, fluid);
        let mut held_middles = vec![[f64::NAN; 3]; held_edges.len()];
        for (number, middle) in network.held_middles() {
            held_middles[number] = middle;
        }
        let given = given_faces(fluid, &network, faces.len());
        let meetings = network.meetings();
        let meetings = meetings.map(|arms| arms.iter().map(|arm| arm.face).collect());
        let parts = connected(faces.len(), meetings);
        let stores = |f: u32| fluid.storage(&faces[f as usize], 0.0) > 0.0;
        let alone = |part: &&Vec<u32>| !part.iter().any(|f| given[*f as usize]);
        let alone = parts.iter().filter(alone).cloned();
        let (storing, closable): (Vec<_>, Vec<_>) =
            alone.partition(|part| part.iter().any(|f| stores(*f)));
        let reservoirs = Reservoir::among(
            storing.into_iter(),
            (fluid, faces),
            (&network, held_middles.len()),
        );
        let mut sealed = closable.iter().map(Vec::as_slice);
        let pattern = pattern(faces.len(), &network, &fractures.edges, &mut sealed);
        let n = |face: u32| faces[face as usize].frame[0];
        let weights = stabilization.edge_weights(mesh, fractures, materials);
        let normal = |(edge, y): (&FractureEdge, [[f64; 3]; 3])| {
            let along = |n: [f64; 3]| between(n, y, n);
            0.5 * (along(n(edge.faces[0])) + along(n(edge.faces[1])))
        };
        Self {
            weights: fractures.edges.iter().zip(weights).map(normal).collect(),
            pattern,
            whole_pattern: OnceLock::new(),
            compliance: faces
                .iter()
                .map(|face| face_compliance(mesh, materials, face))
                .collect(),
            edges: &fractures.edges,
            fluid,
            faces,
            network,
            held_middles,
            parts,
            closable,
            reservoirs,
        }
    }

    /// The fluid.
    pub fn fluid(&self) -> &'a Fluid {
        self.fluid
    }

    /// C_f/μ per face and its derivative by g_N [m³/(Pa s), m²/(Pa s)].
    pub(super) fn mobility(&self, states: &[ContactState], jumps: &[f64]) -> [Vec<f64>; 2] {
        let of = |f: usize| {
            let both = self
                .fluid
                .conductivity(&self.faces[f], states[f], jumps[3 * f]);
            both.map(|c| c / self.fluid.viscosity)
        };
        let both: Vec<[f64; 2]> = (0..self.faces.len()).map(of).collect();
        [0, 1].map(|k: usize| both.iter().map(|m| m[k]).collect())
    }

    /// `p − ρ g·x` per face, per held edge and well [Pa].
    pub(super) fn potentials(&self, p: &[f64], step: &FlowStep) -> (Vec<f64>, Driven) {
        let of_face = |(face, p): (&FractureFace, &f64)| p - self.fluid.head(face.center);
        let of_edge = |(x, p): (&[f64; 3], &f64)| p - self.fluid.head(*x);
        let edges = self.held_middles.iter().zip(&step.held_edges);
        let driven = Driven {
            held: edges.map(of_edge).collect(),
            wells: step.wells.clone(),
        };
        (self.faces.iter().zip(p).map(of_face).collect(), driven)
    }

    /// Volume taken by opening, and by compression and storage, of a face [m³].
    pub(super) fn taken(&self, f: usize, a: f64, p: f64, step: &FlowStep) -> [f64; 2] {
        let face = &self.faces[f];
        let (a0, p0) = (step.aperture[f], step.pressure[f]);
        let width = self.fluid.closed_width(face);
        let pressed = self.fluid.compressibility * (p * (width + a) - p0 * (width + a0));
        let stored = self.fluid.channel(face).storage * (p - p0);
        [face.area * (a - a0), face.area * (pressed + stored)]
    }

    /// Volume that a pressure presses into a face and its storage [m³].
    pub(super) fn pressed(&self, f: usize, a: f64, p: f64) -> f64 {
        p * self.fluid.storage(&self.faces[f], a.abs())
    }

    /// The equations at normal jumps (three entries per face, as contact has them) and pressures.
    pub fn evaluate(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> FlowPoint {
        let n = self.faces.len();
        let (mut residual, mut size, mut rounding) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let [mobility, _] = self.mobility(states, jumps);
        let (potential, held) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &held, |edge| {
            for passing in edge.passing() {
                let (k, weight) = (passing.from, passing.weight);
                let flux = step.dt * weight * passing.drop;
                residual[k] += flux;
                size[k] += flux.abs();
                rounding[k] += step.dt * weight * passing.apart;
                if let Some(l) = passing.to {
                    residual[l] -= flux;
                    size[l] += flux.abs();
                    rounding[l] += step.dt * weight * passing.apart;
                }
            }
            for (k, inflow) in edge.inflows() {
                residual[k] -= step.dt * inflow;
                size[k] += step.dt * inflow.abs();
            }
        });
        // what comes through edges and from faces of prescribed pressure
        let held_faces = (0..n).filter(|f| step.held[*f].is_some());
        let through: Vec<usize> = self.network.held_faces().chain(held_faces).collect();
        let mut volume: f64 = through.iter().map(|f| size[*f]).sum();
        let unseen: f64 = through.iter().map(|f| rounding[*f]).sum();
        // what one face gives and another takes is the same number, and rounds where it is added to others
        let mut unseen = unseen + size.iter().sum::<f64>();
        for f in 0..n {
            let a = Fluid::aperture(states[f], jumps[3 * f]);
            let [opening, compression] = self.taken(f, a, p[f], step);
            let apart = self.faces[f].area * (a.abs() + step.aperture[f].abs());
            volume += apart + compression.abs() + step.injected[f].abs();
            residual[f] += opening + compression - step.injected[f];
            size[f] += opening.abs() + compression.abs() + step.injected[f].abs();
            rounding[f] += apart + step.injected[f].abs();
            // pressures are rounded themselves
            let pressed = self.pressed(f, a, p[f].abs())
                + self.pressed(f, step.aperture[f], step.pressure[f].abs());
            rounding[f] += pressed;
            unseen += pressed;
        }
        for (edge, y) in self.stabilized(states, step) {
            let [k, l] = edge.faces.map(|f| f as usize);
            let moved = y * ((p[k] - step.pressure[k]) - (p[l] - step.pressure[l]));
            residual[k] += moved;
            residual[l] -= moved;
        }
        for faces in self
            .closable
            .iter()
            .filter(|faces| self.is_sealed(faces, states, step))
        {
            let first = faces[0] as usize;
            let (mut rise, mut rounded) = (0.0, 0.0);
            for f in faces.iter().map(|f| *f as usize) {
                let area = self.faces[f].area;
                rise += area * (p[f] - step.pressure[f]);
                rounded += area * (p[f].abs() + step.pressure[f].abs());
            }
            unseen += self.compliance[first] * rounded;
            residual[first] += self.compliance[first] * rise;
            size[first] += self.compliance[first] * rise.abs();
        }
        let free = residual.iter().zip(&step.held);
        let lost: f64 = free
            .filter(|(_, held)| held.is_none())
            .map(|(r, _)| r)
            .sum();
        for part in self.drowned(states, step) {
            let (first, whole) = (part.faces[0] as usize, self.whole(part, p, step));
            residual[first] = whole.residual;
            size[first] = whole.size;
            rounding[first] = whole.rounding;
        }
        for (f, held) in step.held.iter().enumerate() {
            if let Some(held) = held {
                let weight = self.compliance[f] * self.faces[f].area;
                residual[f] = weight * (p[f] - held);
                size[f] = weight * (p[f].abs() + held.abs());
                rounding[f] = size[f];
            }
        }
        FlowPoint {
            residual,
            size: norm2(&size),
            rounding: ROUNDINGS * f64::EPSILON * norm2(&rounding),
            lost: (lost.abs() - ROUNDINGS * f64::EPSILON * unseen).max(0.0),
            volume,
        }
    }

    /// Inner edges between open faces, and those that are joined, with Y.
    pub(super) fn stabilized<'s>(
        &'s self,
        states: &'s [ContactState],
        step: &'s FlowStep,
    ) -> impl Iterator<Item = (&'a FractureEdge, f64)> + 's {
        let joined = |f: u32| step.joined.get(f as usize) == Some(&true);
        let open = move |f: u32| states[f as usize] == ContactState::Open || joined(f);
        let edges = self.edges.iter().zip(self.weights.iter().copied());
        edges.filter(move |(edge, _)| open(edge.faces[0]) && open(edge.faces[1]))
    }

    /// The pattern with the rows of reservoirs.
    fn whole_pattern(&self) -> &Pattern {
        self.whole_pattern.get_or_init(|| {
            let sealed = self.closable.iter().map(Vec::as_slice);
            let whole = self.reservoirs.iter().map(|part| part.faces.as_slice());
            let mut parts = sealed.chain(whole);
            pattern(self.faces.len(), &self.network, self.edges, &mut parts)
        })
    }

    /// Derivatives at the same point.
    pub fn tangent(
        &self,
        states: &[ContactState],
        jumps: &[f64],
        p: &[f64],
        step: &FlowStep,
    ) -> FlowTangent {
        let pattern = match self.drowned(states, step).next() {
            Some(_) => self.whole_pattern(),
            None => &self.pattern,
        };
        let mut t = vec![0.0; pattern.columns.len()];
        let mut by_gap = t.clone();
        let place = |k: usize, l: usize| pattern.place(k, l as u32);
        let free = |k: usize| step.held[k].is_none();
        let [mobility, by_width] = self.mobility(states, jumps);
        let (potential, held) = self.potentials(p, step);
        self.network.visit(&mobility, &potential, &held, |edge| {
            edge.by_potential(|k, m, value| t[place(k, m)] += step.dt * value);
            let turn = |m: usize| step.dt * by_width[m];
            edge.by_mobility(turn, |k, m, value| by_gap[place(k, m)] += value);
        });
        for (f, face) in self.faces.iter().enumerate() {
            let a = Fluid::aperture(states[f], jumps[3 * f]);
            t[place(f, f)] += self.fluid.storage(face, a);
            if states[f] == ContactState::Open {
                by_gap[place(f, f)] += face.area * (1.0 + self.fluid.compressibility * p[f]);
            }
        }
        for (edge, y) in self.stabilized(states, step) {
            let [k, l] = edge.faces.map(|f| f as usize);
            t[place(k, k)] += y;
            t[place(l, l)] += y;
            t[place(k, l)] -= y;
            t[place(l, k)] -= y;
        }
        for faces in self
            .closable
            .iter()
            .filter(|faces| self.is_sealed(faces, states, step))
        {
            let first = faces[0] as usize;
            for f in faces.iter().map(|f| *f as usize) {
                t[place(first, f)] += self.compliance[first] * self.faces[f].area;
            }
        }
        for part in self.drowned(states, step) {
            let first = part.faces[0] as usize;
            t[pattern.range(first)].fill(0.0);
            by_gap[pattern.range(first)].fill(0.0);
            for f in part.faces.iter().map(|f| *f as usize) {
                t[place(first, f)] = self.fluid.storage(&self.faces[f], 0.0);
            }
        }
        for f in (0..self.faces.len()).filter(|f| !free(*f)) {
            t[pattern.range(f)].fill(0.0);
            by_gap[pattern.range(f)].fill(0.0);
            t[place(f, f)] = self.compliance[f] * self.faces[f].area;
        }
        let matrix = |values: Vec<f64>| {
            let n = self.faces.len();
            let (offsets, columns) = (pattern.offsets.clone(), pattern.columns.clone());
            SparseMatrix::new((n, n), offsets, columns, values)
        };
        FlowTangent {
            t: matrix(t),
            by_gap: matrix(by_gap),
        }
    }
}

/// Which faces have a pressure that the scene gives: their own, that of an edge, or that of a well.
fn given_faces(fluid: &Fluid, network: &Network, n: usize) -> Vec<bool> {
    let of_source = |(place, given): (&Place, Given)| match (place, given) {
        (Place::Faces(faces), Given::Pressure(_)) => faces.clone(),
        _ => Vec::new(),
    };
    let sources = fluid.sources.iter().map(|s| (&s.place, s.given));
    let by_pressure = |w: &&Well| matches!(w.given, WellGiven::Pressure(_));
    let wells = fluid.wells.iter().filter(by_pressure);
    let mut given = vec![false; n];
    (sources.flat_map(of_source).map(|f| f as usize))
        .chain(network.held_edge_faces().map(|(_, f)| f))
        .chain(wells.flat_map(|w| w.cuts.iter().map(|(f, _)| *f as usize)))
        .for_each(|f| given[f] = true);
    given
}
