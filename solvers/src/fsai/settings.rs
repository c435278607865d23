//! Plain settings of FSAI.

use super::FsaiInverse;
use crate::steering;
use crate::{Prepare, SetupError};
use fracas_operators::Preconditioner;
use fracas_operators::sparse::SparseMatrix;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Factorized sparse approximate inverse `M⁻¹ = GᵀG`, G lower triangular with `diag(G A Gᵀ) = 1`.
///
/// On its pattern every row minimises the Kaporin number `tr(GAGᵀ)/n / det(GAGᵀ)^{1/n}` of an SPD A. A is read by rows and
/// taken to be symmetric.
///
/// # Errors
/// [`SetupError::BadDiagonal`], [`SetupError::NotFinite`], [`SetupError::NotPositiveDefinite`] for an indefinite or
/// numerically singular `A[P, P]`, with the row.
///
/// # Source
/// L. Yu. Kolotilina & A. Yu. Yeremin, SIAM J. Matrix Anal. Appl. 14 (1993) 45–58.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Fsai {
    /// Where the pattern of G comes from.
    pub kind: FsaiKind,
}

/// Where the pattern of G comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FsaiKind {
    /// It grows row by row.
    Adaptive(Adaptive),
    /// From powers of A.
    Static(Static),
}

impl Default for FsaiKind {
    fn default() -> Self {
        Self::Adaptive(Adaptive::default())
    }
}

/// Row i takes in the columns with the largest gradient `g_j² / a_jj`, `g_j = a_ij + Σ_l y_l a_lj`, step by step.
///
/// The division by a_jj makes the pattern that of the Jacobi-scaled matrix: it does not depend on the units of the unknowns.
///
/// # Source
/// C. Janna & M. Ferronato, SIAM J. Sci. Comput. 33 (2011) 3357–3380.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Adaptive {
    /// Most steps per row.
    pub steps: usize,
    /// Columns per step.
    pub entries_per_step: usize,
    /// A row is finished when a step lowers `1/G_ii²` by less than this fraction.
    pub epsilon: f64,
}

impl Default for Adaptive {
    /// The group's published choice for the blocks of the mixed constraint preconditioner.
    fn default() -> Self {
        Self {
            steps: 30,
            entries_per_step: 1,
            epsilon: 1e-3,
        }
    }
}

/// Pattern = lower triangle of Ã^power, Ã without the entries `|a_ij| < filter √(a_ii a_jj)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Static {
    /// Power of the filtered matrix; 1 is its own pattern, 0 the diagonal.
    pub power: usize,
    /// Fraction below which entries of A do not enter the pattern.
    pub filter: f64,
}

impl Default for Static {
    fn default() -> Self {
        Self {
            power: 1,
            filter: 0.0,
        }
    }
}

// a row of so many steps, or a pattern of such a power, is dense
steering! {
    Adaptive:
    steps [0.0, 1e4],
    entries_per_step [0.0, 1e4],
}

steering! {
    Static:
    power [0.0, 20.0],
}

impl Fsai {
    /// An adaptive pattern.
    pub fn adaptive(steps: usize, entries_per_step: usize, epsilon: f64) -> Self {
        Self {
            kind: FsaiKind::Adaptive(Adaptive {
                steps,
                entries_per_step,
                epsilon,
            }),
        }
    }

    /// The pattern of the power of A, nothing filtered.
    pub fn of_power(power: usize) -> Self {
        Self {
            kind: FsaiKind::Static(Static {
                power,
                ..Static::default()
            }),
        }
    }

    /// G for an SPD `a`.
    ///
    /// # Errors
    /// See [`Fsai`].
    pub fn build(&self, a: &SparseMatrix<f64>) -> Result<FsaiInverse<f64>, SetupError> {
        FsaiInverse::new(a, *self)
    }
}

impl Prepare<SparseMatrix<f64>, f64> for Fsai {
    fn prepare(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        Ok(Box::new(self.build(a)?))
    }
}
