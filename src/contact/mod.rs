//! Contact on fractures: how tractions push on the body (B), how spurious traction modes are balanced (H), and the
//! rows of a face that sticks, slips or is open.

mod coupling;
mod friction;
mod law;
mod projection;
mod slip;
mod so_far;
mod stabilization;
mod state;
mod transition;

pub use coupling::{Coupling, prescribed_jump};
pub use friction::{Friction, Weakening};
pub use law::{FaceLaw, FacePoint, FaceRows};
pub use so_far::{SlipSoFar, Slipped, WeakeningBy};
pub(crate) use stabilization::between;
pub use stabilization::{
    Interfaces, JumpStabilization, Junctions, Lengths, Rocks, Side, face_compliance, side_stiffness,
};
pub use state::ContactState;
pub use transition::{FaceMeasure, Thresholds, next_state};
