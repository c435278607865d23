//! Definitions of C that somebody else brings.

use super::{AugmentationChoice, AugmentationMatrix};
use crate::SetupError;
use crate::direct::DirectSolver;
use crate::registry::{NameTaken, Named, Registry};
use crate::saddle::SaddleBlocks;

/// A definition of C. [`register`](AugmentationChoice::register) gives it a name that scenes, studies and command lines know;
/// [`AugmentationChoice::Other`] takes it without one.
pub trait AugmentationRule: Named {
    /// True where the rows of C of a face need A on the supports of that face's columns of B alone, and C couples no faces: runs
    /// without an assembled A then ask for it piece by piece.
    fn is_local(&self) -> bool;

    /// C for these blocks, n_t × n_t, symmetric positive definite, in [m⁴]/[N/m] like BᵀA⁻¹B; `direct` factorizes A where that is
    /// needed. Rows that determine their own traction are not among them.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] with the reason, or those of [`AugmentationMatrix`].
    fn compute(
        &self,
        blocks: &SaddleBlocks,
        direct: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError>;
}

pub(super) static RULES: Registry<dyn AugmentationRule> = Registry::new("augmentation");

impl AugmentationChoice {
    /// Makes a definition known by its name.
    ///
    /// # Errors
    /// [`NameTaken`] where another definition has it.
    pub fn register(rule: &'static dyn AugmentationRule) -> Result<Self, NameTaken> {
        RULES.register::<Self>(rule).map(Self::Other)
    }
}
