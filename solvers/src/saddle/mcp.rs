//! The mixed constraint preconditioner: the published standard that RACP is measured against.

use super::inner::Ready;
use super::method::SaddleSettings;
use super::schur::primal_schur;
use super::{AugmentationMatrix, InnerChoice, SaddleBlocks, T, U};
use crate::SetupError;
use crate::eigen::{LanczosSettings, extreme_eigenvalues};
use crate::fsai::Fsai;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{AdjointOperator, Layout, LinearOperator, Preconditioner, Properties};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `M⁻¹ = [I −PB; 0 I]·diag(P, −S̃⁻¹)·[I 0; −BᵀP I]·[I γB; 0 I]`, `P ≈ (A + γBBᵀ)⁻¹`, `S̃ ≈ H + BᵀPB`. B is B1, also
/// where B2 ≠ B1ᵀ.
///
/// A may be singular, so the system is augmented first: the last factor adds γB times the contact rows to equilibrium,
/// `[A + γBB2, B(I − γH); B2, −H] y = [x_u + γB x_t; x_t]`, which has the same solution. Without that
/// factor exact parts would do as well, but an approximate P of A + γBBᵀ would meet A: 11 to 19 % more iterations on the
/// scenes `floating` and `crossing`. The factor I − γH stays out of the constraint
/// blocks: with exact P and `S̃ = H + T`, `T = BᵀPB`, the eigenvalues are 1 (n_u times) and those of
/// `I − γ(T⁻¹ + H⁻¹)⁻¹`, real, in `[1/(1 + γ λ_max(H)), 1]`. For H = 0 or γ = 0 all are 1.
///
/// # Cost
/// Two solves with P, one with S̃, three products with B or Bᵀ (two for γ = 0).
///
/// # Source
/// L. Bergamaschi, M. Ferronato, G. Gambolati, CMAME 196 (2007) 2647–2656, for the factorization; γ, P and S̃ are the
/// published choice of the authors of RACP.
pub struct McpInverse<P, S> {
    b: Csr<f64>,
    gamma: f64,
    p: P,
    s: S,
    layout: Layout,
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> McpInverse<P, S> {
    /// From exact parts: B, γ, `P ≈ (A + γBBᵀ)⁻¹` and `S̃⁻¹`.
    pub fn new(b: SparseMatrix<f64>, gamma: f64, p: P, s: S) -> Self {
        assert_eq!(b.rows(), p.size(), "rows of B and size of P");
        assert_eq!(b.cols(), s.size(), "columns of B and size of S");
        let layout = Layout::new([(U, b.rows()), (T, b.cols())]);
        Self {
            b: Csr::with_transpose(b),
            gamma,
            p,
            s,
            layout,
        }
    }
}

impl<P: Preconditioner<f64>, S: Preconditioner<f64>> Preconditioner<f64> for McpInverse<P, S> {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        let (v_u, work) = work.split_at_mut(x_u.len());
        let (w_t, work) = work.split_at_mut(x_t.len());
        // v_u = x_u + γ B x_t
        v_u.copy_from_slice(x_u);
        if self.gamma != 0.0 {
            self.b.apply_add(self.gamma, x_t, v_u, &mut []);
        }
        // y_u = P v_u
        self.p.solve(v_u, y_u, work);
        // w_t = Bᵀ y_u − x_t
        w_t.iter_mut().zip(x_t).for_each(|(w, x)| *w = -x);
        self.b.apply_adjoint_add(1.0, y_u, w_t, &mut []);
        // y_t = S̃⁻¹ w_t
        self.s.solve(w_t, y_t, work);
        // y_u = P (v_u − B y_t)
        self.b.apply_add(-1.0, y_t, v_u, &mut []);
        self.p.solve(v_u, y_u, work);
    }

    fn work_len(&self) -> usize {
        self.layout.len() + self.p.work_len().max(self.s.work_len())
    }

    fn flops(&self) -> u64 {
        let products = if self.gamma == 0.0 { 2 } else { 3 };
        2 * self.p.flops() + self.s.flops() + products * self.b.flops()
    }

    fn properties(&self) -> Properties {
        self.p.properties().and(self.s.properties())
    }
}

