//! Damped Jacobi by points or by nodes.

use super::entries::{BLOCK, positive_diagonal, relaxation, rows};
use crate::{Prepare, SetupError};
use fracas_operators::small::{Matrix3, times};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which part of A is inverted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum JacobiBlock {
    /// Its diagonal.
    #[default]
    Point,
    /// Its 3×3 diagonal blocks, one per node or face.
    Node,
}

/// Damped Jacobi: `M⁻¹ = ω D⁻¹`, D the diagonal or the 3×3 diagonal blocks of A.
///
/// # Cost
/// `n` or `5 n` flops; set-up reads the diagonal.
///
/// # Errors
/// [`SetupError::BadDiagonal`], [`SetupError::NotPositiveDefinite`] for a 3×3 block, [`SetupError::NotApplicable`]
/// for `ω ≤ 0`, `ω ≥ 2` or a size that is no multiple of 3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Jacobi {
    /// Damping ω in (0, 2).
    #[serde(deserialize_with = "super::entries::omega")]
    pub omega: f64,
    /// Points or nodes.
    pub block: JacobiBlock,
}

impl Default for Jacobi {
    fn default() -> Self {
        Self {
            omega: 1.0,
            block: JacobiBlock::Point,
        }
    }
}

impl Prepare<SparseMatrix<f64>, f64> for Jacobi {
    fn prepare(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        Ok(Box::new(JacobiInverse::new(a, *self)?))
    }
}

/// `ω D⁻¹`, ready to multiply.
#[derive(Clone, Debug)]
pub enum JacobiInverse {
    /// `ω / a_ii`.
    Point(Vec<f64>),
    /// Inverse 3×3 blocks times ω.
    Node(Vec<Matrix3<f64>>),
}

impl JacobiInverse {
    /// From the entries of `a`.
    pub fn new(a: &SparseMatrix<f64>, settings: Jacobi) -> Result<Self, SetupError> {
        let a = rows(a)?;
        relaxation(settings.omega, 2.0, "jacobi")?;
        let diagonal = positive_diagonal(&a, "jacobi")?;
        match settings.block {
            JacobiBlock::Point => Ok(Self::Point(
                diagonal.iter().map(|d| settings.omega / d).collect(),
            )),
            JacobiBlock::Node if a.rows() % 3 != 0 => Err(SetupError::NotApplicable {
                method: "jacobi",
                reason: format!("{} rows are no whole number of 3×3 blocks", a.rows()),
            }),
            JacobiBlock::Node => (0..a.rows() / 3)
                .map(|node| {
                    let entry = |i: usize, j: usize| {
                        let value = a.get(3 * node + i, 3 * node + j);
                        value.copied().unwrap_or(0.0)
                    };
                    let block = std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)));
                    scaled_inverse(block, settings.omega).map_err(|minor| {
                        SetupError::NotPositiveDefinite {
                            block: BLOCK,
                            row: 3 * node + minor,
                            advice: "the 3×3 block of this row has a non-positive leading minor; \
                                     use points instead of nodes"
                                .into(),
                        }
                    })
                })
                .collect::<Result<_, _>>()
                .map(Self::Node),
        }
    }
}

/// `ω B⁻¹ = ω adj(B)/det(B)`, or the size of the first leading minor that rounding cannot tell from zero.
fn scaled_inverse(b: Matrix3<f64>, omega: f64) -> Result<Matrix3<f64>, usize> {
    // cofactor of (i, j), rows and columns in cyclic order
    let cofactor = |i: usize, j: usize| {
        let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
        b[i1][j1] * b[i2][j2] - b[i1][j2] * b[i2][j1]
    };
    let determinant: f64 = (0..3).map(|k| b[0][k] * cofactor(0, k)).sum();
    let rounding = 10.0 * f64::EPSILON;
    if cofactor(2, 2) <= rounding * b[0][0] * b[1][1] {
        return Err(2);
    }
    if determinant <= rounding * b[0][0] * b[1][1] * b[2][2] {
        return Err(3);
    }
    Ok(std::array::from_fn(|i| {
        std::array::from_fn(|j| omega * cofactor(j, i) / determinant)
    }))
}

