//! Saddle points `[A B1; B2 −H]`, their augmentations C and their preconditioners.

mod accurate;
pub mod augmentation;
pub mod augmented_lagrangian;
pub mod block_diagonal;
pub mod block_triangular;
pub mod blocks;
mod contact_rows;
pub mod cost;
mod determined;
pub mod elimination;
mod energy_norms;
mod error_judge;
mod fields;
pub mod folder;
mod halved;
pub mod inner;
mod iterated;
mod leading;
pub mod mcp;
pub mod method;
pub mod monolithic;
mod of_tractions;
pub mod operator;
mod probe;
pub mod racp;
pub mod relaxation;
mod remainder;
mod residual;
#[cfg(test)]
pub(crate) mod samples;
pub(crate) mod scaling;
pub mod schur;
mod series;
pub mod simple;
mod stiffness;
mod system;
pub mod three_fields;
mod unit;

pub use crate::DofCoordinate;
pub use accurate::{Accurate, Measure, solve_accurately};
pub use augmentation::{
    Augmentation, AugmentationChoice, AugmentationMatrix, AugmentationRule, Block,
    CustomAugmentation,
};
pub use augmented_lagrangian::{AugmentedLagrangian, AugmentedLagrangianInverse};
pub use block_diagonal::{BlockDiagonal, BlockDiagonalInverse};
pub use block_triangular::{BlockTriangular, BlockTriangularInverse};
pub use blocks::{FlowBlocks, SaddleBlocks};
pub use contact_rows::ContactRows;
pub use cost::Cost;
pub use elimination::{EliminatedInverse, Elimination};
pub use energy_norms::{EnergyNorms, StrainNorm, WithDiagonal};
pub use error_judge::{ErrorJudge, Judged, TRUSTED};
pub use fields::{P, T, U};
pub use halved::{HalvedBlocks, HalvedSystem};
pub use inner::{InnerChoice, InnerSolver, PartCost, Ready};
pub use iterated::{Iterated, NotReached};
pub use mcp::{Mcp, McpInverse, published_gamma};
pub use method::{CustomMethod, NoSuchPart, SaddleMethod, SaddleSettings, UnknownSaddleMethod};
pub use monolithic::Direct;
pub use operator::SaddleOperator;
pub use probe::{Left, Probed, nearest_eigenvalue, probe};
pub use racp::{Racp, RacpInverse};
pub use relaxation::{REACH, RELAXATION, Relaxation, RelaxationSummary};
pub use series::{FOLLOWS, Series};
pub use simple::{Correction, Simple, SimpleInverse};
pub use stiffness::Stiffness;
pub use system::{Assembled, ResidualNorms, SaddleSystem};
pub use three_fields::{
    Form, NearSchur, PressureFactors, PressureSchur, PressureSystem, Surface, ThreeFields,
    ThreeFieldsInverse,
};
pub use unit::unit_of_tractions;
