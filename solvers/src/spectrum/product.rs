//! `M⁻¹𝒜` as an operator.

use crate::saddle::SaddleBlocks;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::axpy;
use fracas_operators::{Layout, LinearOperator, Preconditioner, Shape};

/// `y = M⁻¹ [A B1; B2 −H] x`, assembled.
pub(super) struct Preconditioned<'a> {
    a: Csr<f64>,
    b1: Csr<f64>,
    b2: Csr<f64>,
    h: Option<Csr<f64>>,
    m: &'a dyn Preconditioner<f64>,
    layout: Layout<2>,
}

impl<'a> Preconditioned<'a> {
    pub(super) fn new(blocks: &SaddleBlocks, m: &'a dyn Preconditioner<f64>) -> Self {
        let b2 = match &blocks.b2 {
            Some(b2) => b2.clone(),
            None => blocks.b1.transpose_view().to_csr(),
        };
        Self {
            a: Csr::new(blocks.a.clone()),
            b1: Csr::new(blocks.b1.clone()),
            b2: Csr::new(b2),
            h: blocks.h.clone().map(Csr::new),
            m,
            layout: Layout::new(["u", "t"], [blocks.n_u(), blocks.n_t()]),
        }
    }
}

impl LinearOperator<f64> for Preconditioned<'_> {
    fn shape(&self) -> Shape {
        Shape::square(self.layout.len())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let (w, work) = work.split_at_mut(x.len());
        let (z, work) = work.split_at_mut(x.len());
        let [x_u, x_t] = self.layout.split(x);
        let [w_u, w_t] = self.layout.split_mut(w);
        // w_u = A x_u + B1 x_t
        self.a.apply(x_u, w_u, work);
        self.b1.apply_add(1.0, x_t, w_u, work);
        // w_t = B2 x_u − H x_t
        self.b2.apply(x_u, w_t, work);
        if let Some(h) = &self.h {
            h.apply_add(-1.0, x_t, w_t, work);
        }
        self.m.solve(w, z, work);
        axpy(alpha, z, y);
    }

    fn work_len(&self) -> usize {
        2 * self.layout.len() + self.m.work_len()
    }

    fn flops(&self) -> u64 {
        let h = self.h.as_ref().map_or(0, |h| h.flops());
        self.a.flops()
            + self.b1.flops()
            + self.b2.flops()
            + h
            + self.m.flops()
            + 2 * self.layout.len() as u64
    }
}

/// `D_u = √diag(S_u)`, `D_t = √diag(C)`: scales in which u and t have the same unit (square root of energy).
pub(super) fn energy_scales(blocks: &SaddleBlocks, c_diagonal: &[f64]) -> Vec<f64> {
    let stiffness = (0..blocks.n_u()).map(|i| {
        let a_ii = blocks.a.get(i, i).copied().unwrap_or(0.0);
        let augmentation: f64 = blocks.b1.outer_view(i).map_or(0.0, |row| {
            row.iter().map(|(k, b)| b * b / c_diagonal[k]).sum()
        });
        let sum = a_ii + augmentation;
        if sum > 0.0 { sum.sqrt() } else { 1.0 }
    });
    stiffness
        .chain(c_diagonal.iter().map(|c| c.sqrt()))
        .collect()
}
