//! The rows of one rank, with ghosts, as operators.

use super::{Numbering, Ranks};
use crate::SetupError;
use crate::petsc::ghosts::Ghosts;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::{CsrView, SparseMatrix, Triplets};
use fracas_operators::{AdjointOperator, LinearOperator, Shape};
use std::sync::Arc;

/// Rows of A, B, Bᵀ and H on this rank: columns are its own entries, then ghosts.
pub(super) struct Parts {
    pub(super) ranks: Ranks,
    pub(super) a: SparseMatrix<f64>,
    pub(super) b: SparseMatrix<f64>,
    pub(super) bt: SparseMatrix<f64>,
    pub(super) h: Option<SparseMatrix<f64>>,
    pub(super) ghosts_u: Ghosts,
    ghosts_t: Ghosts,
    /// Displacements among the ghosts, in the numbering of all.
    pub(super) of_u: Vec<u32>,
    /// Flops of A, B and H over all ranks.
    flops: [u64; 3],
}

/// Some rows of a matrix.
pub(super) fn rows_of(m: &SparseMatrix<f64>, rows: &[u32]) -> SparseMatrix<f64> {
    let mut some = Triplets::new((rows.len(), m.cols()));
    for (k, row) in rows.iter().enumerate() {
        for (j, v) in (m.outer_view(*row as usize).iter()).flat_map(|row| row.iter()) {
            some.add_triplet(k, j, *v);
        }
    }
    some.to_csr()
}

/// Columns that are not this rank's, ascending.
fn ghosts_of<'m>(
    matrices: impl IntoIterator<Item = &'m SparseMatrix<f64>>,
    of: impl Fn(u32) -> (u32, u32),
    rank: u32,
) -> Vec<u32> {
    let mut found = Vec::new();
    for m in matrices {
        found.extend(m.indices().iter().copied().filter(|j| of(*j).0 != rank));
        found.sort_unstable();
        found.dedup();
    }
    found
}

/// The same rows with columns renumbered: own entries in front, ghosts behind; entries move in place.
fn localized(
    m: SparseMatrix<f64>,
    own: usize,
    of: impl Fn(u32) -> (u32, u32),
    rank: u32,
    ghosts: &[u32],
) -> SparseMatrix<f64> {
    let rows = m.rows();
    let (offsets, mut columns, mut values) = m.into_raw_storage();
    let mut behind = Vec::new();
    for row in offsets.windows(2) {
        behind.clear();
        let mut kept = row[0];
        for k in row[0]..row[1] {
            match of(columns[k]) {
                (owner, place) if owner == rank => {
                    (columns[kept], values[kept]) = (place, values[k]);
                    kept += 1;
                }
                _ => {
                    let ghost = ghosts.partition_point(|g| *g < columns[k]);
                    behind.push(((own + ghost) as u32, values[k]));
                }
            }
        }
        for (k, entry) in (kept..row[1]).zip(&behind) {
            (columns[k], values[k]) = *entry;
        }
    }
    SparseMatrix::new((rows, own + ghosts.len()), offsets, columns, values)
}

impl Parts {
    /// From this rank's rows of A, with the columns of all, and all of B and H; by all ranks together.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] where PETSc makes no way for messages.
    pub(super) fn new(
        numbering: &Numbering,
        a: SparseMatrix<f64>,
        b: &SparseMatrix<f64>,
        h: Option<&SparseMatrix<f64>>,
    ) -> Result<Self, SetupError> {
        let ranks = numbering.ranks();
        let rank = ranks.rank() as u32;
        let (own_u, own_t) = (numbering.own_u(), numbering.own_t());
        let (n_u, n_t) = (own_u.len(), own_t.len());
        let bt = rows_of(&b.transpose_view().to_csr(), own_t);
        let b = rows_of(b, own_u);
        let h = h.map(|h| rows_of(h, own_t));
        let of_u = ghosts_of([&a, &bt], |i| numbering.of_u(i), rank);
        let of_t = ghosts_of([&b].into_iter().chain(&h), |k| numbering.of_t(k), rank);
        let local_u = |m| localized(m, n_u, |i| numbering.of_u(i), rank, &of_u);
        let local_t = |m| localized(m, n_t, |k| numbering.of_t(k), rank, &of_t);
        let homes_u: Vec<_> = of_u.iter().map(|i| numbering.of_u(*i)).collect();
        let homes_t: Vec<_> = of_t.iter().map(|k| numbering.of_t(*k)).collect();
        let (a, b, bt, h) = (local_u(a), local_t(b), local_u(bt), h.map(local_t));
        let of = |m: &SparseMatrix<f64>| 2.0 * (m.nnz() + m.rows()) as f64;
        let mut flops = [of(&a), of(&b), h.as_ref().map_or(0.0, of)];
        ranks.sum(&mut flops);
        Ok(Self {
            ranks,
            ghosts_u: Ghosts::new(n_u, &homes_u)?,
            ghosts_t: Ghosts::new(n_t, &homes_t)?,
            a,
            b,
            bt,
            h,
            of_u,
            flops: flops.map(|f| f as u64),
        })
    }

