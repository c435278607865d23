//! The coarsest level: a dense inverse, or sparse factors where it is large.

use super::scratch;
use super::sweeps::SweepMatrix;
use crate::SetupError;
use crate::direct::{DirectSolver, Factorization, Faer, Kind};
use crate::eigen::dense;
use faer::Mat;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Preconditioner, Real};

/// Unknowns up to which the inverse is stored.
const DENSE: usize = 1000;

/// Diagonal entry of the Cholesky factor of a matrix with unit diagonal below which it counts as singular. Unit: 1.
const SINGULAR: f64 = 1e-6;

/// A⁻¹ of the coarsest matrix.
pub(super) enum Coarsest<R> {
    /// Row by row.
    Dense { n: usize, inverse: Vec<R> },
    /// By Cholesky factors of the matrix scaled to a unit diagonal.
    Sparse {
        factors: Box<dyn Factorization>,
        scale: Vec<f64>,
    },
}

/// Why there is no inverse.
pub(super) enum NoInverse {
    /// A pivot is not positive: scalar row, as far as it is known.
    Singular(usize),
    /// The sparse solver gave up for another reason.
    Failed(SetupError),
}

impl<R: Real> Coarsest<R> {
    /// Factorizes.
    pub(super) fn new<S: Real>(a: &SweepMatrix<S>) -> Result<Self, NoInverse> {
        let scale: Vec<f64> = (0..3 * a.rows())
            .map(|i| {
                a.diagonal(i / 3)[i % 3][i % 3]
                    .to_f64_exact()
                    .sqrt()
                    .recip()
            })
            .collect();
        // a unit diagonal makes "singular" a matter of digits
        if scale.len() <= DENSE {
            Self::dense(a, &scale)
        } else {
            Self::sparse(a, scale)
        }
    }

    fn dense<S: Real>(a: &SweepMatrix<S>, scale: &[f64]) -> Result<Self, NoInverse> {
        let n = scale.len();
        let mut scaled = Mat::<f64>::zeros(n, n);
        for_each_entry(a, |i, j, v| scaled[(i, j)] = v * scale[i] * scale[j]);
        let l = dense::cholesky(scaled).map_err(NoInverse::Singular)?;
        if let Some(row) = (0..n).find(|i| l[(*i, *i)] < SINGULAR) {
            return Err(NoInverse::Singular(row));
        }
        let mut inverse = Mat::<f64>::identity(n, n);
        dense::solve_lower(l.as_ref(), &mut inverse);
        dense::solve_lower_adjoint(l.as_ref(), &mut inverse);
        let entry = |k: usize| {
            let (i, j) = (k / n, k % n);
            // symmetric to the last bit
            let value = 0.5 * (inverse[(i, j)] + inverse[(j, i)]);
            R::of(value * scale[i] * scale[j])
        };
        Ok(Self::Dense {
            n,
            inverse: (0..n * n).map(entry).collect(),
        })
    }

    fn sparse<S: Real>(a: &SweepMatrix<S>, scale: Vec<f64>) -> Result<Self, NoInverse> {
        let n = scale.len();
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut row: Vec<(u32, f64)> = Vec::new();
        for i in 0..n {
            row.clear();
            for (j, block) in a.row(i / 3) {
                for c in 0..3 {
                    let value = block[i % 3][c].to_f64_exact();
                    row.push(((3 * j + c) as u32, value * scale[i] * scale[3 * j + c]));
                }
            }
            row.sort_unstable_by_key(|(j, _)| *j);
            columns.extend(row.iter().map(|(j, _)| *j));
            values.extend(row.iter().map(|(_, v)| *v));
            starts.push(columns.len());
        }
        let scaled = SparseMatrix::new((n, n), starts, columns, values);
        let factors = Faer
            .analyze(&scaled, Kind::Spd)
            .and_then(|symbolic| symbolic.factor(&scaled));
        match factors {
            Ok(factors) => Ok(Self::Sparse { factors, scale }),
            Err(SetupError::NotPositiveDefinite { row, .. }) => Err(NoInverse::Singular(row - 1)),
            Err(error) => Err(NoInverse::Failed(error)),
        }
    }

    /// `x ← A⁻¹ b`.
    pub(super) fn solve(&self, b: &[R], x: &mut [R], work: &mut [R]) {
        match self {
            Self::Dense { n, inverse } => {
                for (x, row) in x.iter_mut().zip(inverse.chunks_exact(*n)) {
                    *x = dot(row, b);
                }
            }
            Self::Sparse { factors, scale } => {
                let (r, rest) = scratch::doubles_of(work).split_at_mut(scale.len());
                let (z, rest) = rest.split_at_mut(scale.len());
                for ((r, b), s) in r.iter_mut().zip(b).zip(scale) {
                    *r = s * b.to_f64_exact();
                }
                factors.solve(r, z, rest);
                for ((x, z), s) in x.iter_mut().zip(&*z).zip(scale) {
                    *x = R::of(s * z);
                }
            }
        }
    }

    /// Scratch entries of a solve.
    pub(super) fn work_len(&self) -> usize {
        match self {
            Self::Dense { .. } => 0,
            Self::Sparse { factors, scale } => {
                let doubles = 2 * scale.len() + factors.work_len();
                (doubles + 1) * size_of::<f64>() / size_of::<R>()
            }
        }
    }

    /// Unknowns.
    pub(super) fn size(&self) -> usize {
        match self {
            Self::Dense { n, .. } => *n,
            Self::Sparse { scale, .. } => scale.len(),
        }
    }

    /// Stored entries.
    pub(super) fn entries(&self) -> usize {
        match self {
            Self::Dense { inverse, .. } => inverse.len(),
            Self::Sparse { factors, .. } => factors.factor_entries(),
        }
    }

    pub(super) fn flops(&self) -> u64 {
        match self {
            Self::Dense { inverse, .. } => 2 * inverse.len() as u64,
            Self::Sparse { factors, scale } => factors.flops() + 2 * scale.len() as u64,
        }
    }

    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Dense { inverse, .. } => size_of_val(&**inverse),
            Self::Sparse { factors, .. } => size_of::<f64>() * factors.factor_entries(),
        }
    }
}

impl<R> std::fmt::Debug for Coarsest<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Dense { .. } => "dense inverse",
            Self::Sparse { .. } => "sparse Cholesky factors",
        })
    }
}

fn for_each_entry<S: Real>(a: &SweepMatrix<S>, mut visit: impl FnMut(usize, usize, f64)) {
    for i in 0..a.rows() {
        for (j, block) in a.row(i) {
            for (k, value) in block.as_flattened().iter().enumerate() {
                visit(3 * i + k / 3, 3 * j + k % 3, value.to_f64_exact());
            }
        }
    }
}

/// Scalar product in eight independent sums.
fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    let (a8, a) = a.as_chunks::<8>();
    let (b8, b) = b.as_chunks::<8>();
    let mut sums = [R::zero(); 8];
    for (a, b) in a8.iter().zip(b8) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let tail: R = a.iter().zip(b).map(|(a, b)| *a * *b).sum();
    sums.iter().copied().sum::<R>() + tail
}
