//! What a scene becomes: everything that assembly needs, in SI units.

use super::{
    History, Onset, PoreField, PressureFrom, Profile, SolverSection, TimeTable, WeightStress,
};
use crate::contact::Friction;
use crate::creep::Initial;
use crate::elasticity::{Constraints, Elastic, loads};
use crate::flow::Fluid;
use crate::mesh::{Audit, FractureFace, FractureMesh, HexMesh, audit};
use fracas_solvers::saddle::Racp;

/// Share of the way to the centre of an element at which a point lies in it and in no other. Unit: 1.
const INSIDE: f64 = 1e-9;

/// What pulls or presses on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pull {
    /// The same force per area everywhere, tension positive [Pa].
    Traction([f64; 3]),
    /// A pressure, against the normal of every point [Pa].
    Pressure(f64),
}

/// A constant traction or pressure on faces of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTraction {
    /// Four nodes per face, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 4]>,
    /// What it is.
    pub pull: Pull,
    /// Number of its history in [`Body::histories`].
    pub history: usize,
}

impl SurfaceTraction {
    /// Its forces on such nodes, in full numbering [N].
    pub fn forces(&self, nodes: &[[f64; 3]]) -> Vec<f64> {
        match self.pull {
            Pull::Traction(t) => loads::surface_traction(nodes, &self.faces, t),
            Pull::Pressure(p) => loads::surface_pressure(nodes, &self.faces, p),
        }
    }
}

/// Initial stress σ0(z) = constant + (z − reference) · gradient, Voigt order xx, yy, zz, xy, yz, xz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialStress {
    /// At z = reference [Pa].
    pub constant: [f64; 6],
    /// Per metre of z, upwards [Pa/m].
    pub gradient: [f64; 6],
    /// Where `constant` holds [m].
    pub reference: f64,
}

impl InitialStress {
    /// σ0 at a point [Pa].
    pub fn at(&self, x: [f64; 3]) -> [f64; 6] {
        std::array::from_fn(|i| self.constant[i] + (x[2] - self.reference) * self.gradient[i])
    }
}

/// A change of pore pressure that is the same all over a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreChange {
    /// Δp at the factor 1 of its history [Pa]; 1 Pa where the history itself counts in Pa.
    pub change: f64,
    /// Biot's coefficient α [1].
    pub biot: f64,
    /// Number of its history in [`Body::histories`].
    pub history: usize,
}

impl PoreChange {
    /// `α Δp`, by which total stress falls [Pa].
    pub fn drained(&self) -> f64 {
        self.biot * self.change
    }
}

/// A fractured body with materials, constraints and loads.
///
/// ```
/// use fracas::prelude::*;
///
/// let body = named("patch").ok_or("a scene of the gallery")?.scene()?.build()?;
/// let blocks = body.saddle_blocks(Some(body.jump_stabilization()))?;
/// assert_eq!(blocks.n_t(), 3 * body.fractures.faces.len());
/// // where the eigenvalues of M⁻¹𝒜 lie, and whether the theorems say so
/// let method = SaddleMethod::Racp(Racp::published(InnerChoice::default()));
/// let report = analyse_method(&blocks, &method, &SpectrumRequest::default(), &mut Silent)?;
/// assert_eq!(report.contained, Some(true));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Body {
    /// The mesh, split along its fractures.
    pub mesh: HexMesh,
    /// Its fractures.
    pub fractures: FractureMesh,
    /// Friction per fracture along z, where the scene gives it.
    pub friction: Vec<Option<Profile<Friction>>>,
    /// Names of the materials; `mesh.regions` indexes all lists of materials.
    pub material_names: Vec<String>,
    /// Of every material the first one that deforms as it does: equal elastic constants, viscosity, and stress and pressure that come with it.
    pub first_alike: Vec<usize>,
    /// Elastic constants per material.
    pub materials: Vec<Elastic>,
    /// Density per material [kg/m³].
    pub densities: Vec<f64>,
    /// Body force per material: density · gravity + the scene's own [N/m³].
    pub body_force: Vec<[f64; 3]>,
    /// The part of the initial stress that weight gives.
    pub weight_stress: Option<WeightStress>,
    /// Prescribed displacements, those at the factor 1 of their histories.
    pub constraints: Constraints,
    /// Numbers of the histories of the prescribed displacements, in the order of `constraints.prescribed()`.
    pub prescribed_histories: Vec<usize>,
    /// Loads on the surface.
    pub tractions: Vec<SurfaceTraction>,
    /// Viscosity η of each material that creeps, `ε̇_v = s/(2η)` [Pa·s].
    pub viscosities: Vec<Option<f64>>,
    /// True for each material in which σ0 is its vertical component in all directions.
    pub isotropic: Vec<bool>,
    /// Stress before any displacement.
    pub initial_stress: Option<InitialStress>,
    /// Pressure of the fluid in each fracture along z [Pa] and the number of its history.
    pub pressures: Vec<(Profile<f64>, usize)>,
    /// What in each fracture follows the pore pressure of the rock on its two sides, beside `pressures`.
    pub pressures_from: Vec<Option<PressureFrom>>,
    /// Changes of pore pressure that are the same all over a material.
    pub pore_changes: Vec<PoreChange>,
    /// Changes of pore pressure that differ from element to element; `pore_changes` of their materials are 0.
    pub pore_fields: Vec<PoreField>,
    /// The fluid that flows in the fractures, where the scene has one; `pressures` are then 0.
    pub fluid: Option<Fluid>,
    /// Opening of each fracture before any displacement [m].
    pub gaps: Vec<f64>,
    /// Factors of the loads in time; number [`Body::ALWAYS`] is 1 at all times.
    pub histories: Vec<History>,
    /// Steps in time, if any.
    pub time: Option<TimeTable>,
    /// How closely the time at which slip begins is looked for, if it is.
    pub onset: Option<Onset>,
    /// How the non-linear problem is solved.
    pub solver: SolverSection,
}

