//! How far the last digits of the entries of 𝒜 determine a solution.

use super::EnergyNorms;
use crate::direct::Factorization;
use fracas_operators::Fields;
use fracas_operators::random::signed;
use fracas_operators::sparse::SparseMatrix;

/// Changes of the entries that are tried. Unit: 1.
const TRIED: usize = 4;

/// `‖𝒜⁻¹δ‖`, field by field, for `δ_i = ½ε s_i Σ_j |𝒜_ij||x_j|` with random `s_i` in [−1, 1), the largest of four: what entries that are
/// rounded to f64 leave open of the solution x. A bound is `½ε |𝒜⁻¹||𝒜||x|`.
///
/// # Cost
/// Four solves and a pass over the matrix.
///
/// # Source
/// N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002, §7.2.
pub(super) fn left_open(
    matrix: &SparseMatrix<f64>,
    inverse: &dyn Factorization,
    norms: &EnergyNorms<'_>,
    x: &[f64],
) -> Fields<f64> {
    let mut rounding = vec![0.0; x.len()];
    for (a, (i, j)) in matrix {
        rounding[i as usize] += 0.5 * f64::EPSILON * (a * x[j as usize]).abs();
    }
    let mut work = vec![0.0; inverse.work_len()];
    let mut change = vec![0.0; x.len()];
    let mut most = norms.layout().values(0.0);
    for sample in 0..TRIED {
        let first = sample * x.len();
        let random = |(i, size): (usize, &f64)| size * signed((first + i) as u64);
        let delta: Vec<f64> = rounding.iter().enumerate().map(random).collect();
        inverse.solve(&delta, &mut change, &mut work);
        let moved = norms.error(&change);
        // NaN is no number that an answer has
        most = most.map(|field, most: f64| match moved[field].is_nan() {
            true => f64::INFINITY,
            false => most.max(moved[field]),
        });
    }
    most
}
