//! Dense oracles of saddle points, for tests.

use faer::linalg::solvers::{FullPivLu, Solve};
use faer::{Mat, c64};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Dense, LinearOperator, Preconditioner, Properties};
use fracas_solvers::SetupError;
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::{SaddleBlocks, SaddleOperator};

/// With all its zeros.
pub(crate) fn full(m: &SparseMatrix<f64>) -> Mat<f64> {
    Mat::from_fn(m.rows(), m.cols(), |i, j| *m.get(i, j).unwrap_or(&0.0))
}

/// A, B1, B2 and H with all their zeros.
pub(crate) struct Full {
    pub(crate) a: Mat<f64>,
    pub(crate) b1: Mat<f64>,
    pub(crate) b2: Mat<f64>,
    pub(crate) h: Mat<f64>,
}

impl Full {
    pub(crate) fn new(blocks: &SaddleBlocks) -> Self {
        let b1 = full(&blocks.b1);
        let n_t = blocks.n_t();
        Self {
            a: full(&blocks.a),
            b2: blocks
                .b2
                .as_ref()
                .map_or_else(|| b1.transpose().to_owned(), full),
            b1,
            h: blocks.h.as_ref().map_or_else(|| Mat::zeros(n_t, n_t), full),
        }
    }
}

/// `[a b; c d]`.
pub(crate) fn stacked(a: &Mat<f64>, b: &Mat<f64>, c: &Mat<f64>, d: &Mat<f64>) -> Mat<f64> {
    let (n, m) = (a.nrows(), d.nrows());
    Mat::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
        (true, true) => a[(i, j)],
        (true, false) => b[(i, j - n)],
        (false, true) => c[(i - n, j)],
        (false, false) => d[(i - n, j - n)],
    })
}

/// M⁻¹ of a small matrix.
pub(crate) fn inverse(m: &Mat<f64>) -> Mat<f64> {
    FullPivLu::new(m.as_ref()).solve(Mat::<f64>::identity(m.nrows(), m.ncols()))
}

/// A dense matrix and its inverse as a preconditioner.
pub(crate) struct DenseInverse {
    inverse: Mat<f64>,
}

impl DenseInverse {
    pub(crate) fn of(m: &Mat<f64>) -> Self {
        Self {
            inverse: inverse(m),
        }
    }
}

impl Preconditioner<f64> for DenseInverse {
    fn size(&self) -> usize {
        self.inverse.nrows()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _work: &mut [f64]) {
        for (i, z) in z.iter_mut().enumerate() {
            *z = r
                .iter()
                .enumerate()
                .map(|(j, r)| self.inverse[(i, j)] * r)
                .sum();
        }
    }

    fn flops(&self) -> u64 {
        2 * (self.size() * self.size()) as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

/// As an operator that the laws take.
pub(crate) fn operator(m: &Mat<f64>) -> Dense<f64> {
    Dense::from_fn(
        fracas_operators::Shape::new(m.nrows(), m.ncols()),
        |i, j| m[(i, j)],
    )
}

/// Eigenvalues of M⁻¹𝒜, by real part.
pub(crate) fn spectrum(
    m: &dyn Preconditioner<f64>,
    blocks: &SaddleBlocks,
) -> Result<Vec<c64>, SetupError> {
    let saddle = SaddleOperator::new(blocks);
    let n = saddle.shape().rows;
    let (mut column, mut x, mut y) = (vec![0.0; n], vec![0.0; n], Mat::zeros(n, n));
    let mut work = vec![f64::NAN; m.work_len()];
    for j in 0..n {
        x.fill(0.0);
        x[j] = 1.0;
        let mut z = vec![0.0; n];
        saddle.apply(&x, &mut column, &mut []);
        m.solve(&column, &mut z, &mut work);
        (0..n).for_each(|i| y[(i, j)] = z[i]);
    }
    let mut values = dense::general_eigenvalues(y.as_ref())?;
    values.sort_by(|a, b| a.re.total_cmp(&b.re));
    Ok(values)
}

/// Asserts that the eigenvalues are these real numbers, in any order.
#[track_caller]
pub(crate) fn assert_spectrum(found: &[c64], mut expected: Vec<f64>, tolerance: f64) {
    expected.sort_by(f64::total_cmp);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            (found.re - expected).hypot(found.im) < tolerance,
            "{found} where {expected} is due"
        );
    }
}

/// Eigenvalues of a product of matrices that is known to have real ones.
pub(crate) fn real_eigenvalues(m: &Mat<f64>) -> Vec<f64> {
    let values = dense::general_eigenvalues(m.as_ref()).unwrap_or_default();
    values.iter().map(|v| v.re).collect()
}

/// The same blocks with a B2 of their own: B1ᵀ plus a tenth of something else.
pub(crate) fn unsymmetric(mut blocks: SaddleBlocks) -> SaddleBlocks {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let other: Vec<f64> = fracas_operators::laws::probe(n_u * n_t, 77);
    let b1 = &blocks.b1;
    let b2 = crate::samples::sparse(n_t, n_u, |i, j| {
        b1.get(j, i).unwrap_or(&0.0) + 0.1 * other[i * n_u + j]
    });
    blocks.b2 = Some(b2);
    blocks
}
