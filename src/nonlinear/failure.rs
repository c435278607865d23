//! Why a step could not be done.

use super::active_set::Log;
use super::record::count;
use super::times::{Target, length};
use super::{Instability, State};
use crate::contact::ContactState;
use crate::elasticity::ElasticityError;
use crate::matrix_free::MatrixFreeError;
use crate::mesh::{FractureMesh, Hold, bodies};
use crate::scene::Body;
use crate::system::of_held_bodies;
use fracas_solvers::SetupError;
use fracas_solvers::krylov::Breakdown;
use fracas_solvers::steering::OutOfRange;
use fracas_solvers::words::by_number;

/// Why a linear system has no solution good enough.
#[derive(Debug, thiserror::Error)]
pub enum LinearFailure {
    /// The preconditioner cannot be built.
    #[error(transparent)]
    Setup(SetupError),
    /// The matrix-free preconditioner cannot be built.
    #[error(transparent)]
    MatrixFree(#[from] MatrixFreeError),
    /// The blocks cannot be assembled.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
    /// The arithmetic cannot continue.
    #[error(transparent)]
    Breakdown(#[from] Breakdown),
    /// Vectors that no iteration has room for.
    #[error(
        "memory holds {vectors} more vectors of {n} unknowns ({:.1} MB each) and the shortest iteration takes 8; use fewer cells, or free memory", 8e-6 * *n as f64
    )]
    NoRoom {
        /// That fit.
        vectors: usize,
        /// Unknowns.
        n: usize,
    },
    /// A system of rock and flow that its states leave singular.
    #[error(transparent)]
    Singular(SetupError),
    /// Apertures and pressures of an iterate at which the balance of the fluid tells double precision nothing.
    #[error(
        "Newton has led the fluid astray: apertures and pressures at hand are so far from balance that the Schur complement of the pressures is singular to working precision; shorter steps or a conductivity of the closed fractures closer to that of the open ones may help"
    )]
    Astray,
    /// Iterations ran out.
    #[error(
        "{krylov} reached a relative residual of {residual:.1e} in {iterations} iterations, asked {tolerance:.1e}: {advice}"
    )]
    IterationLimit {
        /// Method.
        krylov: &'static str,
        /// Iterations made.
        iterations: usize,
        /// Reached.
        residual: f64,
        /// Asked.
        tolerance: f64,
        /// Why, and what to do.
        advice: &'static str,
    },
}

impl From<SetupError> for LinearFailure {
    /// In a run every body is held by its closed faces.
    fn from(error: SetupError) -> Self {
        Self::Setup(of_held_bodies(error))
    }
}

