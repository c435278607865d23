//! Claims about contact: states, slip, springs, runs of random scenes.
#![allow(clippy::unwrap_used)]

mod accuracy;
mod arrested;
mod consistency;
mod healing;
mod jacobian;
mod known;
mod onset;
mod patch;
mod profiles;
mod robust;
mod scenes;
mod slip;
mod springs;
mod store;
mod unstable;
