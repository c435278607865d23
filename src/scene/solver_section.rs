//! How a scene is solved: steps in time, and the three nested cycles.

use std::num::NonZeroU32;

use fracas_solvers::saddle::{self as solvers, AugmentationChoice, InnerChoice, Racp};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::onset::OnsetSection;
use super::rounds::Rounds;
use crate::contact::{Interfaces, Junctions, Lengths};
use crate::units::{Duration, Measure};

/// Steps after the equilibrium at time 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeSection {
    /// Last time.
    pub end: Measure<Duration>,
    /// Number of equal steps; a step that fails is cut.
    pub steps: NonZeroU32,
    /// Factor of every displacement, traction, pressure and fracture pressure that has no history of its own, as
    /// `[[time, factor], …]`; gravity, body forces and initial stress do not change.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub history: Option<Vec<(Measure<Duration>, f64)>>,
    /// Look for the time at which slip begins: the step in which it does is halved until the time is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub onset: Option<OnsetSection>,
}

/// How contact is enforced. Written as `"lagrange"` or `{ penalty = { factor = 1e3 } }`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Tractions are Lagrange multipliers of closed faces: contact holds exactly.
    #[default]
    Lagrange,
    /// Tractions are those of springs in the faces: displacements are the only unknowns, closed faces overlap and give.
    Penalty(Penalty),
    /// Springs around multipliers that are updated until the overlap vanishes (Uzawa).
    AugmentedLagrangian(AugmentedLagrangian),
}

/// Springs in the faces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Penalty {
    /// Stiffness of a face times its local compliance: 1 is about as stiff as the rock beside it. Unit: 1.
    pub factor: f64,
}

impl Default for Penalty {
    fn default() -> Self {
        Self { factor: 1e2 }
    }
}

/// Springs in the faces around multipliers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AugmentedLagrangian {
    /// As [`Penalty::factor`]. Unit: 1.
    pub factor: f64,
    /// Updates of the multipliers in one attempt at a step.
    pub max_updates: usize,
}

impl Default for AugmentedLagrangian {
    fn default() -> Self {
        Self {
            // by 10 a stuck fault of 56 faces takes 57 updates, by 100 nine; the number grows with the fault
            factor: 1e2,
            max_updates: 200,
        }
    }
}

/// Active set, Newton and Krylov.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSection {
    /// Residual of equilibrium and contact rows relative to the loads and internal forces, and errors of u and t relative to
    /// the largest so far. Unit: 1.
    pub tolerance: f64,
    /// What is held against the tolerance: `error`, the errors beside the residual, or `residual` alone, as in published
    /// counts.
    pub measure: solvers::Measure,
    /// What counts as zero when states are judged, relative to the largest traction of the step. Unit: 1.
    pub state_tolerance: f64,
    /// Rounds of the active set in one attempt, Newton steps on all faces at once included.
    pub max_active: usize,
    /// Newton steps in one round.
    pub max_newton: usize,
    /// Krylov iterations in one Newton step.
    pub max_krylov: usize,
    /// Halvings of the nominal step before the run gives up.
    pub max_cuts: usize,
    /// What to do where slip that weakens runs away: `stop`, or `arrest` to step over it.
    pub unstable: Unstable,
    /// How contact is enforced: `lagrange`, or `penalty` and `augmented_lagrangian` to compare with.
    pub method: Method,
    /// Lengths that the jump stabilization H is made of: `deep`, or `box` as published, which lets more shear and
    /// less overlap through where cells are thin across fractures. Where none is thin they are the same.
    pub stabilization: Lengths,
    /// Whether H acts across the junctions of fractures: `joined`, while the faces that cross stick, or `apart`, as published.
    pub junctions: Junctions,
    /// Whether H acts where a fracture leaves one material for another that deforms differently.
    pub interfaces: Interfaces,
    /// How contact states are searched for.
    #[serde(deserialize_with = "fracas_solvers::steering::in_range")]
    pub rounds: Rounds,
    /// Inner solver of the preconditioner.
    pub inner: RunInner,
    /// The preconditioner in full, in place of `inner`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub racp: Option<Racp>,
}

/// What a run does where slip that weakens runs away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Unstable {
    /// It ends with the last state before.
    #[default]
    Stop,
    /// It goes on from where slip comes to rest without inertia.
    Arrest,
}

/// Inner solver of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RunInner {
    /// Exact up to 5,000 displacements, then geometric where the mesh has a grid whose cells are not far larger than the body is thick, else AMG.
    #[default]
    Auto,
    /// Sparse Cholesky factorization of S_u; with a fluid, sparse LU factorization of all fields.
    Exact,
    /// Algebraic multigrid.
    Amg,
    /// Geometric multigrid: A is never assembled.
    Geometric,
}

/// Displacements up to which S_u is factorized when the scene does not choose. Unit: 1.
pub const FACTORIZED: usize = 5_000;

/// C where the scene does not choose: half of H also where cells are flat. S̃_u is kept while faces slip and open, and less of H in
/// C leaves stiffer springs in it: flat cells of 1:50 all opening take 91 iterations with fitted_h, 48 with this.
const AUGMENTATION: AugmentationChoice = AugmentationChoice::HalfH;

impl SolverSection {
    /// The preconditioner of a run that the scene asks for, or that its size suggests: for so many free displacements, on a grid that is not
    /// [thin](crate::mesh::is_thin) or on another mesh.
    pub fn preconditioner(&self, is_grid: bool, displacements: usize) -> Racp {
        let around = |inner| Racp {
            augmentation: AUGMENTATION,
            inner,
            ..Racp::default()
        };
        let amg = InnerChoice::Amg(Default::default());
        let small = displacements <= FACTORIZED;
        match (self.racp, self.inner) {
            (Some(racp), _) => racp,
            (None, RunInner::Exact) => around(InnerChoice::default()),
            (None, RunInner::Auto) if small => around(InnerChoice::default()),
            (None, RunInner::Auto) if !is_grid => around(amg),
            (None, RunInner::Amg) => around(amg),
            (None, RunInner::Auto | RunInner::Geometric) => {
                around(InnerChoice::Geometric(Default::default()))
            }
        }
    }

    /// Whether it is made from an assembled A.
    pub fn assembles(&self, is_grid: bool, displacements: usize) -> bool {
        !self.preconditioner(is_grid, displacements).is_matrix_free()
    }
}

impl Default for SolverSection {
    fn default() -> Self {
        Self {
            tolerance: 1e-8,
            measure: solvers::Measure::Error,
            state_tolerance: 1e-6,
            max_active: 300,
            max_newton: 15,
            max_krylov: 400,
            max_cuts: 8,
            unstable: Unstable::Stop,
            method: Method::Lagrange,
            stabilization: Lengths::default(),
            junctions: Junctions::default(),
            interfaces: Interfaces::default(),
            rounds: Rounds::default(),
            inner: RunInner::Auto,
            racp: None,
        }
    }
}
