//! Claim: a body from a Gmsh file is the body of the same grid, and whatever is wrong with a file is said with its place.
#![allow(clippy::unwrap_used)]

mod bad_files;
mod scenes;
mod true_files;
mod writer;
