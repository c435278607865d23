//! The reverse augmented constraint preconditioner.

use super::inner::{PartCost, Ready};
use super::method::SaddleSettings;
use super::{
    AugmentationChoice, AugmentationMatrix, ContactRows, EliminatedInverse, Elimination,
    FlowBlocks, InnerChoice, NearSchur, PressureFactors, PressureSystem, RELAXATION, Relaxation,
    RelaxationSummary, SaddleBlocks, T, ThreeFields, ThreeFieldsInverse, U,
};
use crate::multigrid::Geometric;
use crate::{Prepare, SetupError};
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{AdjointOperator, Layout, LinearOperator, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// `M⁻¹ = [I 0; C⁻¹Bᵀ I] · diag(S̃_u⁻¹, −C⁻¹) · [I BC⁻¹; 0 I]`, the inverse of `[A B; Bᵀ −C]` when
/// `S̃_u = S_u = A + B C⁻¹ Bᵀ`. B is B1, also where B2 ≠ B1ᵀ; of slip and opening [`ContactRows`] see to, or
/// [`EliminatedInverse`] around it.
///
/// # Cost
/// One solve with S̃_u, two with C, one product with B and one with Bᵀ, and that of a [`Relaxation`].
///
/// [`relaxed`](Self::relaxed) makes it `W M⁻¹ Wᵀ` ([`Relaxation`]).
///
/// # Source
/// A. Franceschini, M. Ferronato, M. Frigo, C. Janna, CMAME 392 (2022) 114632.
pub struct RacpInverse<'a> {
    b: Box<dyn AdjointOperator<f64> + 'a>,
    rows: Box<dyn ContactRows + 'a>,
    s_u: Box<dyn Preconditioner<f64> + 'a>,
    relaxation: Option<Relaxation<'a>>,
    layout: Layout,
}

impl<'a> RacpInverse<'a> {
    /// From exact parts: B, C and S̃_u⁻¹.
    pub fn new(
        b: SparseMatrix<f64>,
        c: AugmentationMatrix,
        s_u: impl Preconditioner<f64> + 'a,
    ) -> Self {
        Self::with_parts(Csr::with_transpose(b), c, s_u)
    }

    /// From exact parts, B being any operator that knows its adjoint: nothing needs to be assembled.
    pub fn with_parts(
        b: impl AdjointOperator<f64> + 'a,
        rows: impl ContactRows + 'a,
        s_u: impl Preconditioner<f64> + 'a,
    ) -> Self {
        let shape = b.shape();
        assert_eq!(shape.rows, s_u.size(), "rows of B and size of S_u");
        assert_eq!(shape.cols, rows.size(), "columns of B and size of C");
        Self {
            b: Box::new(b),
            rows: Box::new(rows),
            s_u: Box::new(s_u),
            relaxation: None,
            layout: Layout::new([(U, shape.rows), (T, shape.cols)]),
        }
    }

    /// `W M⁻¹ Wᵀ` ([`Relaxation`]); γ = 0 leaves M⁻¹ as published.
    #[must_use]
    pub fn relaxed(self, h: Box<dyn LinearOperator<f64> + 'a>, gamma: f64) -> Self {
        assert_eq!(h.shape().rows, self.rows.size(), "rows of H and size of C");
        let relaxation = Relaxation::new(h, gamma, &*self.rows);
        self.relaxed_by(relaxation)
    }

    /// `W M⁻¹ Wᵀ` with this W, or M⁻¹ itself.
    #[must_use]
    pub fn relaxed_by(self, relaxation: Option<Relaxation<'a>>) -> Self {
        Self { relaxation, ..self }
    }

    /// What W makes of a mode of tractions with the eigenvalue h of C⁻¹H; 1 where H is not relaxed.
    pub fn relaxation_at(&self, h: f64) -> f64 {
        self.relaxation.as_ref().map_or(1.0, |w| w.at(h))
    }

    /// W, where H is relaxed.
    pub(crate) fn w(&self) -> Option<&Relaxation<'a>> {
        self.relaxation.as_ref()
    }

    /// How H is relaxed.
    pub fn relaxation(&self) -> RelaxationSummary {
        (self.relaxation.as_ref()).map_or_else(RelaxationSummary::default, Relaxation::summary)
    }
}