/// Why an attempt at a step failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A linear system.
    #[error("Krylov: {0}")]
    Linear(#[from] LinearFailure),
    /// The linear equations of the states that the step starts with, which are the same however short the step.
    #[error("{0}")]
    Unsolvable(Box<Failure>),
    /// Newton at fixed states.
    #[error(
        "Newton: residual {residual:.1e} after {iterations} steps at fixed states, asked {tolerance:.1e}"
    )]
    Newton {
        /// Reached, relative to loads and internal forces.
        residual: f64,
        /// Steps made.
        iterations: usize,
        /// Asked.
        tolerance: f64,
    },
    /// Newton for rock and springs.
    #[error(
        "Newton: residual {residual:.1e} after {iterations} steps of rock and springs (max_active), asked {tolerance:.1e}; shorter steps, another factor of the springs or method = \"lagrange\" in [solver] may help"
    )]
    Springs {
        /// Reached, relative to loads and internal forces.
        residual: f64,
        /// Steps made.
        iterations: usize,
        /// Asked.
        tolerance: f64,
    },
    /// The residual is small and the error is not.
    #[error(
        "accuracy: the {part} may be wrong by {error:.1e}, asked {tolerance:.1e}, and {}",
        of_residual(*residual)
    )]
    Inaccurate {
        /// `displacements` or `tractions`.
        part: &'static str,
        /// Their error relative to the largest norm so far.
        error: f64,
        /// Asked, `state_tolerance` included.
        tolerance: f64,
        /// Residual relative to loads and internal forces.
        residual: f64,
    },
    /// States still change.
    #[error("active set: {} faces still change after {rounds} rounds, first of them {}", faces.len(), first(faces))]
    ActiveSet {
        /// Rounds made.
        rounds: usize,
        /// Faces that changed in the last one.
        faces: Vec<usize>,
    },
    /// Faces open and close over and over: the attempt starts once more with their cohesion lost.
    #[error("{} faces open and close over and over, first of them {}", faces.len(), first(faces))]
    Torn {
        /// Which.
        faces: Vec<usize>,
    },
    /// More fluid is asked of closed fractures than they hold.
    #[error(
        "{volume:.3e} m³ of fluid are taken from {} that {} none: give {} `storage`, the fluid `compressibility`, or prescribe a pressure in place of the rate", quoted(fractures), by_number(fractures.len(), "is closed and holds", "are closed and hold"), by_number(fractures.len(), "it", "them")
    )]
    Drained {
        /// Names of the connected fractures.
        fractures: Vec<String>,
        /// What is missing [m³].
        volume: f64,
    },
    /// A fluid is expanded until nothing of it is left.
    #[error(
        "the pressure in {} falls to {pressure:.3e} Pa, below the {empty:.3e} Pa at which a fluid of this `compressibility` has no mass left: more is taken than is there; take less, or prescribe a pressure in place of the rate",
        quoted(fractures)
    )]
    Emptied {
        /// Names of the fractures.
        fractures: Vec<String>,
        /// The lowest pressure [Pa].
        pressure: f64,
        /// `−1/c_f` [Pa].
        empty: f64,
    },
    /// A block has lost what held it.
    #[error("with {open} {} open nothing{} holds the body of {elements} elements around ({:.6}, {:.6}, {:.6}) m: {}{free} rigid {} free, so that there {} no equilibrium ({reason})", by_number(*open, "face", "faces"), but_slipping(*slipping), center[0], center[1], center[2], if *slipping > 0 { "without them " } else { "" }, by_number(*free, "motion is", "motions are"), if *slipping > 0 { "may be" } else { "is" })]
    Loose {
        /// Open faces.
        open: usize,
        /// Slipping faces, where the body is loose only without them.
        slipping: usize,
        /// Elements of the first body that nothing holds.
        elements: usize,
        /// Its centre [m].
        center: [f64; 3],
        /// Rigid motions left, together with the bodies that it touches.
        free: usize,
        /// How it showed.
        reason: Box<Failure>,
    },
    /// Slip runs away.
    #[error(
        "unstable: {0}, so that no quasi-static step follows; [solver] unstable = \"arrest\" steps over it"
    )]
    Unstable(Box<Instability>),
    /// A number is no longer finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// What.
        what: &'static str,
    },
    /// The observer wants to stop.
    #[error("stopped on request")]
    Stopped,
}

fn quoted(names: &[String]) -> String {
    let what = match names.len() {
        1 => "fracture",
        _ => "the fractures",
    };
    let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    format!("{what} {}", names.join(", "))
}

fn but_slipping(faces: usize) -> String {
    match faces {
        0 => String::new(),
        faces => format!(" but {faces} slipping faces"),
    }
}

fn first(faces: &[usize]) -> String {
    match faces.first() {
        Some(face) => format!("face {face}"),
        None => "none".into(),
    }
}

impl Failure {
    /// A failure with open faces may mean that a body is held by nothing: then that is the reason. That slipping faces alone hold
    /// one is a guess, made where the equations are `firm`.
    pub(super) fn explained(self, body: &Body, states: &[ContactState], firm: bool) -> Self {
        let [_, new_slip, slip, open] = count(states);
        // what open faces let go, then what nothing but slipping faces hold
        for slipping in [0, new_slip + slip].into_iter().take(1 + usize::from(firm)) {
            let holds = |f: &usize| match states[*f] {
                ContactState::Stick => true,
                ContactState::Open => false,
                ContactState::NewSlip | ContactState::Slip => slipping == 0,
            };
            let faces = (0..states.len()).filter(holds);
            let joined = FractureMesh {
                faces: faces.map(|f| body.fractures.faces[f].clone()).collect(),
                ..FractureMesh::default()
            };
            if matches!(self, Self::Stopped) || joined.faces.len() == states.len() {
                continue;
            }
            for part in bodies(&body.mesh, &joined, &body.prescribed()) {
                if let Hold::Nothing { free } = part.hold {
                    return Self::Loose {
                        open,
                        slipping,
                        elements: part.elements,
                        center: part.center,
                        free,
                        reason: Box::new(self),
                    };
                }
            }
        }
        self
    }

    /// True where another attempt may help.
    pub(super) fn may_be_cut(&self) -> bool {
        self.may_be_projected() && !matches!(self, Self::Unsolvable(_))
    }

    /// True where a shorter step may help: what rounding leaves does not depend on it, but on how close slip that `weakens` a fault is to
    /// running away.
    pub(super) fn may_be_shortened(&self, weakens: bool) -> bool {
        self.may_be_cut() && (weakens || !matches!(self, Self::Inaccurate { .. }))
    }

    /// True where slip that runs away may be why: not what a fluid lacks.
    pub(super) fn may_be_of_slip(&self) -> bool {
        self.may_be_cut() && !matches!(self, Self::Drained { .. } | Self::Emptied { .. })
    }