impl Preconditioner<f64> for JacobiInverse {
    fn size(&self) -> usize {
        match self {
            Self::Point(inverse) => inverse.len(),
            Self::Node(inverse) => 3 * inverse.len(),
        }
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _work: &mut [f64]) {
        assert!(r.len() == self.size() && z.len() == self.size());
        match self {
            Self::Point(inverse) => {
                for ((z, r), d) in z.iter_mut().zip(r).zip(inverse) {
                    *z = d * r;
                }
            }
            Self::Node(inverse) => {
                let (z, r) = (z.as_chunks_mut().0, r.as_chunks().0);
                for ((z, r), d) in z.iter_mut().zip(r).zip(inverse) {
                    *z = times(d, r);
                }
            }
        }
    }

    fn flops(&self) -> u64 {
        match self {
            Self::Point(inverse) => inverse.len() as u64,
            Self::Node(inverse) => 15 * inverse.len() as u64,
        }
    }

    fn properties(&self) -> Properties {
        Properties::LOCAL
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{sparse, stiffness};
    use super::*;
    use fracas_operators::laws::check_preconditioner;
    use fracas_operators::{Dense, LinearOperator, Shape};

    fn node() -> Jacobi {
        Jacobi {
            omega: 0.7,
            block: JacobiBlock::Node,
        }
    }

    #[test]
    fn obeys_the_laws_of_a_preconditioner() {
        let a = stiffness(30);
        for settings in [Jacobi::default(), node()] {
            let m = settings.prepare(&a).unwrap();
            check_preconditioner("jacobi", &m, None, 0.0).unwrap();
        }
    }

    #[test]
    fn inverts_the_diagonal_and_the_diagonal_blocks() {
        let a = stiffness(30);
        for (settings, width) in [
            (
                Jacobi {
                    omega: 0.7,
                    ..Jacobi::default()
                },
                1,
            ),
            (node(), 3),
        ] {
            let kept = Dense::from_fn(Shape::square(30), |i, j| {
                let inside = i / width == j / width;
                if inside {
                    a.get(i, j).copied().unwrap_or(0.0) / 0.7
                } else {
                    0.0
                }
            });
            let m = settings.prepare(&a).unwrap();
            check_preconditioner("jacobi", &m, Some(&kept as &dyn LinearOperator<f64>), 1e-13)
                .unwrap();
        }
    }

    #[test]
    fn names_the_row_that_is_wrong() {
        let missing = sparse(3, &[(0, 0, 1.0), (2, 2, 1.0)]);
        let error = JacobiInverse::new(&missing, Jacobi::default()).unwrap_err();
        assert!(matches!(error, SetupError::BadDiagonal { row: 2, .. }));
        let ones: Vec<_> = (0..9).map(|k| (k / 3, k % 3, 1.0)).collect();
        let error = JacobiInverse::new(&sparse(3, &ones), node()).unwrap_err();
        assert!(matches!(
            error,
            SetupError::NotPositiveDefinite { row: 2, .. }
        ));
        let nan = sparse(
            3,
            &[(0, 0, 1.0), (1, 1, 1.0), (1, 2, f64::NAN), (2, 2, 1.0)],
        );
        let error = JacobiInverse::new(&nan, Jacobi::default()).unwrap_err();
        assert!(matches!(
            error,
            SetupError::NotFinite {
                row: 2,
                column: 3,
                ..
            }
        ));
        let four = sparse(4, &[(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (3, 3, 1.0)]);
        let error = JacobiInverse::new(&four, node()).unwrap_err();
        assert!(matches!(error, SetupError::NotApplicable { .. }));
    }
}