    pub(super) fn n_u(&self) -> usize {
        self.a.rows()
    }

    pub(super) fn n_t(&self) -> usize {
        self.bt.rows()
    }

    /// Entries of u with ghosts.
    pub(super) fn with_ghosts_u(&self) -> usize {
        self.a.cols()
    }

    fn with_ghosts_t(&self) -> usize {
        self.b.cols()
    }

    /// u with its ghosts, in `work`.
    pub(super) fn extended_u<'w>(
        &self,
        u: &[f64],
        work: &'w mut [f64],
    ) -> (&'w [f64], &'w mut [f64]) {
        extended(&self.ghosts_u, u, work)
    }

    fn extended_t<'w>(&self, t: &[f64], work: &'w mut [f64]) -> (&'w [f64], &'w mut [f64]) {
        extended(&self.ghosts_t, t, work)
    }
}

fn extended<'w>(ghosts: &Ghosts, own: &[f64], work: &'w mut [f64]) -> (&'w [f64], &'w mut [f64]) {
    let (all, rest) = work.split_at_mut(own.len() + ghosts.len());
    let (front, behind) = all.split_at_mut(own.len());
    front.copy_from_slice(own);
    ghosts.fill(own, behind);
    (all, rest)
}

/// `y ← y + α M x` by the rows of this rank.
fn add(m: &SparseMatrix<f64>, alpha: f64, x: &[f64], y: &mut [f64]) {
    CsrView::new(m).apply_add(alpha, x, y, &mut []);
}

/// 𝒜 = [A B; Bᵀ −H].
pub(super) struct Whole(pub(super) Arc<Parts>);

impl LinearOperator<f64> for Whole {
    fn shape(&self) -> Shape {
        Shape::square(self.0.n_u() + self.0.n_t())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let parts = &self.0;
        let (x_u, x_t) = x.split_at(parts.n_u());
        let (y_u, y_t) = y.split_at_mut(parts.n_u());
        let (x_u, work) = parts.extended_u(x_u, work);
        let (x_t, _) = parts.extended_t(x_t, work);
        // y_u += α (A x_u + B x_t), y_t += α (Bᵀx_u − H x_t)
        add(&parts.a, alpha, x_u, y_u);
        add(&parts.b, alpha, x_t, y_u);
        add(&parts.bt, alpha, x_u, y_t);
        if let Some(h) = &parts.h {
            add(h, -alpha, x_t, y_t);
        }
    }

    fn work_len(&self) -> usize {
        self.0.with_ghosts_u() + self.0.with_ghosts_t()
    }

    fn flops(&self) -> u64 {
        let [a, b, h] = self.0.flops;
        a + 2 * b + h
    }

    fn sum_over_parts(&self, sums: &mut [f64]) {
        self.0.ranks.sum(sums);
    }
}

/// B.
pub(super) struct Coupled(pub(super) Arc<Parts>);

impl LinearOperator<f64> for Coupled {
    fn shape(&self) -> Shape {
        Shape::new(self.0.n_u(), self.0.n_t())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let (x, _) = self.0.extended_t(x, work);
        add(&self.0.b, alpha, x, y);
    }

    fn work_len(&self) -> usize {
        self.0.with_ghosts_u().max(self.0.with_ghosts_t())
    }

    fn flops(&self) -> u64 {
        self.0.flops[1]
    }

    fn sum_over_parts(&self, sums: &mut [f64]) {
        self.0.ranks.sum(sums);
    }
}

impl AdjointOperator<f64> for Coupled {
    fn apply_adjoint_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape().transposed(), x, y);
        let (x, _) = self.0.extended_u(x, work);
        add(&self.0.bt, alpha, x, y);
    }

    fn adjoint_flops(&self) -> u64 {
        self.0.flops[1]
    }
}

/// H, which there is.
pub(super) struct Stabilized(pub(super) Arc<Parts>);

impl LinearOperator<f64> for Stabilized {
    fn shape(&self) -> Shape {
        Shape::square(self.0.n_t())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let (x, _) = self.0.extended_t(x, work);
        if let Some(h) = &self.0.h {
            add(h, alpha, x, y);
        }
    }

    fn work_len(&self) -> usize {
        self.0.with_ghosts_t()
    }

    fn flops(&self) -> u64 {
        self.0.flops[2]
    }

    fn sum_over_parts(&self, sums: &mut [f64]) {
        self.0.ranks.sum(sums);
    }
}
