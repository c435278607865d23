//! `M⁻¹𝒜` as an operator.

use crate::saddle::{SaddleBlocks, SaddleOperator};
use fracas_operators::operator::assert_product;
use fracas_operators::vector::axpy;
use fracas_operators::{LinearOperator, Preconditioner, Shape};

/// `y = M⁻¹ 𝒜 x`, 𝒜 assembled.
pub(super) struct Preconditioned<'a> {
    saddle: SaddleOperator<'a>,
    m: &'a dyn Preconditioner<f64>,
}

impl<'a> Preconditioned<'a> {
    pub(super) fn new(blocks: &'a SaddleBlocks, m: &'a dyn Preconditioner<f64>) -> Self {
        let saddle = SaddleOperator::new(blocks);
        assert_eq!(
            saddle.shape(),
            Shape::square(m.size()),
            "𝒜 and M differ in size"
        );
        Self { saddle, m }
    }
}

impl LinearOperator<f64> for Preconditioned<'_> {
    fn shape(&self) -> Shape {
        self.saddle.shape()
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        assert_product(self.shape(), x, y);
        let (w, work) = work.split_at_mut(x.len());
        let (z, work) = work.split_at_mut(x.len());
        self.saddle.apply(x, w, work);
        self.m.solve(w, z, work);
        axpy(alpha, z, y);
    }

    fn work_len(&self) -> usize {
        2 * self.m.size() + self.m.work_len().max(self.saddle.work_len())
    }

    fn flops(&self) -> u64 {
        self.saddle.flops() + self.m.flops() + 2 * self.m.size() as u64
    }
}

/// `D_u = √diag(S_u)`, `D_t = √diag(C)`: scales in which u and t have the same unit (square root of energy); with flow
/// `D_p = √(diag(Q1ᵀ diag(A)⁻¹ Q1) + |diag T|)` behind them.
pub(super) fn energy_scales(blocks: &SaddleBlocks, c_diagonal: &[f64]) -> Vec<f64> {
    let stiffness = (0..blocks.n_u()).map(|i| {
        let a_ii = blocks.a.get(i, i).copied().unwrap_or(0.0);
        let augmentation: f64 = blocks.b1.outer_view(i).map_or(0.0, |row| {
            row.iter().map(|(k, b)| b * b / c_diagonal[k]).sum()
        });
        let sum = a_ii + augmentation;
        if sum > 0.0 { sum.sqrt() } else { 1.0 }
    });
    let compliance = blocks.pressure_compliance().into_iter().enumerate();
    let pressures = compliance.map(|(i, c)| {
        let t_ii = blocks.flow.as_ref().and_then(|flow| flow.t.get(i, i));
        (c + t_ii.map_or(0.0, |t| t.abs())).sqrt()
    });
    stiffness
        .chain(c_diagonal.iter().map(|c| c.sqrt()))
        .chain(pressures)
        .collect()
}
