//! Claims about meshes and scenes.
#![allow(clippy::unwrap_used)]

mod checkerboard;
mod fingerprint;
mod gallery;
mod geology;
mod inventory;
mod levels;
mod part_of_side;
mod patches;
mod rank;
mod scene_errors;
mod sizes;
mod slopes;
mod splitting;
mod stabilization_lengths;
mod tilted;
mod tops;
