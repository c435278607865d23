//! From plain settings to a ready preconditioner.

use crate::SetupError;
use fracas_operators::{Preconditioner, Real};
use std::fmt::Debug;

/// Plain settings that know how to become a ready object for an operator of type `Op`.
///
/// Settings are data (`serde`), nest (`Racp { augmentation, inner }`), and are printed verbatim into every result.
pub trait Prepare<Op: ?Sized, R: Real>: Debug {
    /// Everything that depends on the operator but not on a right-hand side.
    fn prepare(&self, op: &Op) -> Result<Box<dyn Preconditioner<R>>, SetupError>;
}
