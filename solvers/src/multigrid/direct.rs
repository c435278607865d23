//! The direct solver of a coarsest level, on its matrix scaled to a unit diagonal, which makes "singular" a matter of digits.
//!
//! Where functions of the level may depend on each other `A_c = PᵀA P` is singular where columns of P depend on each other, and `b_c = Pᵀr` is in its range all the same. A correction
//! `P A_c⁺ b_c` needs no more than columns that span the same space: unknowns that depend on others are left out.

use super::LevelSummary;
use crate::SetupError;
use crate::direct::{DirectSolver, Factorization, Faer, Kind};
use crate::eigen::dense;
use faer::Mat;
use fracas_operators::random::signed;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::dot;
use fracas_operators::{Preconditioner, Properties};

/// Unknowns up to which the inverse is stored.
const DENSE: usize = 1000;

/// Pivot of the matrix scaled to a unit diagonal up to which its unknown depends on those before it. Unit: 1; the functions then
/// differ from a combination of those by 1e-6 of their energy norm, and the rounding of their sums in f64 is a thousandth of it.
const DEPENDENT: f64 = 1e-12;

/// Pivot that leaves an unknown out. Unit: 1.
const LEFT_OUT: f64 = 1e100;

/// `A⁻¹`, or `A⁺` in the sense that `A x = b` for every b in the range of A, x zero in the unknowns that are left out.
pub struct Direct {
    factors: Factors,
    /// `1/√a_ii`, 0 where left out.
    scale: Vec<f64>,
    /// Unknowns that depend on others, ascending.
    left_out: Vec<usize>,
    /// `A n ≈ 0`, where unknowns are left out.
    null: Option<Vec<f64>>,
}

/// Of the scaled matrix.
pub(super) enum Factors {
    /// Its inverse, row by row.
    Dense(Vec<f64>),
    /// Cholesky factors.
    Sparse(Box<dyn Factorization>),
    /// The same in f32.
    Single {
        inverse: Box<dyn Preconditioner<f64>>,
        entries: usize,
    },
}

impl Direct {
    /// Factorizes a positive definite matrix, both triangles stored.
    ///
    /// # Errors
    /// [`SetupError::BadDiagonal`]; [`SetupError::NotPositiveDefinite`] with the row that depends on those before it; those of the
    /// sparse solver.
    pub fn definite(mut a: SparseMatrix<f64>) -> Result<Self, SetupError> {
        let scale = equilibrate(&mut a)?;
        let factors = if scale.len() <= DENSE {
            let singular = |row: usize| SetupError::NotPositiveDefinite {
                block: "A",
                row: row + 1,
                advice: "the matrix of the coarsest level is singular".into(),
            };
            let l = dense::cholesky(dense::to_dense(&a)).map_err(singular)?;
            if let Some(row) = (0..scale.len()).find(|i| l[(*i, *i)].powi(2) < DEPENDENT) {
                return Err(singular(row));
            }
            dense_inverse(&l)
        } else {
            Factors::Sparse(Faer.analyze(&a, Kind::Spd)?.factor(&a)?)
        };
        Ok(Self {
            factors,
            scale,
            left_out: Vec::new(),
            null: None,
        })
    }

    /// Factorizes a positive semidefinite matrix with a positive diagonal, both triangles stored.
    ///
    /// # Errors
    /// [`SetupError::BadDiagonal`], [`SetupError::OutOfMemory`], [`SetupError::NotFinite`].
    pub fn semidefinite(mut a: SparseMatrix<f64>) -> Result<Self, SetupError> {
        let scale = equilibrate(&mut a)?;
        let n = scale.len();
        let (factors, left_out) = match n <= DENSE {
            true => independent_inverse(&a)?,
            false => {
                let (factors, left_out) = Faer.independent(&a, DEPENDENT)?;
                (Factors::Sparse(factors), left_out)
            }
        };
        let kept = |i: &usize| left_out.binary_search(i).is_err();
        let factor = |i: usize| if kept(&i) { scale[i] } else { 0.0 };
        let mut direct = Self {
            factors,
            scale: vec![1.0; n],
            null: None,
            left_out: Vec::new(),
        };
        if !left_out.is_empty() {
            // n = s − A⁺ A s over the unknowns that are kept, s random signs of the others
            let mut null = vec![0.0; n];
            left_out.iter().for_each(|i| null[*i] = signed(*i as u64));
            let mut r = vec![0.0; n];
            for (i, row) in a.outer_iterator().enumerate().filter(|(i, _)| kept(i)) {
                r[i] = row.iter().map(|(j, v)| v * null[j]).sum();
            }
            let mut z = vec![0.0; n];
            direct.solve(&r, &mut z, &mut vec![0.0; direct.work_len()]);
            for i in 0..n {
                null[i] = scale[i] * (null[i] - if kept(&i) { z[i] } else { 0.0 });
            }
            direct.null = Some(null);
        }
        direct.scale = (0..n).map(factor).collect();
        direct.left_out = left_out;
        Ok(direct)
    }

