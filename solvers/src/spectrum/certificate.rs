//! A lower bound of the inf-sup constant from what lies around the fractures.

use crate::SetupError;
use crate::eigen::{Ends, LanczosSettings, dense, extreme_eigenvalues};
use crate::saddle::SaddleBlocks;
use faer::Mat;
use fracas_operators::sparse::{Csr, CsrView, SparseMatrix};
use fracas_operators::{AdjointOperator, LinearOperator};
use serde::Serialize;

/// `β² = λ_min(C₀⁻¹(S + H))` from below, S = BᵀA⁻¹B, `C₀ = diag(BᵀD⁻¹B)`, D = diag(A), by a diagonal D̃ with `A ⪯ D̃`:
/// ```text
/// β² ≥ λ_min(C₀⁻¹(BᵀD̃⁻¹B + H))
/// ```
/// a matrix of n_t rows. Proof: `A ⪯ D̃`, so `A⁻¹ ⪰ D̃⁻¹`; of a singular A the same holds for S as the limit of `A + ε D`.
/// With `C ⪯ κ C₀` the smallest eigenvalue of the exact-S_u spectrum is not below `min(1, β²/(β² + κ))`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Certificate {
    /// The bound of β²; 0 where nothing is proved.
    pub beta_squared: f64,
    /// Largest `D̃_ii / D_ii` where B has entries.
    pub omega: f64,
}

impl Certificate {
    /// The sharper one of two bounds.
    #[must_use]
    pub fn or(self, other: Option<Self>) -> Self {
        match other {
            Some(other) if other.beta_squared > self.beta_squared => other,
            _ => self,
        }
    }
}

/// What the bound depends on: B and H, and A where B has entries.
#[derive(Clone, Copy)]
pub struct AroundFractures<'a> {
    /// Rows may be those of some displacements, if B has no entries elsewhere.
    pub b: &'a dyn AdjointOperator<f64>,
    /// H, or 0.
    pub h: Option<&'a SparseMatrix<f64>>,
    /// D over the rows of B, positive.
    pub diagonal: &'a [f64],
    /// D̃ over the rows of B.
    pub above: &'a [f64],
    /// Diagonal of C₀; 0 for a traction that displaces nothing, which H alone has to hold: its own entry of H takes the place.
    pub c_0: &'a [f64],
}

/// Displacements up to which A is had dense.
const DENSE: usize = 600;

/// Tractions up to which their matrix is had dense: seconds.
const FEW: usize = 1500;

/// Share by which ω may be too large for Lanczos. Unit: 1.
const SHARE_OF_OMEGA: f64 = 0.03;

/// Share of the spectrum by which β² may be too small for Lanczos at first. Unit: 1.
const SHARE_OF_BETA: f64 = 0.002;

/// Share of β² that Lanczos may cost it before more steps are taken. Unit: 1.
const LOSS: f64 = 0.1;

/// Share of the spectrum below which a smallest eigenvalue is not looked for. Unit: 1.
const NONE: f64 = 1e-6;

/// Steps of Lanczos, and the same times rows, beyond which it is not begun again: some ten seconds.
const STEPS: usize = 6000;
const MOST: usize = 200_000_000;

/// Rounding of the eigenvalues of a dense matrix of so many rows. Unit: 1.
const ROUNDING: f64 = 1e-12;

/// The bound with `D̃ = ω D`, `ω ≥ λ_max(D⁻¹A)`; `None` without tractions, or where B2, A or H take the system out of the statement.
///
/// Ends of spectra are those of dense matrices up to 600 displacements, or 1500 tractions, and those that [`LanczosSettings::within`] bounds
/// above. Sums of rows bound ω, too; the smaller one is taken.
///
/// # Cost
/// Some 80 products with A, and those of [`AroundFractures::certificate`].
///
/// # Errors
/// [`SetupError`] for NaN.
pub fn certificate(blocks: &SaddleBlocks) -> Result<Option<Certificate>, SetupError> {
    let n_u = blocks.n_u();
    let diagonal: Vec<f64> = (0..n_u)
        .map(|i| blocks.a.get(i, i).copied().unwrap_or(0.0))
        .collect();
    let is_stated = n_u > 0 && blocks.n_t() > 0 && blocks.b2.is_none();
    if !is_stated || diagonal.iter().any(|d| d.is_nan() || *d <= 0.0) {
        return Ok(None);
    }
    let omega = omega(&blocks.a, &diagonal)?;
    let above: Vec<f64> = diagonal.iter().map(|d| omega * d).collect();
    let mut c_0 = vec![0.0; blocks.n_t()];
    for (row, d) in blocks.b1.outer_iterator().zip(&diagonal) {
        row.iter().for_each(|(k, b)| c_0[k] += b * b / d);
    }
    let around = AroundFractures {
        b: &Csr::with_transpose(blocks.b1.clone()),
        h: blocks.h.as_ref(),
        diagonal: &diagonal,
        above: &above,
        c_0: &c_0,
    };
    around.certificate()
}

