//! Contact on fractures: how tractions push on the body (B) and how spurious traction modes are balanced (H).

mod coupling;
mod stabilization;

pub use coupling::{Coupling, prescribed_jump};
pub use stabilization::{JumpStabilization, Side, side_stiffness};