    /// With factors in f32, where these are sparse and have the digits.
    pub(super) fn rounded(mut self) -> Self {
        if let Factors::Sparse(factors) = &self.factors
            && let Some(inverse) = factors.in_single()
        {
            let entries = factors.factor_entries();
            self.factors = Factors::Single { inverse, entries };
        }
        self
    }

    pub(super) fn factors(&self) -> &Factors {
        &self.factors
    }

    /// `1/√a_ii`, 0 where left out.
    pub(super) fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// A random vector that A maps to rounding, where unknowns are left out.
    pub fn null(&self) -> Option<&[f64]> {
        self.null.as_deref()
    }

    /// Unknowns that depend on others and are left out, ascending.
    pub fn left_out(&self) -> &[usize] {
        &self.left_out
    }

    /// Size, stored entries, bytes.
    pub fn summary(&self) -> LevelSummary {
        let (nnz, size) = match &self.factors {
            Factors::Dense(inverse) => (inverse.len(), size_of::<f64>()),
            Factors::Sparse(factors) => (factors.factor_entries(), size_of::<f64>()),
            Factors::Single { entries, .. } => (*entries, size_of::<f32>()),
        };
        LevelSummary {
            n: self.scale.len(),
            nnz,
            bytes: size * nnz,
        }
    }
}

/// Scales to a unit diagonal; gives `1/√a_ii`.
fn equilibrate(a: &mut SparseMatrix<f64>) -> Result<Vec<f64>, SetupError> {
    let factor = |i: usize| {
        let value = a.get(i, i).copied().unwrap_or(0.0);
        if value > 0.0 && value.is_finite() {
            Ok(value.sqrt().recip())
        } else {
            Err(SetupError::BadDiagonal {
                block: "A",
                row: i + 1,
                value,
                method: "the solver of the coarsest level",
            })
        }
    };
    let scale: Vec<f64> = (0..a.rows()).map(factor).collect::<Result<_, _>>()?;
    for (i, mut row) in a.outer_iterator_mut().enumerate() {
        row.iter_mut().for_each(|(j, v)| *v *= scale[i] * scale[j]);
    }
    Ok(scale)
}

/// The inverse of `L Lᵀ`.
fn dense_inverse(l: &Mat<f64>) -> Factors {
    let n = l.nrows();
    let mut inverse = Mat::<f64>::identity(n, n);
    dense::solve_lower(l.as_ref(), &mut inverse);
    dense::solve_lower_adjoint(l.as_ref(), &mut inverse);
    dense::symmetrize(&mut inverse);
    Factors::Dense((0..n * n).map(|k| inverse[(k / n, k % n)]).collect())
}

/// The inverse of a matrix with a unit diagonal, and the unknowns that are left out.
fn independent_inverse(a: &SparseMatrix<f64>) -> Result<(Factors, Vec<usize>), SetupError> {
    let l = dense::independent_cholesky(dense::to_dense(a), DEPENDENT, LEFT_OUT);
    let l = l.map_err(|row| SetupError::NotFinite {
        block: "A",
        row: row + 1,
        column: row + 1,
        value: f64::NAN,
    })?;
    let left_out = (0..a.rows()).filter(|i| l[(*i, *i)] > 1.0 + 1e-6);
    let left_out = left_out.collect();
    Ok((dense_inverse(&l), left_out))
}

impl Preconditioner<f64> for Direct {
    fn size(&self) -> usize {
        self.scale.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let n = self.size();
        let (scaled, work) = work.split_at_mut(n);
        for ((to, r), s) in scaled.iter_mut().zip(r).zip(&self.scale) {
            *to = s * r;
        }
        match &self.factors {
            Factors::Dense(inverse) => {
                for (z, row) in z.iter_mut().zip(inverse.chunks_exact(n.max(1))) {
                    *z = dot(row, scaled);
                }
            }
            Factors::Sparse(factors) => factors.solve(scaled, z, work),
            Factors::Single { inverse, .. } => inverse.solve(scaled, z, work),
        }
        z.iter_mut().zip(&self.scale).for_each(|(z, s)| *z *= s);
    }

    fn work_len(&self) -> usize {
        self.size()
            + match &self.factors {
                Factors::Dense(_) => 0,
                Factors::Sparse(factors) => factors.work_len(),
                Factors::Single { inverse, .. } => inverse.work_len(),
            }
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }

