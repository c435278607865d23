//! Saddle points `[A B1; B2 −H]`, their augmentations C and their preconditioners.

pub mod augmentation;
pub mod blocks;
<<<<<<< HEAD
pub mod elimination;
=======
pub mod cost;
>>>>>>> rivals
pub mod folder;
pub mod inner;
pub mod mcp;
pub mod method;
pub mod monolithic;
pub mod operator;
#[cfg(test)]
pub(crate) mod oracle;
pub mod racp;
#[cfg(test)]
pub(crate) mod samples;
pub(crate) mod scaling;
pub mod schur;
mod unit;

pub use crate::DofCoordinate;
pub use augmentation::{Augmentation, AugmentationChoice, AugmentationMatrix};
pub use blocks::{FlowBlocks, SaddleBlocks};
<<<<<<< HEAD
pub use elimination::{EliminatedInverse, Elimination};
pub use inner::InnerChoice;
=======
pub use cost::Cost;
pub use inner::{InnerChoice, Ready};
pub use mcp::{Mcp, McpInverse};
pub use method::{NoSuchPart, SaddleMethod, UnknownSaddleMethod};
pub use monolithic::Direct;
>>>>>>> rivals
pub use operator::SaddleOperator;
pub use racp::{Racp, RacpInverse};
