//! Symmetric scaling to a unit diagonal.

use crate::SetupError;
use fracas_operators::sparse::SparseMatrix;

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
