//! Saddle points `[A B1; B2 −H]`, their augmentations C and their preconditioners.

pub mod blocks;
pub mod folder;
pub mod operator;

pub use blocks::{DofCoordinate, FlowBlocks, SaddleBlocks};
pub use operator::SaddleOperator;
