//! G, ready to multiply.

use super::adaptive::GrowingRows;
use super::growing::NotPositive;
use super::pattern::Pattern;
use super::static_rows::StaticRows;
use super::{Fsai, FsaiKind};
use crate::SetupError;
use crate::smoothers::entries::{BLOCK, positive_diagonal, rows};
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{AdjointOperator, LinearOperator, Preconditioner, Properties, Real};
use rayon::prelude::*;

/// Rows of G that one task computes.
const ROWS_PER_TASK: usize = 512;

/// Strict lower part `(j, y_j)` of a row before it is scaled.
pub(super) type Row = Vec<(u32, f64)>;

/// Computes rows of G, with memory of its own.
pub(super) trait RowBuilder {
    /// Writes the ascending entries y of row i into the empty `out` and returns ψ; the row of G is `(y, 1)/√ψ`.
    fn row(&mut self, i: usize, out: &mut Row) -> Result<f64, NotPositive>;
}

/// `M⁻¹ = GᵀG`.
///
/// # Cost
/// One solve: `4 nnz(G)` flops.
#[derive(Clone, Debug)]
pub struct FsaiInverse<R> {
    g: Csr<R>,
}

impl FsaiInverse<f64> {
    /// From the entries of an SPD `a`. Rows are independent: the same bits for any number of threads.
    ///
    /// # Errors
    /// See [`Fsai`].
    pub fn new(a: &SparseMatrix<f64>, settings: Fsai) -> Result<Self, SetupError> {
        let a = rows(a)?;
        let diagonal = positive_diagonal(&a, "fsai")?;
        let g = match settings.kind {
            FsaiKind::Adaptive(growth) => {
                assemble(a.rows(), || GrowingRows::new(&a, &diagonal, growth))?
            }
            FsaiKind::Static(choice) => {
                let pattern = Pattern::new(&a, &diagonal, choice);
                assemble(a.rows(), || StaticRows::new(&a, &diagonal, &pattern))?
            }
        };
        Ok(Self::of_factor(g))
    }
}

impl<R: Real> FsaiInverse<R> {
    /// From a factor G.
    pub(crate) fn of_factor(g: SparseMatrix<R>) -> Self {
        Self {
            g: Csr::with_transpose(g),
        }
    }

    /// The same in another precision.
    pub fn cast<S: Real>(&self) -> FsaiInverse<S> {
        FsaiInverse::of_factor(self.g.matrix().map(|value| S::of(value.to_f64_exact())))
    }

    /// Bytes of G and Gᵀ.
    pub(crate) fn bytes(&self) -> usize {
        2 * self.g.nnz() * (size_of::<R>() + size_of::<u32>())
    }

    /// G, with its transpose for adjoint products.
    pub fn g(&self) -> &Csr<R> {
        &self.g
    }
}

impl<R: Real> Preconditioner<R> for FsaiInverse<R> {
    fn size(&self) -> usize {
        self.g.matrix().rows()
    }

    fn solve(&self, r: &[R], z: &mut [R], work: &mut [R]) {
        let w = &mut work[..self.g.matrix().rows()];
        // w = G r
        self.g.apply(r, w, &mut []);
        // z = Gᵀ w
        z.fill(R::zero());
        self.g.apply_adjoint_add(R::one(), w, z, &mut []);
    }

    fn work_len(&self) -> usize {
        self.size()
    }

    fn flops(&self) -> u64 {
        2 * self.g.flops()
    }

    fn properties(&self) -> Properties {
        Properties::LOCAL
    }
}

/// Rows of G of one task.
#[derive(Default)]
struct Part {
    lengths: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

/// G from its rows, tasks in parallel.
fn assemble<B: RowBuilder>(
    n: usize,
    builder: impl Fn() -> B + Sync + Send,
) -> Result<SparseMatrix<f64>, SetupError> {
    let tasks = 0..n.div_ceil(ROWS_PER_TASK);
    let parts: Vec<Result<Part, SetupError>> = tasks
        .into_par_iter()
        .map_init(
            || (builder(), Row::new()),
            |(builder, row), task| {
                let range = task * ROWS_PER_TASK..n.min((task + 1) * ROWS_PER_TASK);
                part(builder, row, range)
            },
        )
        .collect();
    let (mut offsets, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for part in parts {
        let part = part?;
        for len in part.lengths {
            offsets.push(offsets[offsets.len() - 1] + len);
        }
        columns.extend(part.columns);
        values.extend(part.values);
    }
    Ok(SparseMatrix::new((n, n), offsets, columns, values))
}

fn part<B: RowBuilder>(
    builder: &mut B,
    row: &mut Row,
    range: std::ops::Range<usize>,
) -> Result<Part, SetupError> {
    let mut part = Part::default();
    for i in range {
        row.clear();
        let psi = builder
            .row(i, row)
            .map_err(|cause| not_positive_definite(i, cause))?;
        let scale = psi.sqrt().recip();
        part.lengths.push(row.len() + 1);
        part.columns.extend(row.iter().map(|entry| entry.0));
        part.columns.push(i as u32);
        part.values.extend(row.iter().map(|entry| scale * entry.1));
        part.values.push(scale);
    }
    Ok(part)
}

fn not_positive_definite(i: usize, cause: NotPositive) -> SetupError {
    let what = match cause {
        NotPositive::Column => "the local block of this row of FSAI has a non-positive pivot",
        NotPositive::Row => "the row depends on the rows before it, so FSAI cannot scale it",
    };
    SetupError::NotPositiveDefinite {
        block: BLOCK,
        row: i + 1,
        advice: format!("{what}; the matrix must be positive definite and not singular"),
    }
}
