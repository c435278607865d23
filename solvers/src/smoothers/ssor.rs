//! Symmetric successive over-relaxation.

use super::entries::{positive_diagonal, relaxation, rows};
use crate::{Prepare, SetupError};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// SSOR: `M = (D + ωL) D⁻¹ (D + ωU) / (ω(2 − ω))` with `A = L + D + U`; ω = 1 is symmetric Gauss–Seidel.
///
/// SPD for SPD A. A forward and a backward sweep over the rows, sequential: the same bits for any number of threads.
///
/// # Cost
/// One solve: `2 nnz + 5 n` flops.
///
/// # Errors
/// [`SetupError::BadDiagonal`] for an entry that is not positive, [`SetupError::NotApplicable`] for ω outside (0, 2).
///
/// # Source
/// Axelsson, *Iterative Solution Methods*, §7.2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Ssor {
    /// Relaxation ω in (0, 2).
    #[serde(deserialize_with = "super::entries::omega")]
    pub omega: f64,
}

impl Default for Ssor {
    fn default() -> Self {
        Self { omega: 1.0 }
    }
}

impl Prepare<SparseMatrix<f64>, f64> for Ssor {
    fn prepare(&self, a: &SparseMatrix<f64>) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        Ok(Box::new(SsorInverse::new(a, *self)?))
    }
}

/// The strict triangles and the diagonal of A, ready for the two sweeps.
#[derive(Clone, Debug)]
pub struct SsorInverse {
    omega: f64,
    diagonal: Vec<f64>,
    lower: Triangle,
    upper: Triangle,
}

/// A strict triangle by rows.
#[derive(Clone, Debug)]
struct Triangle {
    offsets: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl Triangle {
    fn of(a: &SparseMatrix<f64>, inside: impl Fn(usize, usize) -> bool) -> Self {
        let mut triangle = Self {
            offsets: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
        };
        for (i, row) in a.outer_iterator().enumerate() {
            for (j, value) in row.iter().filter(|(j, _)| inside(i, *j)) {
                triangle.columns.push(j as u32);
                triangle.values.push(*value);
            }
            triangle.offsets.push(triangle.columns.len());
        }
        triangle
    }

    /// `Σ_j a_ij z_j` over the triangle's part of row i.
    fn row_times(&self, i: usize, z: &[f64]) -> f64 {
        let range = self.offsets[i]..self.offsets[i + 1];
        let (columns, values) = (&self.columns[range.clone()], &self.values[range]);
        columns
            .iter()
            .zip(values)
            .map(|(j, a_ij)| a_ij * z[*j as usize])
            .sum()
    }
}

impl SsorInverse {
    /// From the entries of `a`.
    pub fn new(a: &SparseMatrix<f64>, settings: Ssor) -> Result<Self, SetupError> {
        let a = rows(a)?;
        relaxation(settings.omega, 2.0, "ssor")?;
        Ok(Self {
            omega: settings.omega,
            diagonal: positive_diagonal(&a, "ssor")?,
            lower: Triangle::of(&a, |i, j| j < i),
            upper: Triangle::of(&a, |i, j| j > i),
        })
    }
}

impl Preconditioner<f64> for SsorInverse {
    fn size(&self) -> usize {
        self.diagonal.len()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _work: &mut [f64]) {
        let n = self.size();
        assert!(r.len() == n && z.len() == n);
        let (omega, d) = (self.omega, &self.diagonal);
        // z = (D + ωL)⁻¹ ω(2 − ω) r
        for i in 0..n {
            z[i] = omega * ((2.0 - omega) * r[i] - self.lower.row_times(i, z)) / d[i];
        }
        // z ← (D + ωU)⁻¹ D z
        for i in (0..n).rev() {
            z[i] -= omega * self.upper.row_times(i, z) / d[i];
        }
    }

    fn flops(&self) -> u64 {
        2 * (self.lower.values.len() + self.upper.values.len()) as u64 + 7 * self.size() as u64
    }

    fn properties(&self) -> Properties {
        Properties::LOCAL
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::{sparse, stiffness};
    use super::*;
    use crate::krylov::oracle::cg_iterations;
    use fracas_operators::laws::{check_preconditioner, probe};
    use fracas_operators::vector::dot;
    use fracas_operators::{Dense, Identity, LinearOperator, Shape};

    /// `(D + ωL) D⁻¹ (D + ωU) / (ω(2 − ω))`, entry by entry.
    fn formula(a: &SparseMatrix<f64>, omega: f64) -> Dense<f64> {
        let n = a.rows();
        let entry = |i: usize, j: usize| a.get(i, j).copied().unwrap_or(0.0);
        Dense::from_fn(Shape::square(n), |i, j| {
            let factor = |k: usize, other: usize| if k == other { 1.0 } else { omega };
            (0..=i.min(j))
                .map(|k| factor(i, k) * entry(i, k) * factor(j, k) * entry(k, j) / entry(k, k))
                .sum::<f64>()
                / (omega * (2.0 - omega))
        })
    }

    #[test]
    fn obeys_the_laws_and_is_the_dense_formula_also_for_an_unsymmetric_matrix() {
        let mut unsymmetric = stiffness(24);
        unsymmetric
            .data_mut()
            .iter_mut()
            .enumerate()
            .for_each(|(k, v)| *v *= 1.0 + 0.01 * (k % 7) as f64);
        for a in [stiffness(24), unsymmetric.clone(), unsymmetric.to_csc()] {
            for omega in [0.5, 1.0, 1.6] {
                let m = Ssor { omega }.prepare(&a).unwrap();
                let dense = formula(&a, omega);
                check_preconditioner("ssor", &m, Some(&dense as &dyn LinearOperator<f64>), 1e-12)
                    .unwrap();
            }
        }
    }

    #[test]
    fn is_symmetric_positive_definite_for_such_a_matrix() {
        let a = stiffness(24);
        let m = Dense::of_preconditioner(&SsorInverse::new(&a, Ssor { omega: 1.3 }).unwrap());
        for i in 0..24 {
            for j in 0..24 {
                assert!((m.entry(i, j) - m.entry(j, i)).abs() < 1e-14 * m.max_abs());
            }
        }
        for seed in 1..20 {
            let r: Vec<f64> = probe(24, seed);
            let mut z = vec![0.0; 24];
            m.apply(&r, &mut z, &mut []);
            assert!(dot(&r, &z) > 0.0);
        }
    }

    #[test]
    fn saves_iterations_of_conjugate_gradients() {
        let a = stiffness(300);
        let rhs: Vec<f64> = probe(300, 1);
        let iterations = |m: &dyn Preconditioner<f64>| cg_iterations(&a, m, &rhs, 1e-8);
        let smoothed = iterations(&Ssor::default().prepare(&a).unwrap());
        let plain = iterations(&Identity { n: 300 });
        assert!(2 * smoothed < plain, "{smoothed} against {plain}");
    }

    #[test]
    fn refuses_what_it_cannot_divide_by() {
        let a = sparse(2, &[(0, 0, 1.0), (1, 1, -4.0)]);
        let error = SsorInverse::new(&a, Ssor::default()).unwrap_err();
        assert!(matches!(error, SetupError::BadDiagonal { row: 2, value, .. } if value == -4.0));
        for omega in [0.0, 2.0, f64::NAN] {
            let error = SsorInverse::new(&stiffness(6), Ssor { omega }).unwrap_err();
            assert!(matches!(error, SetupError::NotApplicable { .. }));
        }
    }
}
