//! Random dense systems and their direct solution, for the tests of every method.

use super::{Breakdown, Cg, Criteria, KrylovMethod, Outcome, Report, System, Watch};
use crate::Silent;
use faer::prelude::Solve;
use fracas_operators::laws::probe;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Dense, LinearOperator, Preconditioner, Properties, Shape};

/// A dense matrix as faer's.
pub(super) fn faer_of(a: &Dense<f64>) -> faer::Mat<f64> {
    let shape = a.shape();
    faer::Mat::from_fn(shape.rows, shape.cols, |i, j| a.entry(i, j))
}

/// `A⁻¹ b` by LU with partial pivoting.
pub(super) fn direct(a: &Dense<f64>, b: &[f64]) -> Vec<f64> {
    let rhs = faer::Mat::from_fn(b.len(), 1, |i, _| b[i]);
    let x = faer_of(a).partial_piv_lu().solve(&rhs);
    (0..b.len()).map(|i| x[(i, 0)]).collect()
}

/// Unsymmetric, well conditioned: `2I + N/√n` with entries of N in (−½, ½).
pub(super) fn unsymmetric(n: usize, seed: u64) -> Dense<f64> {
    let noise: Vec<f64> = probe(n * n, seed);
    Dense::from_fn(Shape::square(n), |i, j| {
        (if i == j { 2.0 } else { 0.0 }) + 2.0 * noise[i * n + j] / (n as f64).sqrt()
    })
}

/// `Q diag(eigenvalues) Qᵀ` with Q from the QR factors of a random matrix.
pub(super) fn with_eigenvalues(eigenvalues: &[f64], seed: u64) -> Dense<f64> {
    let n = eigenvalues.len();
    let noise: Vec<f64> = probe(n * n, seed);
    let q = faer::Mat::from_fn(n, n, |i, j| noise[i * n + j])
        .qr()
        .compute_Q();
    Dense::from_fn(Shape::square(n), |i, j| {
        (0..n).map(|k| q[(i, k)] * eigenvalues[k] * q[(j, k)]).sum()
    })
}

/// Symmetric with eigenvalues in [1, 10].
pub(super) fn spd(n: usize, seed: u64) -> Dense<f64> {
    let step = 9.0 / n.max(2) as f64;
    with_eigenvalues(
        &(0..n).map(|k| 1.0 + step * k as f64).collect::<Vec<_>>(),
        seed,
    )
}

/// Symmetric with eigenvalues in ±[1, 10], a third of them negative.
pub(super) fn indefinite(n: usize, seed: u64) -> Dense<f64> {
    let step = 9.0 / n.max(2) as f64;
    let value = |k: usize| (1.0 + step * k as f64) * if k % 3 == 1 { -1.0 } else { 1.0 };
    with_eigenvalues(&(0..n).map(value).collect::<Vec<_>>(), seed)
}

/// A dense matrix as a preconditioner: `z = W r`, W = M⁻¹.
pub(super) struct Explicit(pub Dense<f64>);

impl Preconditioner<f64> for Explicit {
    fn size(&self) -> usize {
        self.0.shape().rows
    }
    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        self.0.apply(r, z, work);
    }
    fn flops(&self) -> u64 {
        self.0.flops()
    }
    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

/// `A⁻¹` as a preconditioner.
pub(super) fn exact(a: &Dense<f64>) -> Explicit {
    let n = a.shape().rows;
    let mut inverse = Dense::zeros(a.shape());
    for j in 0..n {
        let mut e = vec![0.0; n];
        e[j] = 1.0;
        inverse.column_mut(j).copy_from_slice(&direct(a, &e));
    }
    Explicit(inverse)
}

/// Solves from zero with `work` full of NaN.
pub(crate) fn solve(
    method: &dyn KrylovMethod<f64>,
    operator: &dyn LinearOperator<f64>,
    preconditioner: &dyn Preconditioner<f64>,
    rhs: &[f64],
    criteria: Criteria,
) -> (Vec<f64>, Result<Report, Breakdown>) {
    let system = System {
        operator,
        preconditioner,
        rhs,
    };
    let mut x = vec![0.0; rhs.len()];
    let mut work = vec![f64::NAN; method.work_len(&system, &criteria)];
    let report = method.solve_in(
        &system,
        &criteria,
        &mut x,
        Watch::of(&mut Silent),
        &mut work,
    );
    (x, report)
}

/// Iterations of conjugate gradients to this relative residual; they reach it.
pub(crate) fn cg_iterations(
    a: &SparseMatrix<f64>,
    m: &dyn Preconditioner<f64>,
    rhs: &[f64],
    tolerance: f64,
) -> usize {
    let operator = Csr::new(a.clone());
    let (_, report) = solve(&Cg {}, &operator, m, rhs, until(tolerance, 2000));
    let report = report.unwrap();
    assert_eq!(report.outcome, Outcome::Converged);
    report.iterations
}

/// Tolerance and limit in one line.
pub(crate) fn until(relative_tolerance: f64, max_iterations: usize) -> Criteria {
    Criteria {
        relative_tolerance,
        max_iterations,
    }
}

/// ‖x − y‖ / ‖y‖.
pub(super) fn deviation(x: &[f64], y: &[f64]) -> f64 {
    let square = |f: &dyn Fn(usize) -> f64| (0..y.len()).map(|i| f(i).powi(2)).sum::<f64>();
    (square(&|i| x[i] - y[i]) / square(&|i| y[i])).sqrt()
}
