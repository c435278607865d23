//! Matrix Market files: a parallel reader and writer, exact to the last bit.
//!
//! A file is read in blocks, twice where it lists coordinates: once to count, once to fill the rows. Its text is never in
//! memory as a whole; the line of a defect is looked for only when there is one.
//!
//! Read: `coordinate` and `array`, `real`, `double` and `integer`, `general`, `symmetric` (either triangle) and
//! `skew-symmetric`; banner in any case, `%` comments, blank lines, CRLF, Fortran exponents (`1.5D+03`). Written: 17
//! significant digits, which give every `f64` back bit for bit.
//!
//! # Source
//! Boisvert, Pozo & Remington, *The Matrix Market exchange formats*, NISTIR 5935 (1996).

mod array;
mod assemble;
mod blocks;
mod diagnose;
mod error;
mod header;
mod lines;
mod parse;
mod read;
mod write;

#[cfg(test)]
mod tests;

pub use error::{Defect, MatrixMarketError};
pub use header::Symmetry;
pub use read::{
    Announced, Duplicates, SparseFile, read_dense, read_sizes, read_sparse, read_vector,
};
pub use write::{write_dense, write_sparse, write_vector};