/// `λ_max(D⁻¹A)` from above.
fn omega(a: &SparseMatrix<f64>, diagonal: &[f64]) -> Result<f64, SetupError> {
    let n = diagonal.len();
    let root: Vec<f64> = diagonal.iter().map(|d| d.sqrt()).collect();
    if n <= DENSE {
        let mut scaled = dense::to_dense(a);
        (0..n).for_each(|j| (0..n).for_each(|i| scaled[(i, j)] /= root[i] * root[j]));
        dense::symmetrize(&mut scaled);
        let values = dense::symmetric_eigenvalues(scaled.as_ref())?;
        return Ok(values[n - 1] * (1.0 + ROUNDING));
    }
    let rows = CsrView::new(a);
    let mut v = vec![0.0; n];
    let mut scaled = |x: &[f64], y: &mut [f64]| {
        for i in 0..n {
            v[i] = x[i] / root[i];
        }
        rows.apply(&v, y, &mut []);
        y.iter_mut().zip(&root).for_each(|(y, d)| *y /= d);
    };
    let settings = LanczosSettings::within(n, SHARE_OF_OMEGA, Ends::Largest);
    let (_, largest) = extreme_eigenvalues(n, &mut scaled, None, settings)?;
    let of_row = |(row, d): (sprs::CsVecViewI<'_, f64, u32>, &f64)| {
        row.iter().map(|(j, a)| a.abs() / (d * root[j])).sum()
    };
    let sums = a.outer_iterator().zip(&root).map(of_row);
    Ok((largest.value / (1.0 - SHARE_OF_OMEGA)).min(sums.fold(0.0, f64::max)))
}

impl AroundFractures<'_> {
    /// The bound; `None` without tractions.
    ///
    /// Above 1500 tractions it is that of Lanczos, as in [`certificate`], which is begun again with more steps while its share costs more than
    /// a tenth of β² and the steps are worth their time.
    ///
    /// # Cost
    /// 300 to 5,000 products with B, its adjoint and H, and seven vectors.
    ///
    /// # Errors
    /// [`SetupError`] for NaN.
    pub fn certificate(&self) -> Result<Option<Certificate>, SetupError> {
        let n = self.c_0.len();
        if n == 0 {
            return Ok(None);
        }
        let scale = |(k, c): (usize, &f64)| match *c == 0.0 {
            true => self
                .h
                .and_then(|h| h.get(k, k).copied())
                .filter(|h| *h > 0.0),
            false => Some(*c),
        };
        let scales = self.c_0.iter().enumerate().map(scale);
        let weight: Vec<f64> = scales.map(|c| c.unwrap_or(1.0).sqrt().recip()).collect();
        let h = self.h.map(CsrView::new);
        let (mut t, mut u) = (vec![0.0; n], vec![0.0; self.above.len()]);
        let mut product = |x: &[f64], y: &mut [f64]| {
            (0..n).for_each(|k| t[k] = weight[k] * x[k]);
            self.b.apply(&t, &mut u, &mut []);
            u.iter_mut().zip(self.above).for_each(|(u, d)| *u /= d);
            y.fill(0.0);
            self.b.apply_adjoint_add(1.0, &u, y, &mut []);
            if let Some(h) = &h {
                h.apply_add(1.0, &t, y, &mut []);
            }
            y.iter_mut().zip(&weight).for_each(|(y, w)| *y *= w);
        };
        let least = match n <= FEW {
            true => {
                let mut matrix = Mat::zeros(n, n);
                let (mut e, mut column) = (vec![0.0; n], vec![0.0; n]);
                for k in 0..n {
                    e[k] = 1.0;
                    product(&e, &mut column);
                    e[k] = 0.0;
                    (0..n).for_each(|i| matrix[(i, k)] = column[i]);
                }
                dense::symmetrize(&mut matrix);
                let values = dense::symmetric_eigenvalues(matrix.as_ref())?;
                values[0] - ROUNDING * values[n - 1]
            }
            false => smallest(n, &mut product)?,
        };
        let ratios = self.above.iter().zip(self.diagonal).map(|(a, d)| a / d);
        Ok(Some(Certificate {
            beta_squared: least.max(0.0),
            omega: ratios.fold(0.0, f64::max),
        }))
    }
}

/// Smallest eigenvalue of a positive semi-definite matrix from below.
fn smallest(n: usize, product: &mut dyn FnMut(&[f64], &mut [f64])) -> Result<f64, SetupError> {
    let mut share = SHARE_OF_BETA;
    loop {
        let settings = LanczosSettings::within(n, share, Ends::Both);
        let (low, high) = extreme_eigenvalues(n, product, None, settings)?;
        let most = high.value / (1.0 - share);
        // the largest eigenvalue of `most − (…)`
        let least = most - (most - low.value) / (1.0 - share);
        let is_sharp = least >= (1.0 - LOSS) * low.value || low.value <= NONE * most;
        // four times the steps for a sixteenth of the share
        let next = 4 * settings.max_steps;
        if is_sharp || next > STEPS || next * n > MOST {
            return Ok(least);
        }
        share /= 16.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direct::DirectChoice;
    use crate::saddle::AugmentationChoice;
    use crate::saddle::samples::{random, trusses};

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
    fn nothing_is_stated_without_displacements_and_nothing_proved_of_a_kernel() {
        let mut blocks = random(8, 3, 0.0, 5);
        // two tractions that do the same
        let entry = |i: usize, k: usize| if k < 2 { 1.0 } else { i as f64 };
        blocks.b1 = crate::saddle::samples::sparse(8, 3, entry);
        let found = certificate(&blocks).unwrap().unwrap();
        assert_eq!(found.beta_squared, 0.0);
        blocks.a = crate::saddle::samples::sparse(0, 0, |_, _| 0.0);
        blocks.b1 = crate::saddle::samples::sparse(0, 3, |_, _| 0.0);
        (blocks.rhs_u, blocks.coordinates) = (Vec::new(), None);
        assert_eq!(certificate(&blocks).unwrap(), None);
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
