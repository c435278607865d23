//! Symmetric scaling to a unit diagonal.

use crate::SetupError;
use crate::direct::{DirectSolver, Factorization, Kind, reciprocal_condition};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};

/// 1/κ₁ of a matrix with unit diagonal below which it counts as singular. Unit: 1.
const SINGULAR: f64 = 1e-13;

/// `Â = D⁻¹ A D⁻¹` with `diag Â = 1`, and `D⁻¹`.
#[derive(Clone, Debug)]
pub(crate) struct Scaled {
    /// Â.
    pub(crate) matrix: SparseMatrix<f64>,
    /// Diagonal of D⁻¹.
    pub(crate) inverse_scale: Vec<f64>,
}

/// Scales a symmetric matrix by the square roots of its diagonal.
///
/// Material contrast and units leave the condition number of Â alone, so a test for singularity means something there.
///
/// # Errors
/// [`SetupError::BadDiagonal`] when an entry is not positive.
pub(crate) fn symmetric_scaling(a: &SparseMatrix<f64>) -> Result<Scaled, SetupError> {
    let inverse_scale = (0..a.rows())
        .map(|i| match a.get(i, i) {
            Some(&value) if value > 0.0 => Ok(1.0 / value.sqrt()),
            other => Err(SetupError::BadDiagonal {
                block: "A",
                row: i + 1,
                value: other.copied().unwrap_or(0.0),
                method: "symmetric scaling",
            }),
        })
        .collect::<Result<Vec<f64>, _>>()?;
    let mut matrix = a.clone();
    for (i, mut row) in matrix.outer_iterator_mut().enumerate() {
        for (j, value) in row.iter_mut() {
            *value *= inverse_scale[i] * inverse_scale[j];
        }
    }
    Ok(Scaled {
        matrix,
        inverse_scale,
    })
}

/// `A⁻¹ = D⁻¹ Â⁻¹ D⁻¹` with a Cholesky factorization of Â, for an A that is not singular to working precision.
pub(crate) struct ScaledInverse {
    /// Factors of Â.
    pub(crate) factors: Box<dyn Factorization>,
    /// Diagonal of D⁻¹.
    pub(crate) inverse_scale: Vec<f64>,
}

impl ScaledInverse {
    /// Scales, factorizes and estimates the condition number.
    ///
    /// # Errors
    /// Those of the factorization, and [`SetupError::Singular`] where rounding let a singular matrix pass; all name
    /// `block`.
    pub(crate) fn new(
        a: &SparseMatrix<f64>,
        direct: &dyn DirectSolver,
        block: &'static str,
    ) -> Result<Self, SetupError> {
        let Scaled {
            matrix,
            inverse_scale,
        } = symmetric_scaling(a).map_err(|error| error.in_block(block))?;
        let factors = direct
            .analyze(&matrix, Kind::Spd)?
            .factor(&matrix)
            .map_err(|error| error.in_block(block))?;
        let reciprocal = reciprocal_condition(&matrix, factors.as_ref());
        if reciprocal.is_nan() || reciprocal < SINGULAR {
            return Err(SetupError::Singular {
                block,
                row: None,
                advice: format!("1/condition is {reciprocal:.1e} after scaling"),
            });
        }
        Ok(Self {
            factors,
            inverse_scale,
        })
    }
}

impl Preconditioner<f64> for ScaledInverse {
    fn size(&self) -> usize {
        self.inverse_scale.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (scaled, work) = work.split_at_mut(r.len());
        let d = &self.inverse_scale;
        scaled
            .iter_mut()
            .zip(r)
            .zip(d)
            .for_each(|((s, r), d)| *s = r * d);
        self.factors.solve(scaled, z, work);
        z.iter_mut().zip(d).for_each(|(z, d)| *z *= d);
    }

    fn work_len(&self) -> usize {
        self.size() + self.factors.work_len()
    }

    fn flops(&self) -> u64 {
        self.factors.flops() + 2 * self.size() as u64
    }

    fn properties(&self) -> Properties {
        self.factors.properties()
    }
}
