//! The fluid in fractures, what lets it through and what drives it.

use super::Directed;
use crate::contact::ContactState;
use crate::mesh::{FractureFace, HexMesh};

/// How a fracture takes fluid up and lets it through.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// C_f0, that of the closed fracture, a geometric mean where it depends on the direction [m³].
    pub conductivity: f64,
    /// How it depends on the direction, if it does.
    pub directed: Option<Directed>,
    /// Volume taken up per area and pressure, whatever the state [m/Pa].
    pub storage: f64,
    /// Pressure before anything flows, at the level [`Fluid::reference`] [Pa].
    pub initial_pressure: f64,
}

/// Where fluid comes in.
#[derive(Clone, Debug, PartialEq)]
pub enum Place {
    /// Faces, by number.
    Faces(Vec<u32>),
    /// Edges of faces, by their end nodes before fractures split them, the lower one first.
    Edges(Vec<[u32; 2]>),
}

/// What is given there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Given {
    /// Volume per time, that of all its faces together, shared by area [m³/s].
    Rate(f64),
    /// Pressure [Pa].
    Pressure(f64),
}

/// A rate or a pressure at a place, with a history.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// Where.
    pub place: Place,
    /// What, at the factor 1 of its history.
    pub given: Given,
    /// Level z at which a pressure holds, in equilibrium with the weight of the fluid above and below; none: it is the same everywhere [m].
    pub level: Option<f64>,
    /// Number of its history.
    pub history: usize,
}

/// The fluid of a scene; every fracture carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fluid {
    /// Dynamic viscosity μ [Pa s].
    pub viscosity: f64,
    /// c_f [1/Pa].
    pub compressibility: f64,
    /// ρ [kg/m³]; 0 leaves gravity out of the flow.
    pub density: f64,
    /// Acceleration of gravity [m/s²].
    pub gravity: [f64; 3],
    /// Level of the initial pressures [m].
    pub reference: f64,
    /// A channel per fracture.
    pub channels: Vec<Channel>,
    /// What drives it.
    pub sources: Vec<Source>,
    /// Wells.
    pub wells: Vec<super::Well>,
}

impl Fluid {
    /// The channel of a face.
    pub fn channel(&self, face: &FractureFace) -> &Channel {
        &self.channels[usize::from(face.fracture)]
    }

    /// Where the closed conductivity of a face depends on the direction: C_f0/μ [m³/(Pa s)], and its evened corners [m].
    pub(super) fn evened(
        &self,
        face: &FractureFace,
        mesh: &HexMesh,
    ) -> Option<(f64, [[f64; 2]; 4])> {
        let channel = self.channel(face);
        let directed = channel.directed?;
        let closed = channel.conductivity / self.viscosity;
        Some((closed, directed.evened(face, mesh)))
    }

    /// `ρ g·x`: what is taken from a pressure to have the potential that drives flow [Pa].
    pub fn head(&self, x: [f64; 3]) -> f64 {
        let along: f64 = (0..3).map(|i| self.gravity[i] * x[i]).sum();
        self.density * along
    }

    /// The initial pressure of a face: in equilibrium with its own weight [Pa].
    pub fn initial_pressure(&self, face: &FractureFace) -> f64 {
        self.channel(face).initial_pressure + self.weight(face.center, Some(self.reference))
    }

    /// What the weight of the fluid adds at a point to the pressure that holds at a level; nothing without a level [Pa].
    pub fn weight(&self, [x, y, z]: [f64; 3], level: Option<f64>) -> f64 {
        level.map_or(0.0, |level| self.head([x, y, z - level]))
    }

    /// What a face adds to its closed width: g_N where open, 0 where closed [m].
    pub fn aperture(state: ContactState, gap: f64) -> f64 {
        match state {
            ContactState::Open => gap,
            ContactState::Stick | ContactState::NewSlip | ContactState::Slip => 0.0,
        }
    }

    /// `C_f = C_f0 + max(g_N, 0)³/12`, g_N where open, and its derivative by g_N [m³, m²].
    pub fn conductivity(&self, face: &FractureFace, state: ContactState, gap: f64) -> [f64; 2] {
        let wide = Self::aperture(state, gap).max(0.0);
        let closed = self.channel(face).conductivity;
        [closed + wide.powi(3) / 12.0, 0.25 * wide * wide]
    }

    /// `(12 C_f0)^⅓`: the width whose plane flow has the conductivity of the closed fracture [m].
    pub fn closed_width(&self, face: &FractureFace) -> f64 {
        (12.0 * self.channel(face).conductivity).cbrt()
    }

    /// `A (c_f w + s)`, `w = (12 C_f0)^⅓ + a`: what a face of aperture a takes up per pressure [m³/Pa].
    pub fn storage(&self, face: &FractureFace, aperture: f64) -> f64 {
        let width = self.closed_width(face) + aperture;
        face.area * (self.compressibility * width + self.channel(face).storage)
    }
}
