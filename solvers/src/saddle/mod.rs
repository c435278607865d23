//! Saddle points `[A B1; B2 −H]`, their augmentations C and their preconditioners.

pub mod augmentation;
pub mod blocks;
pub mod folder;
pub mod inner;
pub mod operator;
pub mod racp;
#[cfg(test)]
pub(crate) mod samples;
pub(crate) mod scaling;
pub mod schur;
mod unit;

pub use crate::DofCoordinate;
pub use augmentation::{Augmentation, AugmentationChoice, AugmentationMatrix};
pub use blocks::{FlowBlocks, SaddleBlocks};
pub use inner::InnerChoice;
pub use operator::SaddleOperator;
pub use racp::{Racp, RacpInverse};
