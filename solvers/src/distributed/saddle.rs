//! 𝒜 by rows over ranks, its norms and its residuals.

use super::parts::{Parts, Stabilized, Whole};
use super::{Numbering, Ranks};
use crate::saddle::{
    EnergyNorms, ResidualNorms, SaddleBlocks, SaddleSystem, Stiffness, StrainNorm, T, U,
};
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector;
use fracas_operators::{Layout, LinearOperator};
use std::borrow::Cow;
use std::sync::Arc;

/// What this rank has of `wᵀA w`, A and w with the prescribed displacements: of its own displacements, then the ghosts.
pub type PartStrain = Box<dyn Fn(&[f64]) -> f64 + Send + Sync>;

/// `[A B; Bᵀ −H]` over ranks, each with its rows.
pub struct SpreadSaddle {
    numbering: Numbering,
    parts: Arc<Parts>,
    operator: Whole,
    /// C_0 of the own tractions.
    compliance: Vec<f64>,
    stiffness: Stiffness,
    strain: Option<PartStrain>,
    norm_inf: f64,
}

/// `Σ_j |m_ij|`.
fn row_sum(m: &SparseMatrix<f64>, i: usize) -> f64 {
    let row = m.outer_view(i);
    let sum = row.map(|row| row.data().iter().map(|v| v.abs()).sum());
    sum.unwrap_or(0.0)
}

impl SpreadSaddle {
    /// Of rows, with C_0 of all tractions; by all ranks together.
    pub(super) fn new(numbering: Numbering, parts: Arc<Parts>, compliance: &[f64]) -> Self {
        let ranks = numbering.ranks();
        let entry = |i| parts.a.get(i, i).map_or(0.0, |a| a.abs());
        let entries = (0..parts.n_u()).map(entry);
        let largest = ranks.max(entries.clone().fold(0.0, f64::max));
        let of_u = (0..parts.n_u()).map(|i| row_sum(&parts.a, i) + row_sum(&parts.b, i));
        let of_h = |k| parts.h.as_ref().map_or(0.0, |h| row_sum(h, k));
        let of_t = (0..parts.n_t()).map(|k| row_sum(&parts.bt, k) + of_h(k));
        let norm_inf = ranks.max(of_u.chain(of_t).fold(0.0, f64::max));
        let own = numbering.own_t().iter();
        Self {
            compliance: own.map(|k| compliance[*k as usize]).collect(),
            stiffness: Stiffness::new(largest, entries),
            operator: Whole(parts.clone()),
            strain: None,
            norm_inf,
            numbering,
            parts,
        }
    }

    /// Judges displacements against this norm, where some are prescribed.
    #[must_use]
    pub fn with_strain(mut self, strain: Option<PartStrain>) -> Self {
        self.strain = strain;
        self
    }

    /// Who has what.
    pub fn numbering(&self) -> &Numbering {
        &self.numbering
    }

    /// Displacements of other ranks that this one reads, in the numbering of all.
    pub fn ghosts(&self) -> &[u32] {
        &self.parts.of_u
    }

    fn ranks(&self) -> Ranks {
        self.numbering.ranks()
    }

    /// u with ghosts.
    fn extended(&self, u: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; self.parts.with_ghosts_u()];
        self.parts.extended_u(u, &mut all);
        all
    }

    fn norm2(&self, v: &[f64]) -> f64 {
        let mut square = [vector::dot(v, v)];
        self.ranks().sum(&mut square);
        square[0].sqrt()
    }

    fn norm_inf_of(&self, v: &[f64]) -> f64 {
        self.ranks().max(vector::norm_inf(v))
    }
}

impl SaddleSystem for SpreadSaddle {
    fn operator(&self) -> &dyn LinearOperator<f64> {
        &self.operator
    }

    fn layout(&self) -> Layout {
        Layout::new([(U, self.parts.n_u()), (T, self.parts.n_t())])
    }

    fn has_short_recurrences(&self) -> bool {
        true
    }

    fn norm_inf(&self) -> f64 {
        self.norm_inf
    }

    fn contact_scale(&self, x: &[f64], b: &[f64]) -> Vec<f64> {
        let ([u], [b_t]) = (self.layout().split([U], x), self.layout().split([T], b));
        let u = self.extended(u);
        let rows = self.parts.bt.outer_iterator().zip(b_t);
        rows.map(|(row, b)| {
            let jump = row.iter().map(|(j, v)| (v * u[j]).abs());
            b.abs() + jump.sum::<f64>()
        })
        .collect()
    }

    fn norms(&self, own: bool) -> EnergyNorms<'_> {
        let h = self.parts.h.as_ref().map(|h| {
            let diagonal = (0..h.rows()).map(|k| h.get(k, k).copied().unwrap_or(0.0));
            let operator: Box<dyn LinearOperator<f64>> = Box::new(Stabilized(self.parts.clone()));
            (operator, diagonal.collect())
        });
        let strain = self.strain.as_ref().filter(|_| own);
        let norm = strain.map(|of_part| -> StrainNorm<'_> {
            Box::new(move |u| {
                let mut square = [of_part(&self.extended(u))];
                self.ranks().sum(&mut square);
                square[0].max(0.0).sqrt()
            })
        });
        let stiffness = Cow::Borrowed(&self.stiffness);
        EnergyNorms::of_parts(&self.operator, h, self.compliance.clone(), stiffness).against(norm)
    }

    fn residual(&self, x: &[f64], b: &[f64], _: Option<&SaddleBlocks>) -> ResidualNorms {
        let mut r = b.to_vec();
        let mut work = vec![0.0; self.operator.work_len()];
        self.operator.apply_add(-1.0, x, &mut r, &mut work);
        let over = |r: f64, scale: f64| if r == 0.0 { 0.0 } else { r / scale };
        let number = |v: f64| v.is_finite().then_some(v);
        let [r_t] = self.layout().split([T], &r);
        let jumps = self.norm_inf_of(&self.contact_scale(x, b));
        let scale = self.norm_inf * self.norm_inf_of(x) + self.norm_inf_of(b);
        ResidualNorms {
            relative: number(over(self.norm2(&r), self.norm2(b))),
            backward: number(over(self.norm_inf_of(&r), scale)),
            contact: number(over(self.norm_inf_of(r_t), jumps)),
        }
    }
}
