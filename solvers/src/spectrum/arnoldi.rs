//! Arnoldi on M⁻¹𝒜 in scales in which its unknowns have one unit.

use super::product::Preconditioned;
use crate::SetupError;
use crate::eigen::dense;
use faer::{Mat, c64};
use fracas_operators::LinearOperator;
use fracas_operators::vector::{axpy, dot};

/// Eigenpairs of the Hessenberg matrix of `D M⁻¹𝒜 D⁻¹` on the Krylov space of a start vector.
pub(super) struct Ritz {
    basis: Vec<Vec<f64>>,
    pub(super) values: Vec<c64>,
    /// Columns of length 1.
    vectors: Mat<c64>,
    /// `h_{m+1,m}`.
    last: f64,
}

impl Ritz {
    /// At most `steps` steps from `start`, which is not zero.
    ///
    /// # Cost
    /// A product with M⁻¹𝒜 and a vector of memory per step.
    pub(super) fn new(
        operator: &Preconditioned<'_>,
        scales: &[f64],
        start: Vec<f64>,
        steps: usize,
    ) -> Result<Self, SetupError> {
        let n = scales.len();
        let steps = steps.min(n);
        let mut basis: Vec<Vec<f64>> = vec![start];
        let norm = dot(&basis[0], &basis[0]).sqrt();
        basis[0].iter_mut().for_each(|v| *v /= norm);
        let mut h = Mat::<f64>::zeros(steps + 1, steps);
        let (mut x, mut work) = (vec![0.0; n], vec![0.0; operator.work_len()]);
        let mut m = steps;
        for k in 0..steps {
            let mut w = vec![0.0; n];
            x.iter_mut()
                .zip(&basis[k])
                .zip(scales)
                .for_each(|((x, v), d)| *x = v / d);
            operator.apply(&x, &mut w, &mut work);
            w.iter_mut().zip(scales).for_each(|(w, d)| *w *= d);
            let size = dot(&w, &w).sqrt();
            for _ in 0..2 {
                for (i, v) in basis.iter().enumerate() {
                    let projection = dot(v, &w);
                    h[(i, k)] += projection;
                    axpy(-projection, v, &mut w);
                }
            }
            let next = dot(&w, &w).sqrt();
            if next <= 1e-13 * size {
                m = k + 1;
                break;
            }
            h[(k + 1, k)] = next;
            w.iter_mut().for_each(|v| *v /= next);
            basis.push(w);
        }
        let last = if m < h.nrows() { h[(m, m - 1)] } else { 0.0 };
        let (values, vectors) = dense::general_eigen(h.submatrix(0, 0, m, m))?;
        Ok(Self {
            basis,
            values,
            vectors,
            last,
        })
    }

    /// `‖D M⁻¹𝒜 D⁻¹ y − θ y‖₂` of pair j, ‖y‖ = 1.
    pub(super) fn residual(&self, j: usize) -> f64 {
        self.last * self.vectors[(self.values.len() - 1, j)].norm()
    }

    /// `|y_i|²` of pair j: the share of every unknown in the energy.
    pub(super) fn energies(&self, j: usize) -> Vec<f64> {
        let n = self.basis[0].len();
        let (mut re, mut im) = (vec![0.0; n], vec![0.0; n]);
        for (i, v) in self.basis.iter().take(self.values.len()).enumerate() {
            axpy(self.vectors[(i, j)].re, v, &mut re);
            axpy(self.vectors[(i, j)].im, v, &mut im);
        }
        re.iter().zip(&im).map(|(a, b)| a * a + b * b).collect()
    }
}
