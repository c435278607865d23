//! Maxwell creep: rock whose deviatoric stress flows, `ε̇_v = s/(2η)`.
//!
//! `σ = σ0 + K tr(ε) I + 2G (e − ε_v)`, e the deviator of ε. Without strain s dies out as `e^(−Gt/η)`: τ = η/G is the relaxation time, 75
//! days for 1e17 Pa·s and G = 15.4 GPa. Steps of a year are taken at once ([`Rule`]); what is kept of the past is ε_v at the
//! integration points of the elements that creep ([`CreepingRock`]).
//!
//! # Source
//! The deck: `ε̇_v = V(μ) σ`, μ = 1e17 Pa·s, in the salt above the reservoir.

mod elements;
mod rule;

pub use elements::{Beyond, CreepingRock, Initial};
pub use rule::Rule;

/// Steps longer than this many relaxation times are refused: A is then that of a fluid, 1 − 2ν = O(τ/Δt), and keeps no digits. Unit: 1.
pub const LONGEST: f64 = 1e4;
