//! What iterating and judging need of a saddle point, assembled or not.

use super::{EnergyNorms, P, SaddleBlocks, SaddleOperator, StrainNorm, T, U};
use fracas_operators::{Layout, LinearOperator, vector};
use std::borrow::Cow;

/// A generalized saddle point `𝒜 = [A B1; B2 −H]` (with flow `[A B1 Q1; B2 −H 0; Q2 0 T]`), assembled or not.
pub trait SaddleSystem {
    /// 𝒜.
    fn operator(&self) -> &dyn LinearOperator<f64>;

    /// The fields of its unknowns.
    fn layout(&self) -> Layout;

    /// True where 𝒜 and whatever preconditions it are symmetric, so that short recurrences apply.
    fn has_short_recurrences(&self) -> bool;

    /// `‖𝒜‖_∞`, or a lower bound close to it.
    fn norm_inf(&self) -> f64;

    /// `|B1|ᵀ|u| + |b_t|`.
    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64>;

    /// Norms of errors in u and t; `own` where the right-hand side is that of the system, with its prescribed displacements.
    fn norms(&self, own: bool) -> EnergyNorms<'_>;

    /// `‖b − 𝒜x‖₂ / ‖b‖₂` with rows of tractions divided by the unit that they were multiplied by.
    fn relative_residual_in(
        &self,
        unit: f64,
        (x, b): (&[f64], &[f64]),
        entries: Option<&SaddleBlocks>,
    ) -> Option<f64> {
        let operator = self.operator();
        let (mut r, mut b) = (b.to_vec(), b.to_vec());
        match entries {
            Some(blocks) => blocks.residual(&b, &[x], &mut r),
            None => operator.apply_add(-1.0, x, &mut r, &mut vec![0.0; operator.work_len()]),
        }
        for v in [&mut r, &mut b] {
            let [t] = self.layout().split_mut([T], v);
            t.iter_mut().for_each(|t| *t /= unit);
        }
        let relative = match vector::norm2(&r) {
            0.0 => 0.0,
            size => size / vector::norm2(&b),
        };
        relative.is_finite().then_some(relative)
    }

    /// Measures of `b − 𝒜x`; in twice the digits from the entries of 𝒜, where they are given.
    fn residual(&self, x: &[f64], b: &[f64], entries: Option<&SaddleBlocks>) -> ResidualNorms {
        let operator = self.operator();
        let mut r = b.to_vec();
        match entries {
            Some(blocks) => blocks.residual(b, &[x], &mut r),
            None => operator.apply_add(-1.0, x, &mut r, &mut vec![0.0; operator.work_len()]),
        }
        let over = |r: f64, scale: f64| if r == 0.0 { 0.0 } else { r / scale };
        let number = |v: f64| v.is_finite().then_some(v);
        let [r_t] = self.layout().split([T], &r);
        let jumps = vector::norm_inf(&self.contact_scale(x, b));
        let scale = self.norm_inf() * vector::norm_inf(x) + vector::norm_inf(b);
        ResidualNorms {
            relative: number(over(vector::norm2(&r), vector::norm2(b))),
            backward: number(over(vector::norm_inf(&r), scale)),
            contact: number(over(vector::norm_inf(r_t), jumps)),
        }
    }
}

/// Measures of `b − 𝒜x`; `None` where one is not a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResidualNorms {
    /// `‖b − 𝒜x‖₂ / ‖b‖₂`; 0 for b = 0.
    pub relative: Option<f64>,
    /// `‖b − 𝒜x‖_∞ / (‖𝒜‖_∞ ‖x‖_∞ + ‖b‖_∞)`.
    pub backward: Option<f64>,
    /// `‖r_t‖_∞ / ‖|B1|ᵀ|u| + |b_t|‖_∞`.
    pub contact: Option<f64>,
}

impl SaddleBlocks {
    /// `|B1|ᵀ|u| + |b_t|`.
    pub(super) fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        let ([u], [b_t]) = (self.layout().split([U], x), self.layout().split([T], b));
        let mut scale: Vec<f64> = b_t.iter().map(|b| b.abs()).collect();
        for (row, u) in self.b1.outer_iterator().zip(u) {
            row.iter().for_each(|(j, b)| scale[j] += (b * u).abs());
        }
        scale
    }
}

/// Assembled blocks.
pub struct Assembled<'a> {
    blocks: &'a SaddleBlocks,
    operator: SaddleOperator<'a>,
    strain: Option<StrainNorm<'a>>,
}

impl<'a> Assembled<'a> {
    /// The blocks, and the norm of strain of their solution where displacements are prescribed.
    pub fn new(blocks: &'a SaddleBlocks, strain: Option<StrainNorm<'a>>) -> Self {
        Self {
            blocks,
            operator: SaddleOperator::new(blocks),
            strain,
        }
    }
}

impl SaddleSystem for Assembled<'_> {
    fn operator(&self) -> &dyn LinearOperator<f64> {
        &self.operator
    }

    fn layout(&self) -> Layout {
        self.blocks.layout()
    }

    fn has_short_recurrences(&self) -> bool {
        // not every method of the list is symmetric
        false
    }

    fn norm_inf(&self) -> f64 {
        self.blocks.norm_inf()
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        self.blocks.contact_scale(x, b)
    }

    fn norms(&self, own: bool) -> EnergyNorms<'_> {
        let c = self.blocks.contact_compliance();
        let stiffness = Cow::Owned(self.blocks.stiffness());
        let strain = self.strain.as_deref().filter(|_| own);
        let norms = EnergyNorms::new(&self.operator, self.blocks.h.as_ref(), c, stiffness);
        let norms = match &self.blocks.flow {
            Some(flow) => norms.and(P, self.blocks.pressure_compliance(), &flow.t),
            None => norms,
        };
        norms
            .against(strain.map(|norm| -> StrainNorm<'_> { Box::new(norm) }))
            .with_entries(self.blocks)
    }
}
