//! 𝒜 as an operator and as one assembled matrix.

use super::{P, SaddleBlocks, T, U};
use fracas_operators::sparse::{Csr, CsrView, SparseMatrix};
use fracas_operators::{BlockOperator, LinearOperator, Shape};

/// `𝒜 = [A B1; B2 −H]`, or `[A B1 Q1; B2 −H 0; Q2 0 T]` with flow, ready for products.
///
/// # Cost
/// One product: `2 (nnz A + nnz B1 + nnz B2 + nnz H)` flops. B1ᵀ is stored so that both couplings run by rows.
pub struct SaddleOperator<'a>(BlockOperator<'a, f64>);

impl<'a> SaddleOperator<'a> {
    /// Borrows the blocks.
    pub fn new(blocks: &'a SaddleBlocks) -> Self {
        Self::with_a(blocks, CsrView::new(&blocks.a))
    }

    /// With A by something else than the blocks.
    pub(super) fn with_a(blocks: &'a SaddleBlocks, a: impl LinearOperator<f64> + 'a) -> Self {
        let b1 = CsrView::new(&blocks.b1);
        let b2: Box<dyn LinearOperator<f64> + 'a> = match &blocks.b2 {
            Some(b2) => Box::new(CsrView::new(b2)),
            None => Box::new(Csr::new(blocks.b1.transpose_view().to_csr())),
        };
        let mut operator = BlockOperator::new(blocks.layout())
            .with([U, U], 1.0, a)
            .with([U, T], 1.0, b1)
            .with([T, U], 1.0, b2);
        if let Some(h) = &blocks.h {
            operator = operator.with([T, T], -1.0, CsrView::new(h));
        }
        if let Some(flow) = &blocks.flow {
            operator = operator
                .with([U, P], 1.0, CsrView::new(&flow.q1))
                .with([P, U], 1.0, CsrView::new(&flow.q2))
                .with([P, P], 1.0, CsrView::new(&flow.t));
        }
        Self(operator)
    }
}

impl LinearOperator<f64> for SaddleOperator<'_> {
    fn shape(&self) -> Shape {
        self.0.shape()
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        self.0.apply_add(alpha, x, y, work);
    }

    fn work_len(&self) -> usize {
        self.0.work_len()
    }

    fn flops(&self) -> u64 {
        self.0.flops()
    }
}

impl SaddleBlocks {
    /// Unknowns in all.
    pub fn size(&self) -> usize {
        self.n_u() + self.n_t() + self.n_p()
    }

    /// `(rhs_u, rhs_t, rhs_p)` as one vector.
    pub fn rhs(&self) -> Vec<f64> {
        let rhs_p = self.flow.as_ref().map_or(&[][..], |f| &f.rhs_p);
        [&self.rhs_u, &self.rhs_t, rhs_p].concat()
    }

    /// `‖𝒜‖_∞`, the largest row sum of absolute values.
    pub fn norm_inf(&self) -> f64 {
        self.norm_inf_with(|sums| add_row_sums(&self.a, sums))
    }

    /// The same where `of_a` adds the row sums of A.
    pub(super) fn norm_inf_with(&self, of_a: impl FnOnce(&mut [f64])) -> f64 {
        let mut sums = vec![0.0; self.size()];
        let [of_u, of_t] = self.layout().split_mut([U, T], &mut sums);
        of_a(of_u);
        add_row_sums(&self.b1, of_u);
        match &self.b2 {
            Some(b2) => add_row_sums(b2, of_t),
            None => {
                for (value, (_, j)) in &self.b1 {
                    of_t[j as usize] += value.abs();
                }
            }
        }
        if let Some(h) = &self.h {
            add_row_sums(h, of_t);
        }
        if let Some(flow) = &self.flow {
            let [of_u, of_p] = self.layout().split_mut([U, P], &mut sums);
            add_row_sums(&flow.q1, of_u);
            add_row_sums(&flow.q2, of_p);
            add_row_sums(&flow.t, of_p);
        }
        sums.into_iter().fold(0.0, f64::max)
    }

    /// 𝒜 as one matrix by rows, for direct solvers and dense analysis.
    pub fn assembled(&self) -> SparseMatrix<f64> {
        let transposed;
        let b2 = match &self.b2 {
            Some(b2) => b2,
            None => {
                transposed = self.b1.transpose_view().to_csr();
                &transposed
            }
        };
        let first = |field| self.layout().range(field).start;
        let (u, t) = (first(U), first(T));
        let h: Vec<Placed<'_>> = self.h.iter().map(|h| (-1.0, t, h)).collect();
        let mut rows = vec![
            vec![(1.0, u, &self.a), (1.0, t, &self.b1)],
            [vec![(1.0, u, b2)], h].concat(),
        ];
        if let Some(flow) = &self.flow {
            let p = first(P);
            rows[0].push((1.0, p, &flow.q1));
            rows.push(vec![(1.0, u, &flow.q2), (1.0, p, &flow.t)]);
        }
        stack(self.size(), &rows)
    }
}