impl Preconditioner<f64> for RacpInverse<'_> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        let (w_u, work) = work.split_at_mut(x_u.len());
        let (w_t, work) = work.split_at_mut(x_t.len());
        // w_t = Wᵀ x_k, y_t = C⁻¹ Wᵀ x_k + Λ⁻¹ x_l
        self.rows.keep(x_t, w_t);
        if let Some(w) = &self.relaxation {
            w.apply_transpose(&*self.rows, w_t, work);
        }
        self.rows.solve(w_t, y_t, work);
        self.rows.add_laws(x_t, y_t);
        // y_u = S̃_u⁻¹ (x_u + B y_t)
        w_u.copy_from_slice(x_u);
        self.b.apply_add(1.0, y_t, w_u, work);
        self.s_u.solve(w_u, y_u, work);
        // w_t = Bᵀ y_u − Wᵀ x_k
        w_t.iter_mut().for_each(|w| *w = -*w);
        self.b.apply_adjoint_add(1.0, y_u, w_t, work);
        // y_k = W C⁻¹ (Bᵀ y_u − Wᵀ x_k) = C⁻¹ Wᵀ (Bᵀ y_u − Wᵀ x_k)
        if let Some(w) = &self.relaxation {
            w.apply_transpose(&*self.rows, w_t, work);
        }
        self.rows.solve(w_t, y_t, work);
        // y_l = −Λ⁻¹ (x_l + L_lk y_k)
        self.rows.solve_laws(x_t, y_t);
    }

    fn work_len(&self) -> usize {
        let c = self.rows.work_len();
        let relaxation = (self.relaxation.as_ref()).map_or(0, |w| w.work_len(c));
        let inside = self.s_u.work_len().max(self.b.work_len()).max(c);
        self.layout.len() + inside.max(relaxation)
    }

    fn flops(&self) -> u64 {
        let c_inverse = self.rows.flops();
        let relaxation = (self.relaxation.as_ref()).map_or(0, |w| 2 * w.flops(c_inverse));
        let rows = 2 * c_inverse + self.rows.law_flops();
        rows + self.s_u.flops() + 2 * self.b.flops() + relaxation
    }

    fn properties(&self) -> Properties {
        self.s_u.properties().and(self.rows.properties())
    }
}

/// Settings of RACP. Rows that determine their own traction (slip, open) are eliminated first, see [`Elimination`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Racp {
    /// C.
    pub augmentation: AugmentationChoice,
    /// γ of the [`Relaxation`] of H, from 0 (none; with C = local_h the published method) to 1; without effect on a dense C.
    #[serde(deserialize_with = "crate::saddle::relaxation::factor")]
    pub relaxation: f64,
    /// S̃_u⁻¹.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
    /// The third field, where there is flow.
    #[serde(skip_serializing_if = "ThreeFields::is_default")]
    pub flow: ThreeFields,
}

impl Default for Racp {
    fn default() -> Self {
        Self {
            augmentation: AugmentationChoice::FittedH,
            relaxation: RELAXATION,
            inner: InnerChoice::default(),
            flow: ThreeFields::default(),
        }
    }
}

impl Racp {
    /// As published: C = C_local + diag(H), no relaxation. The spectrum laboratory states its bounds for this.
    pub fn published(inner: InnerChoice) -> Self {
        Self {
            augmentation: AugmentationChoice::LocalH,
            relaxation: 0.0,
            inner,
            flow: ThreeFields::default(),
        }
    }

    /// Around geometric multigrid, for scenes on a grid.
    pub fn geometric() -> Self {
        Self {
            inner: InnerChoice::Geometric(Geometric::default()),
            ..Self::default()
        }
    }

    /// True where S̃_u is that of a grid: A is never assembled then.
    pub fn is_matrix_free(&self) -> bool {
        matches!(self.inner, InnerChoice::Geometric(_))
    }

    /// M⁻¹ around an `inner` of these blocks without flow, which is given the F of `S_u = A + F Fᵀ` and may know A better than the blocks.
    pub(super) fn around<I: Into<Ready>>(
        &self,
        blocks: &SaddleBlocks,
        inner: impl Fn(&SparseMatrix<f64>) -> Result<I, SetupError>,
    ) -> Result<Ready, SetupError> {
        let by = |_: &SaddleBlocks, c: &AugmentationMatrix| {
            let f = &blocks.b1 * &c.inverse_root()?;
            inner(&f)
                .map(I::into)
                .map_err(|error| error.in_block("S_u"))
        };
        Ok(self.relaxed(blocks, None, by)?.0)
    }

