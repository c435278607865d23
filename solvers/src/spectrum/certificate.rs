//! A lower bound of the inf-sup constant from what lies around the fractures.

use crate::SetupError;
use crate::eigen::{Ends, LanczosSettings, dense, extreme_eigenvalues};
use crate::saddle::SaddleBlocks;
use fracas_operators::LinearOperator;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use serde::Serialize;

/// `β² = λ_min(C₀⁻¹(S + H))` from below, S = BᵀA⁻¹B, `C₀ = diag(BᵀD⁻¹B)`, D = diag(A):
/// ```text
/// β² ≥ λ_min(C₀⁻¹(BᵀD⁻¹B/ω + H))      ω ≥ λ_max(D⁻¹A)
/// ```
/// a sparse n_t × n_t matrix. Proof: `A ⪯ ω D`, so `A⁻¹ ⪰ D⁻¹/ω`; of a singular A the same holds for S as the limit of `A + ε D`.
/// With `C ⪯ κ C₀` the smallest eigenvalue of the exact-S_u spectrum is not below `min(1, β²/(β² + κ))`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// The bound of β²; 0 where nothing is proved.
    pub beta_squared: f64,
    /// ω.
    pub omega: f64,
}

/// Rows up to which a matrix is had dense.
const DENSE: usize = 600;

/// Chance that an end of a spectrum by Lanczos is not a bound. Unit: 1.
const CHANCE: f64 = 1e-9;

/// Share by which ω may be too large for Lanczos. Unit: 1.
const SHARE_OF_OMEGA: f64 = 0.03;

/// Share of the spectrum by which β² may be too small for Lanczos. Unit: 1.
const SHARE_OF_BETA: f64 = 0.002;

/// Rounding of the eigenvalues of a dense matrix of so many rows. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// So many steps that an end is too far inside by more than this share of the spectrum in one of 10⁹ cases.
fn steps(n: usize, share: f64, ends: Ends) -> LanczosSettings {
    let needed = (1.648 * (n as f64).sqrt() / CHANCE).ln() / share.sqrt();
    let steps = (0.5 * (needed + 1.0)).ceil() as usize;
    LanczosSettings {
        max_steps: steps,
        patience: steps,
        ends,
        ..LanczosSettings::default()
    }
}