/// `sums_i += Σ_j |m_ij|`.
fn add_row_sums(m: &SparseMatrix<f64>, sums: &mut [f64]) {
    for (row, sum) in m.outer_iterator().zip(sums) {
        *sum += row.data().iter().map(|v| v.abs()).sum::<f64>();
    }
}

/// A factor times a block that starts at a column.
type Placed<'a> = (f64, usize, &'a SparseMatrix<f64>);

/// Rows of blocks side by side, block row after block row; columns ascend within a block row.
fn stack(n: usize, rows: &[Vec<Placed<'_>>]) -> SparseMatrix<f64> {
    let nnz = rows.iter().flatten().map(|(_, _, block)| block.nnz()).sum();
    let (mut starts, mut columns, mut values) = (
        Vec::with_capacity(n + 1),
        Vec::with_capacity(nnz),
        Vec::with_capacity(nnz),
    );
    starts.push(0);
    for blocks in rows {
        let height = blocks.first().map_or(0, |(_, _, block)| block.rows());
        for i in 0..height {
            for (factor, column, block) in blocks {
                let row = block.outer_view(i);
                for (j, value) in row.iter().flat_map(|row| row.iter()) {
                    columns.push((column + j) as u32);
                    values.push(factor * value);
                }
            }
            starts.push(columns.len());
        }
    }
    SparseMatrix::new((n, n), starts, columns, values)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::saddle::FlowBlocks;
    use fracas_operators::Dense;
    use fracas_operators::laws::check_operator;
    use fracas_operators::sparse::Triplets;

    fn matrix(rows: usize, cols: usize, seed: usize) -> SparseMatrix<f64> {
        let mut triplets = Triplets::new((rows, cols));
        for i in 0..rows {
            for j in 0..cols {
                if !(i * 7 + j * 3 + seed).is_multiple_of(4) {
                    triplets.add_triplet(i, j, ((i + 10 * j + 100 * seed) as f64).sin());
                }
            }
        }
        triplets.to_csr()
    }

    fn systems() -> [SaddleBlocks; 3] {
        let plain = SaddleBlocks {
            a: matrix(6, 6, 0),
            b1: matrix(6, 3, 1),
            b2: None,
            h: None,
            rhs_u: vec![1.0; 6],
            rhs_t: vec![2.0; 3],
            coordinates: None,
            flow: None,
        };
        let slip = SaddleBlocks {
            b2: Some(matrix(3, 6, 2)),
            h: Some(matrix(3, 3, 3)),
            ..plain.clone()
        };
        let flow = FlowBlocks {
            q1: matrix(6, 2, 4),
            q2: matrix(2, 6, 5),
            t: matrix(2, 2, 6),
            rhs_p: vec![3.0; 2],
        };
        [
            plain,
            slip.clone(),
            SaddleBlocks {
                flow: Some(flow),
                ..slip
            },
        ]
    }

    #[test]
    fn products_agree_with_the_assembled_matrix_and_with_the_blocks() {
        for blocks in systems() {
            let operator = SaddleOperator::new(&blocks);
            let assembled = blocks.assembled();
            let dense = Dense::of_operator(&operator);
            let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
            assert_eq!(blocks.rhs().len(), blocks.size());
            let row_sum = |i: usize| {
                (0..blocks.size())
                    .map(|j| dense.entry(i, j).abs())
                    .sum::<f64>()
            };
            let largest = (0..blocks.size()).map(row_sum).fold(0.0, f64::max);
            assert!((blocks.norm_inf() - largest).abs() < 1e-13 * largest);
            for i in 0..blocks.size() {
                for j in 0..blocks.size() {
                    assert_eq!(dense.entry(i, j), *assembled.get(i, j).unwrap_or(&0.0));
                }
            }
            for (k, i) in blocks.layout().range(T).enumerate() {
                let h = |j| {
                    blocks
                        .h
                        .as_ref()
                        .and_then(|h| h.get(k, j))
                        .copied()
                        .unwrap_or(0.0)
                };
                assert!((0..n_t).all(|j| dense.entry(i, n_u + j) == -h(j)));
                let b1 = |j| *blocks.b1.get(j, k).unwrap_or(&0.0);
                assert!(blocks.b2.is_some() || (0..n_u).all(|j| dense.entry(i, j) == b1(j)));
            }
            check_operator("saddle", &operator, Some(&dense)).unwrap();
        }
    }
}
