//! Problems with known answers: closed forms that the numbers of this project are held against.
//!
//! Every form takes and returns SI units, tension positive, and is written from its source, not from the code that it
//! judges: this room imports nothing of the others.

mod block_sliding;
mod crack_network;
mod depletion;
mod diffusion;
mod displaced_fault;
mod error_function;
mod fault_friction;
mod inclined_crack;
mod line_crack;
mod nucleation;
mod penny_crack;
mod polygons;
mod rock;
mod sliding_factor;

pub use block_sliding::{BlockSliding, SlidingState};
pub use crack_network::{CrackNetwork, NetworkCrack, StraightCrack};
pub use depletion::Depletion;
pub use diffusion::{Diffusion, FarSide};
pub use displaced_fault::{
    DisplacedFault, FarStress, FaultLine, FaultPath, FaultPressure, FaultState, FaultStrength,
    LooseElement,
};
pub use fault_friction::{FaultFriction, NoState, Strength};
pub use inclined_crack::InclinedCrack;
pub use line_crack::LineCrack;
pub use nucleation::{LinearWeakening, RESOLVED, nucleation_half_length};
pub use penny_crack::PennyCrack;
pub use polygons::{displaced_blocks, meeting_edges, shared_area, signed_area};
pub use rock::Rock;