/// The bound; `None` without tractions, or where B2, A or H take the system out of the statement.
///
/// Ends of spectra are those of dense matrices up to 600 rows. Of larger ones the largest Ritz value of k steps of Lanczos from a start drawn
/// at random is below `(1 − ε) λ_max` at most in `1.648 √n e^{−√ε (2k − 1)}` of all cases, however eigenvalues lie: k and ε are such that
/// this is 1e-9. The start is one such draw, the same for every matrix. What residuals say is that some eigenvalue is near, not that the
/// largest is. Sums of rows bound ω, too; the smaller one is taken.
///
/// # Cost
/// Some 80 products with A, and 300 with a matrix of n_t rows.
///
/// # Source
/// J. Kuczyński, H. Woźniakowski, SIAM J. Matrix Anal. Appl. 13 (1992) 1094–1122, Theorem 4.2.
///
/// # Errors
/// [`SetupError`] for NaN.
pub fn certificate(blocks: &SaddleBlocks) -> Result<Option<Certificate>, SetupError> {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let diagonal: Vec<f64> = (0..n_u)
        .map(|i| blocks.a.get(i, i).copied().unwrap_or(0.0))
        .collect();
    if n_t == 0 || blocks.b2.is_some() || diagonal.iter().any(|d| d.is_nan() || *d <= 0.0) {
        return Ok(None);
    }
    let root: Vec<f64> = diagonal.iter().map(|d| d.sqrt()).collect();
    let omega = match n_u <= DENSE {
        true => {
            let mut scaled = dense::to_dense(&blocks.a);
            (0..n_u).for_each(|j| {
                (0..n_u).for_each(|i| scaled[(i, j)] /= root[i] * root[j]);
            });
            dense::symmetrize(&mut scaled);
            let values = dense::symmetric_eigenvalues(scaled.as_ref())?;
            values[n_u - 1] * (1.0 + ROUNDING)
        }
        false => {
            let a = Csr::new(blocks.a.clone());
            let mut v = vec![0.0; n_u];
            let mut scaled = |x: &[f64], y: &mut [f64]| {
                for i in 0..n_u {
                    v[i] = x[i] / root[i];
                }
                a.apply(&v, y, &mut []);
                y.iter_mut().zip(&root).for_each(|(y, d)| *y /= d);
            };
            let settings = steps(n_u, SHARE_OF_OMEGA, Ends::Largest);
            let (_, largest) = extreme_eigenvalues(n_u, &mut scaled, None, settings)?;
            let rows = blocks.a.outer_iterator().zip(&root);
            let of_row = |(row, d): (sprs::CsVecViewI<'_, f64, u32>, &f64)| {
                row.iter().map(|(j, a)| a.abs() / (d * root[j])).sum()
            };
            let sums = rows.map(of_row).fold(0.0, f64::max);
            (largest.value / (1.0 - SHARE_OF_OMEGA)).min(sums)
        }
    };

    // X = D^{-1/2} B C₀^{-1/2}
    let mut c_0 = vec![0.0; n_t];
    for (i, row) in blocks.b1.outer_iterator().enumerate() {
        row.iter().for_each(|(k, b)| c_0[k] += b * b / diagonal[i]);
    }
    if c_0.contains(&0.0) {
        // a traction that displaces nothing: H alone would have to hold it
        c_0.iter_mut().filter(|c| **c == 0.0).for_each(|c| *c = 1.0);
    }
    let weight: Vec<f64> = c_0.iter().map(|c| c.sqrt()).collect();
    let mut sum = Triplets::new((n_t, n_t));
    let mut add = |i: usize, j: usize, v: f64| sum.add_triplet(i, j, v / (weight[i] * weight[j]));
    for (i, row) in blocks.b1.outer_iterator().enumerate() {
        for (k, b) in row.iter() {
            for (l, c) in row.iter() {
                add(k, l, b * c / (diagonal[i] * omega));
            }
        }
    }
    if let Some(h) = &blocks.h {
        for (k, row) in h.outer_iterator().enumerate() {
            row.iter().for_each(|(l, h)| add(k, l, *h));
        }
    }
    let sum: SparseMatrix<f64> = sum.to_csr();
    let least = match n_t <= DENSE {
        true => dense::symmetric_eigenvalues(dense::to_dense(&sum).as_ref())?[0],
        false => {
            let of_row =
                |row: sprs::CsVecViewI<'_, f64, u32>| row.data().iter().map(|v| v.abs()).sum();
            let most = sum.outer_iterator().map(of_row).fold(0.0, f64::max);
            let sum = Csr::new(sum);
            let mut product = |x: &[f64], y: &mut [f64]| sum.apply(x, y, &mut []);
            let settings = steps(n_t, SHARE_OF_BETA, Ends::Both);
            let (low, _) = extreme_eigenvalues(n_t, &mut product, None, settings)?;
            // the largest eigenvalue of `s − (…)`, s not below its own
            most - (most - low.value) / (1.0 - SHARE_OF_BETA)
        }
    };
    let beta_squared = least.max(0.0);
    Ok(Some(Certificate {
        beta_squared,
        omega,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct::DirectChoice;
    use crate::saddle::AugmentationChoice;
    use crate::saddle::samples::{random, trusses};
    use faer::Mat;

    /// β² from S + H itself.
    fn truth(blocks: &SaddleBlocks) -> f64 {
        let direct = DirectChoice::Faer.solver().unwrap();
        let exact = AugmentationChoice::ExactH;
        let k = exact.compute(blocks, direct.as_ref()).unwrap().matrix;
        let k = k.to_dense();
        let c_0: Vec<f64> = (0..blocks.n_t())
            .map(|k| {
                let entry = |i: usize| blocks.b1.get(i, k).map_or(0.0, |b| b * b);
                (0..blocks.n_u())
                    .map(|i| entry(i) / blocks.a.get(i, i).unwrap())
                    .sum()
            })
            .collect();
        let n = c_0.len();
        let scaled = Mat::from_fn(n, n, |i, j| k[(i, j)] / (c_0[i] * c_0[j]).sqrt());
        dense::symmetric_eigenvalues(scaled.as_ref()).unwrap()[0]
    }

    #[test]
    fn it_lies_below_the_inf_sup_constant() {
        for seed in 0..200 {
            let n_u = 6 + seed as usize % 9;
            let h = [0.0, 0.05, 1.0][seed as usize % 3];
            let blocks = random(n_u, 1 + seed as usize % 5, h, 700 + seed);
            let found = certificate(&blocks).unwrap().unwrap();
            let beta = truth(&blocks);
            assert!(found.beta_squared <= beta * (1.0 + 1e-9), "{seed}");
            assert!(
                found.omega >= 1.0 && found.beta_squared > 0.0,
                "{seed}: {found:?}"
            );
        }
        for contrast in [1.0, 1e3] {
            let blocks = trusses(3, contrast, false);
            let found = certificate(&blocks).unwrap().unwrap();
            assert!(found.beta_squared <= truth(&blocks), "{contrast}");
        }
    }

    #[test]
    fn with_an_omega_that_is_too_small_it_would_not() {
        // A = D gives ω = 1 and equality; half of ω doubles the bound
        let mut blocks = random(8, 3, 0.0, 5);
        blocks.a =
            crate::saddle::samples::sparse(8, 8, |i, j| if i == j { 1.0 + i as f64 } else { 0.0 });
        let found = certificate(&blocks).unwrap().unwrap();
        let beta = truth(&blocks);
        assert!((found.beta_squared / beta - 1.0).abs() < 1e-9);
        assert!(2.0 * found.beta_squared > beta);
        blocks.b2 = Some(blocks.b1.transpose_view().to_csr());
        assert_eq!(certificate(&blocks).unwrap(), None);
    }
}
