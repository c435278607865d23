//! The tangent of rock and springs as an operator.

use crate::contact::Coupling;
use crate::elasticity::Restricted;
use fracas_operators::operator::assert_product;
use fracas_operators::{AdjointOperator, LinearOperator, Shape};
use fracas_solvers::saddle::Block;

/// `A + B D Bᵀ`, `D = K/(s² A_f)` one 3×3 block per face; nothing is assembled.
pub(super) struct SpringJacobian<'a> {
    pub(super) a: &'a Restricted<Box<dyn AdjointOperator<f64>>>,
    /// B, tractions in a balanced unit s.
    pub(super) b: &'a Coupling<f64>,
    pub(super) faces: Vec<Block>,
}

impl SpringJacobian<'_> {
    /// `t ← D Bᵀ x` in the balanced unit.
    pub(super) fn tractions(&self, x: &[f64], t: &mut [f64], work: &mut [f64]) {
        t.fill(0.0);
        self.b.apply_adjoint_add(1.0, x, t, work);
        for (t, d) in t.chunks_exact_mut(3).zip(&self.faces) {
            let jump = [t[0], t[1], t[2]];
            for (t, d) in t.iter_mut().zip(d) {
                *t = d[0] * jump[0] + d[1] * jump[1] + d[2] * jump[2];
            }
        }
    }
}

impl LinearOperator<f64> for SpringJacobian<'_> {
    fn shape(&self) -> Shape {
        Shape::square(self.b.shape().rows)
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        self.a.apply_add(alpha, x, y, work);
        let (t, work) = work.split_at_mut(3 * self.faces.len());
        self.tractions(x, t, work);
        self.b.apply_add(alpha, t, y, work);
    }

    fn work_len(&self) -> usize {
        self.a
            .work_len()
            .max(3 * self.faces.len() + self.b.work_len())
    }

    fn flops(&self) -> u64 {
        let b = 2 * LinearOperator::<f64>::flops(self.b);
        LinearOperator::<f64>::flops(self.a) + b + 15 * self.faces.len() as u64
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::nonlinear::ContactProblem;
    use crate::scene::sample::Sample;
    use fracas_operators::sparse::SparseMatrix;

    #[test]
    fn the_product_is_that_of_the_assembled_blocks() {
        let body = Sample::patch().body();
        let problem = ContactProblem::new(&body).unwrap();
        let blocks = problem.stick_blocks().unwrap();
        let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
        let s = problem.saddle().unit();
        let number = |k: usize| (1.3 * k as f64).sin();
        let d = |f: usize| -> Block {
            std::array::from_fn(|i| std::array::from_fn(|j| 1e10 * number(9 * f + 3 * i + j + 1)))
        };
        let jacobian = SpringJacobian {
            a: problem.saddle().stiffness(),
            b: problem.saddle().coupling(),
            faces: (0..n_t / 3)
                .map(|f| d(f).map(|row| row.map(|v| v / (s * s))))
                .collect(),
        };
        let x: Vec<f64> = (0..n_u).map(number).collect();
        let product = |m: &SparseMatrix<f64>, x: &[f64]| -> Vec<f64> {
            let mut y = vec![0.0; m.rows()];
            for (y, row) in y.iter_mut().zip(m.outer_iterator()) {
                row.iter().for_each(|(j, v)| *y += v * x[j]);
            }
            y
        };
        let jump = product(&blocks.b1.transpose_view().to_csr(), &x);
        let t: Vec<f64> = (0..n_t)
            .map(|i| {
                (0..3)
                    .map(|j| d(i / 3)[i % 3][j] * jump[3 * (i / 3) + j])
                    .sum()
            })
            .collect();
        let (a, b) = (product(&blocks.a, &x), product(&blocks.b1, &t));
        let mut y = vec![1.0; n_u];
        jacobian.apply_add(-2.0, &x, &mut y, &mut vec![f64::NAN; jacobian.work_len()]);
        let size = a.iter().chain(&b).fold(0.0, |m: f64, v| m.max(v.abs()));
        for i in 0..n_u {
            let expected = 1.0 - 2.0 * (a[i] + b[i]);
            assert!(
                (y[i] - expected).abs() < 1e-12 * size,
                "{i}: {} {expected}",
                y[i]
            );
        }
    }
}