    /// The inverse of `[A B; Bᵀ −H]` around what `inner` makes of C, and S_p where flow is given.
    fn relaxed(
        &self,
        blocks: &SaddleBlocks,
        flow: Option<&FlowBlocks>,
        inner: impl Fn(&SaddleBlocks, &AugmentationMatrix) -> Result<Ready, SetupError>,
    ) -> Result<(Ready, Option<PressureSystem>), SetupError> {
        let direct = self.inner.backend().solver()?;
        let start = Instant::now();
        let c = self.augmentation.compute(blocks, direct.as_ref())?.matrix;
        let c_s = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let Ready {
            inverse, hierarchy, ..
        } = inner(blocks, &c)?;
        let parts = PartCost {
            c_s,
            inner_s: start.elapsed().as_secs_f64(),
            inner_flops: inverse.flops(),
        };
        let s_p = match flow {
            Some(flow) => {
                let near = |rows| NearSchur::new(rows, (&blocks.a, &blocks.b1), &c);
                Some(self.flow.schur.system(flow, near, inverse.as_ref())?)
            }
            None => None,
        };
        // a dense C serves theory: it is left as it is
        let is_dense = matches!(c, AugmentationMatrix::Dense { .. });
        let relaxed = blocks.h.as_ref().filter(|_| !is_dense);
        let mut inverse = RacpInverse::new(blocks.b1.clone(), c, inverse);
        if let Some(h) = relaxed {
            inverse = inverse.relaxed(Box::new(Csr::new(h.clone())), self.relaxation);
        }
        let ready = Ready {
            relaxation: inverse.relaxation(),
            inverse: Box::new(inverse),
            hierarchy,
            parts: Some(parts),
        };
        Ok((ready, s_p))
    }

    /// The inverse of `[A B1; B2 −H]`, and S_p where flow is given.
    fn mechanics(
        &self,
        blocks: &SaddleBlocks,
        flow: Option<&FlowBlocks>,
    ) -> Result<(Ready, Option<PressureSystem>), SetupError> {
        let racp = |blocks: &SaddleBlocks| {
            self.relaxed(blocks, flow, |blocks, c| self.inner.prepare(blocks, c))
        };
        let Some(elimination) = Elimination::new(blocks) else {
            return racp(blocks);
        };
        match racp(elimination.kept()) {
            Ok((ready, s_p)) => {
                let whole = |inner| EliminatedInverse::new(elimination, inner);
                Ok((ready.inside(whole), s_p))
            }
            // A' may be indefinite where A is not: the rows are augmented like others
            Err(reduced) => racp(blocks).map_err(|_| reduced),
        }
    }

    /// With multigrid in f64.
    #[must_use]
    pub fn in_double(self) -> Self {
        let inner = self.inner.in_double().unwrap_or(self.inner);
        Self { inner, ..self }
    }
}

impl SaddleSettings for Racp {
    fn name(&self) -> &'static str {
        "racp"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        blocks.check()?;
        let Some(flow) = &blocks.flow else {
            return Ok(self.mechanics(blocks, None)?.0);
        };
        let (mut ready, s_p) = self.mechanics(blocks, Some(flow))?;
        let Some(s_p) = s_p else { return Ok(ready) };
        let s_p = PressureFactors::default().factor(&s_p)?;
        let form = self.flow.form.for_coupling(flow.is_coupled());
        if let Some(parts) = &mut ready.parts {
            parts.inner_flops *= form.solves();
        }
        let csr = |q: &SparseMatrix<f64>| Csr::new(q.clone());
        let (q1, q2) = (csr(&flow.q1), flow.is_coupled().then(|| csr(&flow.q2)));
        Ok(ready.inside(|ut| ThreeFieldsInverse::new(ut, q1, q2, s_p, form)))
    }

    fn augmentation(&self) -> Option<AugmentationChoice> {
        Some(self.augmentation)
    }

    fn set_augmentation(&mut self, c: AugmentationChoice) -> bool {
        self.augmentation = c;
        true
    }

    fn takes_flow(&self) -> bool {
        true
    }

    fn takes_local_rows(&self) -> bool {
        true
    }

    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        Some(&mut self.inner)
    }

    fn flow_mut(&mut self) -> Option<&mut ThreeFields> {
        Some(&mut self.flow)
    }
}

impl Prepare<SaddleBlocks, f64> for Racp {
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        Ok(self.ready(blocks)?.inverse)
    }
}
