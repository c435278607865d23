//! The augmented Lagrangian preconditioner.

use super::inner::Ready;
use super::method::SaddleSettings;
use super::{AugmentationChoice, AugmentationMatrix, InnerChoice, SaddleBlocks, T, U};
use crate::SetupError;
use crate::direct::DirectChoice;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{Layout, LinearOperator, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M⁻¹ = [S̃_u B(I − C⁻¹H); 0 −C]⁻¹ · [I BC⁻¹; 0 I]`, `S̃_u ≈ A + B C⁻¹Bᵀ`. B is B1, also where B2 ≠ B1ᵀ.
///
/// The last factor augments the system, `[A + BC⁻¹B2, B(I − C⁻¹H); B2, −H] y = [x_u + BC⁻¹x_t; x_t]`, and the first one
/// is its block triangle with C for the Schur complement. The classical form is `C = W/γ` with W = I: the global
/// augmentation. With exact S_u the eigenvalues are those of RACP: 1 (n_u times) and eig(S + H, S + C), `S = BᵀA⁻¹B`.
///
/// # Cost
/// One solve with S̃_u, one with C, one product with B; another solve with C and a product with H where there is one.
///
/// # Source
/// M. Benzi, M. A. Olshanskii, SIAM J. Sci. Comput. 28 (2006) 2095–2113.
pub struct AugmentedLagrangianInverse<P> {
    b: Csr<f64>,
    h: Option<Csr<f64>>,
    c: AugmentationMatrix,
    s_u: P,
    layout: Layout,
}

impl<P: Preconditioner<f64>> AugmentedLagrangianInverse<P> {
    /// From exact parts: B, H, C and S̃_u⁻¹.
    pub fn new(
        b: SparseMatrix<f64>,
        h: Option<SparseMatrix<f64>>,
        c: AugmentationMatrix,
        s_u: P,
    ) -> Self {
        assert_eq!(b.rows(), s_u.size(), "rows of B and size of S_u");
        assert_eq!(b.cols(), c.size(), "columns of B and size of C");
        let layout = Layout::new([(U, b.rows()), (T, b.cols())]);
        Self {
            b: Csr::new(b),
            h: h.map(Csr::new),
            c,
            s_u,
            layout,
        }
    }
}

impl<P: Preconditioner<f64>> Preconditioner<f64> for AugmentedLagrangianInverse<P> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        let (v_u, work) = work.split_at_mut(x_u.len());
        let (w_t, work) = work.split_at_mut(x_t.len());
        // y_t = −C⁻¹ x_t
        self.c.solve(x_t, y_t, work);
        y_t.iter_mut().for_each(|y| *y = -*y);
        // w_t = C⁻¹ H y_t
        w_t.fill(0.0);
        if let Some(h) = &self.h {
            let (h_t, work) = work.split_at_mut(x_t.len());
            h.apply(y_t, h_t, &mut []);
            self.c.solve(h_t, w_t, work);
        }
        // v_u = x_u + B C⁻¹ x_t − B(I − C⁻¹H) y_t = x_u − B (2 y_t − C⁻¹H y_t)
        w_t.iter_mut()
            .zip(&*y_t)
            .for_each(|(w, y)| *w = 2.0 * y - *w);
        v_u.copy_from_slice(x_u);
        self.b.apply_add(-1.0, w_t, v_u, &mut []);
        // y_u = S̃_u⁻¹ v_u
        self.s_u.solve(v_u, y_u, work);
    }

    fn work_len(&self) -> usize {
        let c = self.layout.length(T) + Preconditioner::work_len(&self.c);
        self.layout.len() + self.s_u.work_len().max(c)
    }

    fn flops(&self) -> u64 {
        let c = Preconditioner::flops(&self.c);
        let stabilized = self.h.as_ref().map_or(0, |h| h.flops() + c);
        c + stabilized + self.s_u.flops() + self.b.flops()
    }

    fn properties(&self) -> Properties {
        let parts = self.s_u.properties().and(self.c.properties());
        // y_t is −C⁻¹x_t
        parts.and(Properties::BLIND)
    }
}

/// Settings of the augmented Lagrangian preconditioner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AugmentedLagrangian {
    /// C = W/γ; global is the classical W = I.
    pub augmentation: AugmentationChoice,
    /// S̃_u⁻¹.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
}

impl Default for AugmentedLagrangian {
    fn default() -> Self {
        Self {
            augmentation: AugmentationChoice::Global,
            inner: InnerChoice::default(),
        }
    }
}

impl SaddleSettings for AugmentedLagrangian {
    fn name(&self) -> &'static str {
        "augmented_lagrangian"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        let direct = DirectChoice::default().solver()?;
        let c = self.augmentation.compute(blocks, direct.as_ref())?.matrix;
        let s_u = self.inner.prepare(blocks, &c)?;
        let (b, h) = (blocks.b1.clone(), blocks.h.clone());
        Ok(s_u.inside(|s_u| AugmentedLagrangianInverse::new(b, h, c, s_u)))
    }

    fn augmentation(&self) -> Option<AugmentationChoice> {
        Some(self.augmentation)
    }

    fn set_augmentation(&mut self, c: AugmentationChoice) -> bool {
        self.augmentation = c;
        true
    }

    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        Some(&mut self.inner)
    }
}
