//! Scaling of rows and columns by powers of two before an LU factorization.

use super::pattern::BLOCK;
use super::{Factorization, reciprocal_condition};
use crate::SetupError;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};

/// Below this `1/κ₁` of the equilibrated matrix no digit of a solution is right. Unit: 1; ten units of rounding.
const SINGULAR: f64 = 10.0 * f64::EPSILON;

/// Sweeps of scaling by the square root of the largest entry; three bring every row and column within a factor of
/// about two of each other.
const SWEEPS: usize = 4;

/// `A⁻¹ = D_c (D_r A D_c)⁻¹ D_r` with factors of the equilibrated matrix.
///
/// Blocks of a saddle point differ by ten orders of magnitude with the units; pivoting and the test for singularity
/// mean something only after equilibration. Powers of two add no rounding.
///
/// # Source
/// D. Ruiz, Rutherford Appleton Laboratory report RAL-TR-2001-034 (2001).
#[derive(Debug)]
pub(super) struct Equilibrated<F> {
    rows: Vec<f64>,
    columns: Vec<f64>,
    factors: F,
}

impl<F: Factorization> Equilibrated<F> {
    /// Scales a matrix stored by columns and factorizes it; `1/κ₁` of the scaled matrix stands beside it.
    pub(super) fn of_any_condition(
        mut a: SparseMatrix<f64>,
        factor: impl FnOnce(&SparseMatrix<f64>) -> Result<F, SetupError>,
    ) -> Result<(Self, f64), SetupError> {
        let (rows, columns) = scales(&mut a)?;
        let factors = factor(&a)?;
        let reciprocal = reciprocal_condition(&a, &factors);
        let equilibrated = Self {
            rows,
            columns,
            factors,
        };
        Ok((equilibrated, reciprocal))
    }

    /// The same, and rejects a matrix that is singular to working precision.
    pub(super) fn factor(
        a: SparseMatrix<f64>,
        factor: impl FnOnce(&SparseMatrix<f64>) -> Result<F, SetupError>,
    ) -> Result<Self, SetupError> {
        let (equilibrated, reciprocal) = Self::of_any_condition(a, factor)?;
        if reciprocal < SINGULAR {
            return Err(SetupError::Singular {
                block: BLOCK,
                row: None,
                advice: format!(
                    "1/condition is {reciprocal:.1e} after scaling: unconstrained bodies, dependent constraints, or sides of cells or moduli so far apart that double precision does not tell"
                ),
            });
        }
        Ok(equilibrated)
    }
}

/// Largest |entry| of every row and column of a matrix stored by columns.
fn largest(a: &SparseMatrix<f64>) -> (Vec<f64>, Vec<f64>) {
    let (mut rows, mut columns) = (vec![0.0f64; a.rows()], vec![0.0f64; a.cols()]);
    for (j, column) in a.outer_iterator().enumerate() {
        for (i, value) in column.iter() {
            rows[i] = rows[i].max(value.abs());
            columns[j] = columns[j].max(value.abs());
        }
    }
    (rows, columns)
}

/// Scales `a` in place and returns `(D_r, D_c)`.
fn scales(a: &mut SparseMatrix<f64>) -> Result<(Vec<f64>, Vec<f64>), SetupError> {
    let (mut rows, mut columns) = (vec![1.0; a.rows()], vec![1.0; a.cols()]);
    for _ in 0..SWEEPS {
        let (row_max, column_max) = largest(a);
        if let Some(zero) = row_max.iter().position(|m| *m == 0.0) {
            return Err(SetupError::Singular {
                block: BLOCK,
                row: Some(zero + 1),
                advice: "the row holds only zeros: remove the unknown or constrain it".to_owned(),
            });
        }
        if let Some(zero) = column_max.iter().position(|m| *m == 0.0) {
            return Err(SetupError::Singular {
                block: BLOCK,
                row: None,
                advice: format!("column {} holds only zeros", zero + 1),
            });
        }
        let row_scale: Vec<f64> = row_max.iter().map(|m| power_of_two(*m)).collect();
        let column_scale: Vec<f64> = column_max.iter().map(|m| power_of_two(*m)).collect();
        for (j, mut column) in a.outer_iterator_mut().enumerate() {
            for (i, value) in column.iter_mut() {
                *value *= row_scale[i] * column_scale[j];
            }
        }
        rows.iter_mut().zip(&row_scale).for_each(|(r, s)| *r *= s);
        columns
            .iter_mut()
            .zip(&column_scale)
            .for_each(|(c, s)| *c *= s);
    }
    Ok((rows, columns))
}

/// The power of two next to `1/√m`.
fn power_of_two(m: f64) -> f64 {
    (-0.5 * m.log2()).round().exp2()
}

/// `v ← D v`.
fn multiply(d: &[f64], v: &mut [f64]) {
    v.iter_mut().zip(d).for_each(|(v, d)| *v *= d);
}

impl<F: Factorization> Preconditioner<f64> for Equilibrated<F> {
    fn size(&self) -> usize {
        self.rows.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (scaled, work) = work.split_at_mut(self.size());
        scaled.copy_from_slice(r);
        multiply(&self.rows, scaled);
        self.factors.solve(scaled, z, work);
        multiply(&self.columns, z);
    }

    fn work_len(&self) -> usize {
        self.size() + self.factors.work_len()
    }

    fn flops(&self) -> u64 {
        2 * self.size() as u64 + self.factors.flops()
    }

    fn properties(&self) -> Properties {
        self.factors.properties()
    }
}

impl<F: Factorization> Factorization for Equilibrated<F> {
    fn solve_adjoint(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let (scaled, work) = work.split_at_mut(self.size());
        scaled.copy_from_slice(r);
        multiply(&self.columns, scaled);
        self.factors.solve_adjoint(scaled, z, work);
        multiply(&self.rows, z);
    }

    fn solve_many(&self, columns: usize, b: &mut [f64]) {
        let n = self.size().max(1);
        b.chunks_exact_mut(n).for_each(|c| multiply(&self.rows, c));
        self.factors.solve_many(columns, b);
        b.chunks_exact_mut(n)
            .for_each(|c| multiply(&self.columns, c));
    }

    fn factor_entries(&self) -> usize {
        self.factors.factor_entries()
    }

    fn log2_abs_determinant(&self) -> Option<f64> {
        let scales = self.rows.iter().chain(&self.columns);
        let scaling: f64 = scales.map(|s| s.log2()).sum();
        Some(self.factors.log2_abs_determinant()? - scaling)
    }
}
