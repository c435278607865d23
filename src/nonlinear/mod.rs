//! Frictional contact: active set → Newton → Krylov, step by step.
//!
//! | cycle | file | repeats until |
//! |---|---|---|
//! | steps | [`Simulation`] | the last time; a step that fails starts once more from all-stick, then is halved |
//! | active set | `active_set` | no face changes its state |
//! | Newton | `newton` | the residual at fixed states is small |
//! | Krylov | `linear`, `krylov` | the linear system is solved as well as Newton asks |
//!
//! A step starts with every closed face in stick. Tractions are total; slip is counted from the start of the step, the
//! jump stabilization acts on total normal and on incremental tangential tractions.
//!
//! Where rock creeps, A is that of the length of the step, and the past is a load: see [`creep`](crate::creep).

mod accepting;
mod accuracy;
mod active_set;
mod all_steps;
mod arrest;
mod assembled;
mod coupled;
mod creeping;
mod cycling;
mod damping;
mod energy;
mod face_rules;
mod factorized;
mod failure;
mod fallback;
mod faults;
mod fields;
mod flow;
mod followed;
mod friction;
mod giving_way;
mod jacobian;
mod judge;
mod kept;
mod krylov;
mod linear;
mod loads;
mod natural;
mod newton;
mod newton_system;
mod onset;
mod pressed;
mod problem;
mod raising;
mod record;
mod remarks;
mod returning;
mod rounds;
mod serving;
mod simulation;
mod springs;
mod stability;
mod start;
mod state;
mod state_c;
mod state_rows;
mod times;
mod tried;
mod turns;
mod workspace;

pub use creeping::CreepState;
pub use energy::EnergyRecord;
pub use failure::{Failure, LinearFailure, SimulationError, StepFailure};
pub use faults::FaultRecord;
pub use fields::FaceFields;
pub use jacobian::ContactJacobian;
pub use loads::Loads;
pub use newton_system::{NewtonSystem, NewtonSystemError};
pub use onset::{Begins, Onsets, SlipOnset};
pub use problem::{ContactProblem, Evaluation};
pub use record::{Accepted, Event, LinearRecord, StepRecord, digits_of};
pub use remarks::{Remark, friction_remarks};
pub use simulation::Simulation;
pub use stability::Instability;
pub use start::{Load, Start};
pub use state::{Prepared, State};
pub use workspace::FreeMemory;