/// Settings of the mixed constraint preconditioner.
///
/// # Errors
/// [`SetupError::NotApplicable`] for γ < 0, and for γ = 0 where P finds A singular (a factorization and multigrid do; FSAI
/// and the smoothers of a singular A exist and are slow); otherwise those of P and of FSAI, with the name of the block.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mcp {
    /// γ of A + γBBᵀ over the published `λ_max(A) / geometric mean of the positive diag(BBᵀ)`: 1 is the published choice,
    /// 0 classical MCP on A itself. A factor has no unit, γ has.
    pub gamma_factor: f64,
    /// P.
    #[schemars(with = "crate::saddle::inner::NameOrSettings")]
    pub inner: InnerChoice,
    /// G with `GᵀG ≈ (A + γBBᵀ)⁻¹` in `S = H + (GB)ᵀ(GB)`, and G₂₂ with `G₂₂ᵀG₂₂ ≈ S⁻¹`.
    pub schur: Fsai,
}

impl Default for Mcp {
    fn default() -> Self {
        Self {
            gamma_factor: 1.0,
            inner: InnerChoice::default(),
            schur: Fsai::default(),
        }
    }
}

/// Name of A + γBBᵀ in errors.
const A_GAMMA: &str = "A + γ B1 B1ᵀ";

impl SaddleSettings for Mcp {
    fn name(&self) -> &'static str {
        "mcp"
    }

    fn ready(&self, blocks: &SaddleBlocks) -> Result<Ready, SetupError> {
        let factor = self.gamma_factor;
        if !(factor >= 0.0 && factor.is_finite()) {
            return Err(SetupError::NotApplicable {
                method: "mcp",
                reason: format!("the factor of γ is {factor:e}; it is a number ≥ 0"),
            });
        }
        let gamma = if factor == 0.0 {
            0.0
        } else {
            factor * published_gamma(blocks)?
        };
        let augmented;
        let a = if gamma > 0.0 {
            let c = AugmentationMatrix::from_diagonal(vec![gamma.recip(); blocks.n_t()])?;
            augmented = primal_schur(&blocks.a, &blocks.b1, &c)?;
            &augmented
        } else {
            &blocks.a
        };
        let about_a = |error| on_a(error, gamma);
        // S = H + (GB)ᵀ(GB)
        let g = self.schur.build(a).map_err(about_a)?;
        let gb = g.g().matrix() * &blocks.b1;
        let gram = &gb.transpose_view().to_csr() * &gb;
        let s = blocks
            .h
            .as_ref()
            .map_or_else(|| gram.clone(), |h| h + &gram);
        let g22 = self
            .schur
            .build(&s)
            .map_err(|error| error.in_block("S = H + (GB)ᵀ(GB)"))?;
        let p = if self.inner == InnerChoice::Fsai(self.schur) {
            // P = GᵀG with the G at hand
            Ready::from(Box::new(g) as Box<dyn Preconditioner<f64>>)
        } else {
            let coordinates = blocks.coordinates.as_deref();
            self.inner.of_matrix(a, coordinates).map_err(about_a)?
        };
        Ok(p.inside(|p| McpInverse::new(blocks.b1.clone(), gamma, p, g22)))
    }

    fn inner_mut(&mut self) -> Option<&mut InnerChoice> {
        Some(&mut self.inner)
    }
}

/// `γ = λ_max(A) / geometric mean of the positive diag(BBᵀ)`; 1 where B has no entries.
///
/// # Errors
/// [`SetupError`] where the largest eigenvalue of A is not found.
pub fn published_gamma(blocks: &SaddleBlocks) -> Result<f64, SetupError> {
    let a = Csr::new(blocks.a.clone());
    let mut product = |x: &[f64], y: &mut [f64]| a.apply(x, y, &mut []);
    let settings = LanczosSettings::one_sided();
    let (_, high) = extreme_eigenvalues(blocks.n_u(), &mut product, None, settings)?;
    let squares = blocks
        .b1
        .outer_iterator()
        .map(|row| row.data().iter().map(|b| b * b).sum::<f64>());
    let logarithms: Vec<f64> = squares.filter(|s| *s > 0.0).map(f64::ln).collect();
    if logarithms.is_empty() {
        return Ok(1.0);
    }
    let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
    Ok(high.value / mean.exp())
}

/// Names the block; for γ = 0 a singular A means that the method does not apply.
fn on_a(error: SetupError, gamma: f64) -> SetupError {
    match error.in_block(if gamma > 0.0 { A_GAMMA } else { "A" }) {
        singular @ (SetupError::Singular { .. }
        | SetupError::NotPositiveDefinite { .. }
        | SetupError::BadDiagonal { .. })
            if gamma == 0.0 =>
        {
            SetupError::NotApplicable {
                method: "mcp with γ = 0",
                reason: format!("it needs a positive definite A ({singular}); take γ > 0"),
            }
        }
        named => named,
    }
}
