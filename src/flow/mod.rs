//! Flow in fractures: what a fluid is, how it gets from face to face, and the balance of its volume.
//!
//! | formula | file |
//! |---|---|
//! | `q = −(C_f/μ)(∇p − ρ g)`, two-point fluxes, star–delta at junctions | `network` |
//! | the same where faces are no rectangles: multi-point fluxes | `vertex` |
//! | what goes from face to face, and its derivatives | `edge_flow` |
//! | `C_f = C_f0 + g_N³/12` where open | [`Fluid::conductivity`] |
//! | `C_f0` that depends on the direction | [`Directed`] |
//! | volume per face: aperture, compression, flux, sources | `balance` |
//! | what of it is rounding | `point` |
//! | wells, `2π/ln(r_e/r_w)` | `well` |
//! | which wells are at their rate, at their limit, or shut | `control` |
//! | open faces as a surface that pressures open | `surface` |
//! | given pressures on their way up | `raised` |
//! | parts whose storage rounding loses | `reservoir` |
//! | pressure jumps held down | `balance`, weights of [`JumpStabilization`](crate::contact::JumpStabilization) |

mod balance;
mod control;
mod directed;
mod edge_flow;
mod fluid;
mod front;
mod network;
mod pattern;
mod point;
mod raised;
mod record;
mod reservoir;
mod sealed;
mod step;
mod surface;
mod vertex;
mod well;

pub use balance::{Balance, FlowTangent};
pub use directed::Directed;
pub use fluid::{Channel, Fluid, Given, Place, Source};
pub use network::Network;
pub(crate) use network::ends as edge_ends;
pub use point::FlowPoint;
pub use sealed::Sealed;
pub use step::{FlowRecord, FlowStep};
pub use surface::surface;
pub use well::{Control, Well, WellGiven, WellRecord, WellStep};

#[cfg(test)]
mod tests;
