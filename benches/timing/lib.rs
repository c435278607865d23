//! What benches share: a clock that a shared machine does not blur, rounds in turn, and what the processor does at most.

pub mod clock;
pub mod fused;
pub mod rounds;