    fn flops(&self) -> u64 {
        2 * self.size() as u64
            + match &self.factors {
                Factors::Dense(inverse) => 2 * inverse.len() as u64,
                Factors::Sparse(factors) => factors.flops(),
                Factors::Single { inverse, .. } => inverse.flops(),
            }
    }
}

impl std::fmt::Debug for Direct {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [n, out] = [self.size(), self.left_out.len()];
        write!(f, "factors of {n} unknowns, {out} left out")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::sparse::Triplets;

    /// `PᵀP` of n functions that span `rank`: one dense block.
    fn dense_sample(n: usize, rank: usize) -> SparseMatrix<f64> {
        let p: Vec<Vec<f64>> = (0..n)
            .map(|j| (0..rank).map(|k| signed((j * rank + k) as u64)).collect())
            .collect();
        let mut a = Triplets::new((n, n));
        for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
            a.add_triplet(i, j, dot(&p[i], &p[j]));
        }
        a.to_csr()
    }

    /// `count` blocks `PᵀK P` of six functions that span four, K of a chain.
    fn sample(count: usize) -> SparseMatrix<f64> {
        let p = |k: usize, j: usize| match j {
            0..4 => f64::from(u8::from(j == k)),
            4 => [0.5, 0.25, 0.0, 0.25][k],
            _ => [0.0, 0.1, 0.9, 0.0][k],
        };
        let chain = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.5 + i as f64,
            1 => -1.0,
            _ => 0.0,
        };
        let mut a = Triplets::new((6 * count, 6 * count));
        for (b, i, j) in (0..36 * count).map(|k| (k / 36, k / 6 % 6, k % 6)) {
            let pairs = (0..16).map(|k| (k / 4, k % 4));
            let value: f64 = pairs.map(|(k, l)| p(k, i) * chain(k, l) * p(l, j)).sum();
            a.add_triplet(6 * b + i, 6 * b + j, (1.0 + b as f64) * value);
        }
        a.to_csr()
    }

    #[test]
    fn what_is_in_the_range_is_solved_and_dependent_unknowns_are_left_out() {
        let samples = [
            (sample(3), 6),
            (sample(300), 600),
            (dense_sample(30, 22), 8),
            (dense_sample(400, 380), 20),
            (dense_sample(1040, 1020), 20),
        ];
        for (a, dependent) in samples {
            let n = a.rows();
            let m = Direct::semidefinite(a.clone()).unwrap();
            assert_eq!(matches!(m.factors, Factors::Dense(_)), n <= DENSE);
            assert_eq!(m.left_out().len(), dependent);
            let times = |x: &[f64]| -> Vec<f64> {
                let row =
                    |row: sprs::CsVecViewI<'_, f64, u32>| row.iter().map(|(j, v)| v * x[j]).sum();
                a.outer_iterator().map(row).collect()
            };
            let wave: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
            let b = times(&wave);
            let mut z = vec![f64::NAN; n];
            m.solve(&b, &mut z, &mut vec![f64::NAN; m.work_len()]);
            assert!(m.left_out().iter().all(|i| z[*i] == 0.0));
            for (found, b) in times(&z).iter().zip(&b) {
                assert!(
                    (found - b).abs() < 1e-6 * (1.0 + b.abs()),
                    "{n}: {found} {b}"
                );
            }
            let null = m.null().unwrap();
            assert!(m.left_out().iter().all(|i| null[*i] != 0.0));
            assert!(times(null).iter().all(|v| v.abs() < 1e-6));
        }
    }

    #[test]
    fn a_regular_matrix_keeps_all_unknowns_and_a_wrong_one_is_named() {
        let mut a = Triplets::new((2, 2));
        for (i, j, v) in [(0, 0, 4.0), (1, 0, 1.0), (0, 1, 1.0), (1, 1, 0.5)] {
            a.add_triplet(i, j, v);
        }
        let m = Direct::semidefinite(a.to_csr()).unwrap();
        assert!(m.left_out().is_empty() && m.null().is_none());
        let mut z = [f64::NAN; 2];
        m.solve(&[6.0, 2.0], &mut z, &mut vec![0.0; m.work_len()]);
        assert!((z[0] - 1.0).abs() < 1e-14 && (z[1] - 2.0).abs() < 1e-14);
        let mut a = Triplets::new((2, 2));
        for (i, j, v) in [(0, 0, 1.0), (1, 1, -1.0)] {
            a.add_triplet(i, j, v);
        }
        let error = Direct::semidefinite(a.to_csr()).unwrap_err();
        assert!(
            matches!(error, SetupError::BadDiagonal { row: 2, .. }),
            "{error}"
        );
    }
}
