//! Claims about contact: states, slip, springs, runs of random scenes.
#![allow(clippy::unwrap_used)]

mod accuracy;
mod arrested;
mod asked_onset;
mod consistency;
mod factorized;
mod gaps;
mod healing;
mod jacobian;
mod known;
mod lawful;
mod newton_systems;
mod onset;
mod patch;
mod profiles;
#[path = "../systems/reference.rs"]
mod reference;
mod remarks;
mod robust;
mod scenes;
mod slip;
mod slip_work;
mod springs;
mod store;
mod unstable;