    /// True where states do not settle, or ask of Newton what it does not find.
    pub(super) fn is_of_states(&self) -> bool {
        matches!(self, Self::ActiveSet { .. } | Self::Newton { .. })
    }

    /// True where other states may help: what states leave loose, or what they ask of Newton, may be no equilibrium.
    pub(super) fn may_be_projected(&self) -> bool {
        !matches!(
            self,
            Self::Stopped
                | Self::Linear(
                    LinearFailure::Setup(_)
                        | LinearFailure::MatrixFree(_)
                        | LinearFailure::Elasticity(_)
                        | LinearFailure::NoRoom { .. }
                )
        )
    }
}

/// A step that no halving could do; the state before it is still good.
#[derive(Debug, thiserror::Error)]
#[error(
    "step {step} from time {time} s by {increment:.3e} {unit} failed after {cuts} halvings{}: {reason}",
    of_planned(*planned, unit)
)]
pub struct StepFailure {
    /// Number of the step.
    pub step: usize,
    /// Time at its start [s].
    pub time: f64,
    /// Smallest increment tried.
    pub increment: f64,
    /// Its unit: `s`, or `of the loads of time 0`.
    pub unit: &'static str,
    /// Halvings in this step.
    pub cuts: usize,
    /// The increment that was planned, where steps before have halved it already.
    pub planned: Option<f64>,
    /// Why the last attempt failed.
    pub reason: Failure,
    /// Linear solves of all attempts.
    pub linear: Vec<super::LinearRecord>,
    /// What happened on the way.
    pub events: Vec<super::Event>,
}

impl StepFailure {
    /// Of a step that goes no further.
    pub(super) fn new(
        state: &State,
        target: Target,
        cuts: usize,
        reason: Failure,
        log: Log,
    ) -> Box<Self> {
        Box::new(Self {
            step: state.step,
            time: state.time,
            increment: length(state, target),
            unit: match state.loaded < 1.0 {
                true => "of the loads of time 0",
                false => "s",
            },
            cuts,
            planned: target.planned,
            reason,
            linear: log.linear,
            events: log.events,
        })
    }
}

/// What halvings of steps before have left to a step.
fn of_planned(planned: Option<f64>, unit: &str) -> String {
    match planned {
        Some(planned) => format!(" beside those of steps before (planned {planned:.3e} {unit})"),
        None => String::new(),
    }
}

/// Why a body cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// A fracture without friction data.
    #[error(
        "fracture \"{fracture}\" has neither friction_angle nor cohesion; give friction_angle = \"0 deg\" for a smooth one"
    )]
    NoFriction {
        /// Its name.
        fracture: String,
    },
    /// Flow beside springs.
    #[error(
        "[fluid] needs tractions among the unknowns: take method = \"lagrange\" in [solver], not penalty or augmented_lagrangian"
    )]
    FlowWithSprings,
    /// An S_p of entries of S_u.
    #[error(
        "[solver.racp.flow] asks for schur = \"{name}\", which is for systems with assembled blocks; a run takes half_order or transmissibility"
    )]
    PressureSchur {
        /// As asked.
        name: &'static str,
    },
    /// Geometric multigrid of a mesh from a file.
    #[error(
        "[solver] asks for geometric multigrid, and the mesh has no grid to coarsen; take inner = \"amg\""
    )]
    NoGrid,
    /// A setting of geometric multigrid that makes no preconditioner.
    #[error("[solver] racp: geometric: {0}")]
    Geometric(OutOfRange),
    /// A number of the search for states beyond its range.
    #[error("[solver] rounds: {0}")]
    Rounds(#[from] OutOfRange),
    /// A C that geometric multigrid cannot have.
    #[error("[solver] racp: {0}")]
    Augmentation(SetupError),
    /// A mesh without a stiffness.
    #[error(transparent)]
    Elasticity(#[from] ElasticityError),
}

/// Residual relative to loads and internal forces above which it is not taken for rounding: what stiff rock, 10⁸ times the soft one, leaves of
/// 10⁻¹⁶. Unit: 1.
const BEYOND_ROUNDING: f64 = 1e-6;

/// What keeps a residual from falling, and what helps.
fn of_residual(residual: f64) -> String {
    match residual <= BEYOND_ROUNDING {
        true => format!(
            "rounding keeps the residual at {residual:.1e} of the largest force; less contrast of stiffness, flatness of cells or stiffness of springs helps, or a larger tolerance and state_tolerance in [solver]"
        ),
        false => format!(
            "steps leave the residual at {residual:.1e} of the largest force, which is more than rounding; a smaller tolerance in [solver], by which states are found from better tractions, may help"
        ),
    }
}
