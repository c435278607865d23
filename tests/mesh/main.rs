//! Claims about meshes and scenes.
#![allow(clippy::unwrap_used)]

mod checkerboard;
mod gallery;
mod geology;
mod patches;
mod rank;
mod scene_errors;
mod slopes;
mod splitting;
mod stabilization_lengths;
mod tilted;
mod tops;
