//! 𝒜 as an operator and as one assembled matrix.

use super::SaddleBlocks;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::{Csr, CsrView, SparseMatrix};
use fracas_operators::{BlockOperator, Layout, LinearOperator, Shape};

/// `𝒜 = [A B1; B2 −H]`, or `[A B1 Q1; B2 −H 0; Q2 0 T]` with flow, ready for products.
///
/// # Cost
/// One product: `2 (nnz A + nnz B1 + nnz B2 + nnz H)` flops. B1ᵀ is stored so that both couplings run by rows.
#[derive(Clone, Debug)]
pub struct SaddleOperator<'a> {
    a: CsrView<'a, f64>,
    b1: CsrView<'a, f64>,
    b2: SecondCoupling<'a>,
    h: Option<CsrView<'a, f64>>,
    flow: Option<FlowOperators<'a>>,
}

/// B2: given, or B1ᵀ stored by rows.
#[derive(Clone, Debug)]
enum SecondCoupling<'a> {
    Given(CsrView<'a, f64>),
    Transposed(Csr<f64>),
}

#[derive(Clone, Debug)]
struct FlowOperators<'a> {
    q1: CsrView<'a, f64>,
    q2: CsrView<'a, f64>,
    t: CsrView<'a, f64>,
}

impl<'a> SaddleOperator<'a> {
    /// Borrows the blocks.
    pub fn new(blocks: &'a SaddleBlocks) -> Self {
        let flow = blocks.flow.as_ref().map(|f| FlowOperators {
            q1: CsrView::new(&f.q1),
            q2: CsrView::new(&f.q2),
            t: CsrView::new(&f.t),
        });
        let b2 = match &blocks.b2 {
            Some(b2) => SecondCoupling::Given(CsrView::new(b2)),
            None => SecondCoupling::Transposed(Csr::new(blocks.b1.transpose_view().to_csr())),
        };
        Self {
            a: CsrView::new(&blocks.a),
            b1: CsrView::new(&blocks.b1),
            b2,
            h: blocks.h.as_ref().map(CsrView::new),
            flow,
        }
    }

    /// `[A B1; B2 −H]` without flow.
    fn two_fields(&self) -> BlockOperator<'_, f64, 2> {
        let layout = Layout::new(["u", "t"], [self.b1.shape().rows, self.b1.shape().cols]);
        let b2: &dyn LinearOperator<f64> = match &self.b2 {
            SecondCoupling::Given(b2) => b2,
            SecondCoupling::Transposed(b2) => b2,
        };
        BlockOperator::new(
            layout,
            [
                [Some((1.0, &self.a)), Some((1.0, &self.b1))],
                [
                    Some((1.0, b2)),
                    self.h
                        .as_ref()
                        .map(|h| (-1.0, h as &dyn LinearOperator<f64>)),
                ],
            ],
        )
    }

    /// Unknowns of u and t.
    fn mechanical(&self) -> usize {
        self.b1.shape().rows + self.b1.shape().cols
    }
}

impl LinearOperator<f64> for SaddleOperator<'_> {
    fn shape(&self) -> Shape {
        let n_p = self.flow.as_ref().map_or(0, |f| f.t.shape().rows);
        Shape::square(self.mechanical() + n_p)
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let ((x_ut, x_p), (y_ut, y_p)) = (
            x.split_at(self.mechanical()),
            y.split_at_mut(self.mechanical()),
        );
        self.two_fields().apply_add(alpha, x_ut, y_ut, work);
        if let Some(flow) = &self.flow {
            let n_u = self.b1.shape().rows;
            flow.q1.apply_add(alpha, x_p, &mut y_ut[..n_u], work);
            flow.q2.apply_add(alpha, &x_ut[..n_u], y_p, work);
            flow.t.apply_add(alpha, x_p, y_p, work);
        }
    }

    fn work_len(&self) -> usize {
        0
    }

    fn flops(&self) -> u64 {
        let flow = self
            .flow
            .as_ref()
            .map_or(0, |f| f.q1.flops() + f.q2.flops() + f.t.flops());
        self.two_fields().flops() + flow
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
        let (n_u, n_t) = (self.n_u(), self.n_t());
        let mut sums = vec![0.0; self.size()];
        add_row_sums(&self.a, &mut sums);
        add_row_sums(&self.b1, &mut sums);
        match &self.b2 {
            Some(b2) => add_row_sums(b2, &mut sums[n_u..]),
            None => {
                for (value, (_, j)) in &self.b1 {
                    sums[n_u + j as usize] += value.abs();
                }
            }
        }
        if let Some(h) = &self.h {
            add_row_sums(h, &mut sums[n_u..]);
        }
        if let Some(flow) = &self.flow {
            add_row_sums(&flow.q1, &mut sums);
            add_row_sums(&flow.q2, &mut sums[n_u + n_t..]);
            add_row_sums(&flow.t, &mut sums[n_u + n_t..]);
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
        let (u, t, p) = (0, self.n_u(), self.n_u() + self.n_t());
        let h: Vec<Placed<'_>> = self.h.iter().map(|h| (-1.0, t, h)).collect();
        let mut rows = vec![
            vec![(1.0, u, &self.a), (1.0, t, &self.b1)],
            [vec![(1.0, u, b2)], h].concat(),
        ];
        if let Some(flow) = &self.flow {
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
            for (k, i) in (n_u..n_u + n_t).enumerate() {
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
