//! The stress room: mutated inputs, random scenes and systems, kills and signals, faults of disk and memory, each case from a
//! seed and a number. A slice of a minute runs with every test; `docs/stress.md` says how to run the rest and what was found.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

mod agreement;
mod checkpoints;
mod command_lines;
mod faults;
mod fixed;
mod folders;
mod generator;
mod gmsh;
mod mutation;
mod random;
mod room;
mod scenes;
mod signals;