impl Body {
    /// Number of the history of what does not change.
    pub const ALWAYS: usize = 0;

    /// The preconditioner of a run that the scene asks for, or that size and mesh suggest.
    pub fn preconditioner(&self) -> Racp {
        let is_grid = self.mesh.grid.as_ref().is_some_and(|grid| !grid.is_thin());
        let displacements = self.constraints.free_len();
        self.solver.preconditioner(is_grid, displacements)
    }

    /// σ0 at a point of a region [Pa]; 0 where the scene gives none.
    pub fn initial_stress_at(&self, region: usize, x: [f64; 3]) -> [f64; 6] {
        let mut sigma = self.initial_stress.map_or([0.0; 6], |s| s.at(x));
        if let Some(weight) = &self.weight_stress {
            let own = weight.at(x);
            (0..6).for_each(|k| sigma[k] += own[k]);
        }
        match sigma {
            [.., zz, _, _, _] if self.isotropic[region] => [zz, zz, zz, 0.0, 0.0, 0.0],
            sigma => sigma,
        }
    }

    /// Traction `σ0 n` of the initial stress on a face at x, on an area vector n: the same from both sides, but for materials whose stress is
    /// isotropic and columns of another weight, where it is the mean. Unit of n times Pa.
    pub fn initial_pull_at(&self, face: &FractureFace, x: [f64; 3], n: [f64; 3]) -> [f64; 3] {
        let [minus, plus] = [face.minus.element, face.plus.element].map(|e| {
            let region = usize::from(self.mesh.regions[e as usize]);
            let jumps = self.weight_stress.as_ref().is_some_and(WeightStress::jumps);
            self.initial_stress_at(region, if jumps { self.towards(e, x) } else { x })
        });
        let mean = |k: usize| {
            if minus[k] == plus[k] {
                minus[k]
            } else {
                0.5 * (minus[k] + plus[k])
            }
        };
        let [xx, yy, zz, xy, yz, xz] = std::array::from_fn(mean);
        let sigma = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        sigma.map(|row| (0..3).map(|k| row[k] * n[k]).sum())
    }

    /// A point a little inside an element [m].
    fn towards(&self, e: u32, x: [f64; 3]) -> [f64; 3] {
        let nodes = self.mesh.elements[e as usize].map(|a| self.mesh.nodes[a as usize]);
        std::array::from_fn(|d| {
            let center = nodes.iter().map(|node| node[d]).sum::<f64>() / 8.0;
            x[d] + INSIDE * (center - x[d])
        })
    }

    /// Friction of a face, where the scene gives it.
    pub fn friction_of(&self, face: &FractureFace) -> Option<Friction> {
        let profile = self.friction.get(usize::from(face.fracture))?.as_ref();
        profile.map(|profile| profile.at(face.center[2]))
    }

    /// Pressure of the fluid in a face, that at the factor 1 of its history, without what follows the rock on its sides [Pa].
    pub fn pressure_of(&self, face: &FractureFace) -> f64 {
        let profile = self.pressures.get(usize::from(face.fracture));
        profile.map_or(0.0, |(profile, _)| profile.at(face.center[2]))
    }

    /// Marks of the prescribed displacements, `3·node + component`.
    pub fn prescribed(&self) -> Vec<bool> {
        let mut marks = vec![false; self.constraints.full_len()];
        for (dof, _) in self.constraints.prescribed() {
            marks[*dof as usize] = true;
        }
        marks
    }

    /// Counts, bodies and what holds them, quality, rank of the coupling.
    ///
    /// # Cost
    /// O(elements), plus dense ranks where the fractures are small.
    pub fn audit(&self) -> Audit {
        audit(&self.mesh, &self.fractures, &self.prescribed())
    }
}

impl Initial for Body {
    fn stress(&self, region: usize, x: [f64; 3]) -> [f64; 6] {
        self.initial_stress_at(region, x)
    }
}
