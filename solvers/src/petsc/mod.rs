//! The usual choices for S_u⁻¹ from the system's PETSc: GAMG and hypre's BoomerAMG. MUMPS is a
//! [direct solver](crate::direct::DirectChoice::Mumps). On one rank here; over the ranks of `mpirun` in [`distributed`](crate::distributed).
//!
//! The settings are there in every build; a build without the feature `petsc` refuses to set them up. PETSc serves one thread at a
//! time, so a lock stands around it: spectra, which apply M⁻¹ on all threads, wait for each other there.
//!
//! | step | file |
//! |---|---|
//! | PETSc's options as text | `options` |
//! | rows in 3×3 node blocks, held components as identity | `nodes` |
//! | the lock, handles, errors | `library` |
//! | `z ← M⁻¹ r` | `inverse` |
//! | ranks: sums, messages, agreement | `ranks` |
//! | entries that live on other ranks | `ghosts` |

#[cfg(feature = "petsc")]
pub(crate) mod ghosts;
#[cfg(feature = "petsc")]
mod inverse;
#[cfg(feature = "petsc")]
pub(crate) mod library;
#[cfg(feature = "petsc")]
mod nodes;
mod options;
#[cfg(feature = "petsc")]
mod ranks;

#[cfg(feature = "petsc")]
pub(crate) use inverse::{PRODUCTS_OF_FINEST_LEVEL, refused};
#[cfg(feature = "petsc")]
pub(crate) use nodes::index;
pub use options::{BadOptions, Options};
#[cfg(feature = "petsc")]
pub use ranks::{OnRank, Ranks};

use crate::steering;
use crate::{DofCoordinate, SetupError};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// PETSc's GAMG, one V-cycle: smoothed aggregation in node blocks with the rigid-body modes, Chebyshev around Jacobi as PETSc has it.
///
/// Needs the feature `petsc`.
///
/// # Errors
/// [`SetupError::NotBuilt`] without the feature; [`SetupError::NotApplicable`] with PETSc's sentence, or for an option that nothing
/// reads.
///
/// # Source
/// S. Balay et al., PETSc/TAO Users Manual, ANL-21/39 Rev. 3.18 (2022), PCGAMG.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gamg {
    /// Share below which a connection of two nodes is dropped, `-pc_gamg_threshold`; a negative one keeps all.
    pub threshold: f64,
    /// PETSc's options, as on its command line: `-pc_gamg_agg_nsmooths 1 -mg_levels_ksp_max_it 3`.
    pub options: Options,
}

impl Default for Gamg {
    /// PETSc's own.
    fn default() -> Self {
        Self {
            threshold: -1.0,
            options: Options::default(),
        }
    }
}

/// hypre's BoomerAMG as PETSc calls it, one V-cycle of classical multigrid with a function for each component.
///
/// Needs the feature `petsc`. hypre does not tell its operations: `flops()` counts the two symmetric sweeps of the finest level
/// alone, a lower bound.
///
/// # Errors
/// As [`Gamg`].
///
/// # Source
/// V. E. Henson & U. M. Yang, Appl. Numer. Math. 41 (2002) 155–177.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Boomeramg {
    /// Share of the largest entry of a row from which a connection is strong, `-pc_hypre_boomeramg_strong_threshold`.
    pub strong_threshold: f64,
    /// PETSc's options, as on its command line: `-pc_hypre_boomeramg_coarsen_type HMIS`.
    pub options: Options,
}

impl Default for Boomeramg {
    /// What hypre's manual advises in three dimensions.
    fn default() -> Self {
        Self {
            strong_threshold: 0.5,
            options: Options::default(),
        }
    }
}

steering! {
    Gamg:
    threshold [-1.0, 1.0],
}

steering! {
    Boomeramg:
    strong_threshold [0.0, 1.0],
}

/// A ready one.
type Built = Result<Box<dyn Preconditioner<f64>>, SetupError>;

impl Gamg {
    /// An approximate inverse of a symmetric positive definite matrix.
    ///
    /// # Errors
    /// See [`Gamg`].
    pub fn build(self, a: &SparseMatrix<f64>, coordinates: Option<&[DofCoordinate]>) -> Built {
        build(Multigrid::Gamg, a, coordinates, &self.text())
    }

    /// What PETSc reads.
    pub(crate) fn text(self) -> String {
        format!("-pc_gamg_threshold {} {}", self.threshold, self.options)
    }
}

impl Boomeramg {
    /// An approximate inverse of a symmetric positive definite matrix.
    ///
    /// # Errors
    /// See [`Gamg`].
    pub fn build(self, a: &SparseMatrix<f64>, coordinates: Option<&[DofCoordinate]>) -> Built {
        build(Multigrid::Boomeramg, a, coordinates, &self.text())
    }

    /// What PETSc reads.
    pub(crate) fn text(self) -> String {
        let (strong, own) = (self.strong_threshold, self.options);
        format!("-pc_hypre_boomeramg_strong_threshold {strong} {own}")
    }
}

/// Whose levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Multigrid {
    Gamg,
    Boomeramg,
}

impl Multigrid {
    /// As messages call it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Gamg => "GAMG",
            Self::Boomeramg => "BoomerAMG",
        }
    }
}

#[cfg(feature = "petsc")]
fn build(
    of: Multigrid,
    a: &SparseMatrix<f64>,
    coordinates: Option<&[DofCoordinate]>,
    options: &str,
) -> Built {
    Ok(Box::new(inverse::PetscInverse::new(
        of,
        a,
        coordinates,
        options,
    )?))
}

#[cfg(not(feature = "petsc"))]
fn build(of: Multigrid, _: &SparseMatrix<f64>, _: Option<&[DofCoordinate]>, _: &str) -> Built {
    Err(SetupError::NotBuilt {
        backend: of.name(),
        feature: "petsc",
    })
}
